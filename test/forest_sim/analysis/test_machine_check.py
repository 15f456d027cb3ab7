"""What `forest-sim check` warns of: machines that are possible and not wise."""

import dataclasses

import pytest

from forest_description.machine import load_machine
from forest_sim.analysis.machine_check import warnings

C180 = load_machine("c180_hoses")


def changed(section, **numbers):
    return dataclasses.replace(C180, **{section: dataclasses.replace(getattr(C180, section), **numbers)})


def sensors(kind, **numbers):
    return changed("sensors", **{kind: dataclasses.replace(getattr(C180.sensors, kind), **numbers)})


def inertia(link, about, xx):
    """The moments of a link about a place this far [m] from its centre, as if they were about the centre."""
    m = C180.manipulator
    added = getattr(m, f"{link}_mass") * about**2
    yy, zz = getattr(m, f"{link}_yy") + added, getattr(m, f"{link}_zz") + added
    return changed("manipulator", **{f"{link}_xx": xx, f"{link}_yy": yy, f"{link}_zz": zz})


def told(machine):
    return [text for text in warnings(machine) if "one lump" not in text]


def test_the_shipped_machines_have_nothing_else_than_their_hoses_to_warn_of():
    for name in ("c180_hoses", "loader"):
        assert told(load_machine(name)) == []


@pytest.mark.parametrize(
    ("machine", "parts"),
    [
        (
            sensors("resolver", full_scale=5.5),
            ["swing: its resolver shows -158 .. 158 deg", "-180.0 to 180.0"],
        ),
        (sensors("linear_transducer", full_scale=0.9), ["boom: its linear", "stick: its linear"]),
        (sensors("pressure", full_scale=2e7), ["end at 20.0 MPa, below the pump's 20.7 MPa"]),
        (
            inertia("boom", C180.manipulator.boom_x, 78.0),
            ["boom_yy, boom_zz: about its centre of mass, 635.04 kg", "about the joint?"],
        ),
        (inertia("stick", 2.0, 332.0), ["stick_yy, stick_zz: about its centre"]),
    ],
    ids=["resolver", "transducer", "pressure", "boom's inertia", "stick's inertia"],
)
def test_what_is_not_wise_is_told(machine, parts):
    found = "\n".join(told(machine))
    assert found
    for part in parts:
        assert part in found


def test_a_resolver_that_ends_on_one_side_only_is_told():
    folded = dataclasses.replace(C180.sensors.resolver, full_scale=4.0)
    swing = dataclasses.replace(C180.swing, lower_limit=-1.0, upper_limit=1.0)
    machine = dataclasses.replace(
        C180, swing=swing, sensors=dataclasses.replace(C180.sensors, resolver=folded)
    )
    (sentence,) = told(machine)
    assert sentence.startswith(
        "stick: its resolver shows -115 .. 115 deg, the joint goes from -121.0 to -50.0 deg"
    )
