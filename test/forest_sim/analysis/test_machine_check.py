"""What `forest-sim check` warns of: machines that are possible and not wise."""

import dataclasses

import pytest

from forest_description.hydraulics.load_holding_parameters import RuptureValve
from forest_description.machine import load_machine
from forest_description.sensors.sensor_kinds import InertialUnit
from forest_sim.analysis.machine_check import warnings

C180, FORWARDER = load_machine("c180_hoses"), load_machine("forwarder")


def changed(section, base=C180, **numbers):
    return dataclasses.replace(base, **{section: dataclasses.replace(getattr(base, section), **numbers)})


def sensors(kind, **numbers):
    return changed("sensors", **{kind: dataclasses.replace(getattr(C180.sensors, kind), **numbers)})


def by_inertia(stick_distance=1.0, joint_angles="inertial_unit", **others):
    unit = InertialUnit(1.0, stick_distance, 5.0, None, None, None, None)
    return changed("sensors", inertial_unit=unit, joint_angles=joint_angles, **others)


def inertia(link, about, xx):
    """The moments of a link about a place this far [m] from its centre, as if they were about the centre."""
    m = C180.manipulator
    added = getattr(m, f"{link}_mass") * about**2
    yy, zz = getattr(m, f"{link}_yy") + added, getattr(m, f"{link}_zz") + added
    return changed("manipulator", **{f"{link}_xx": xx, f"{link}_yy": yy, f"{link}_zz": zz})


def holding(port, pressure, hysteresis):
    """The forwarder with a counterbalance valve of another setting and hysteresis [Pa] in its boom."""
    valve = dataclasses.replace(FORWARDER.boom.holding_1, setting=pressure, hysteresis=hysteresis)
    return changed("boom", FORWARDER, **{port: valve})


def charted(share):
    """The forwarder with a load chart that allows this share of its own."""
    load = tuple(share * kg for kg in FORWARDER.capacity.load)
    return dataclasses.replace(FORWARDER, capacity=dataclasses.replace(FORWARDER.capacity, load=load))


def bursting(litres_per_minute):
    """The forwarder with a hose-rupture valve at its boom that shuts at a flow."""
    return changed("boom", FORWARDER, holding_1=RuptureValve(litres_per_minute / 6e4, 1e11, 0.01))


def told(machine):
    return [text for text in warnings(machine) if "one lump" not in text]


def test_the_shipped_machines_have_nothing_else_than_their_hoses_to_warn_of():
    for name in ("c180_hoses", "loader", "c180", "forwarder"):
        assert told(load_machine(name)) == []


@pytest.mark.parametrize(
    ("machine", "parts"),
    [
        (
            sensors("resolver", full_scale=5.5),
            ["swing: its resolver shows -158 .. 158 deg", "-180.0 to 180.0"],
        ),
        (sensors("linear_transducer", full_scale=0.9), ["boom: its linear", "stick: its linear"]),
        (by_inertia(stick_distance=5.0), ["stick: its inertial unit is 5 m along its 4.2991 m"]),
        (by_inertia(joint_angles=None), ["sensors.inertial_unit: nothing reads it"]),
        (by_inertia(resolver=None), ["swing: nothing tells its angle; sensors.resolver does"]),
        (
            dataclasses.replace(FORWARDER, sensors=dataclasses.replace(FORWARDER.sensors, pressure=None)),
            [
                "capacity without sensors.pressure: no load is weighed",
                "boom: behind a compensator and a counterbalance valve it rocks undamped",
                "stick: behind",
            ],
        ),
        (sensors("pressure", full_scale=2e7), ["end at 20.0 MPa, below the pump's 20.7 MPa"]),
        (
            inertia("boom", C180.manipulator.boom_x, 78.0),
            ["boom_yy, boom_zz: about its centre of mass, 635.04 kg", "about the joint?"],
        ),
        (inertia("stick", 2.0, 332.0), ["stick_yy, stick_zz: about its centre"]),
        (
            changed("chassis", FORWARDER, mass=13.5),
            [
                "chassis: its 13.5 kg do not hold the empty crane: margin -",
                "against tipping over (left) with",
            ],
        ),
        (
            holding("holding_1", 10e6, 1e6),
            [
                "boom: holding the crane still takes 1",
                "its counterbalance valve's reseating pressure of 9.0 MPa",
            ],
        ),
        (
            holding("holding_1", 30e6, 20e6),
            [
                "its counterbalance valve's reseating pressure of 10.0 MPa",
                "boom.holding_1: the oil that it shuts in may come to its setting, 30.0 MPa, above the port",
            ],
        ),
        (
            charted(1.5),
            [
                "capacity: at 4.0 m it allows 30",
                " kg, for which the boom's cylinder takes 3",
                "the pump's 24.0 MPa",
            ],
        ),
        (
            dataclasses.replace(
                load_machine("c180"),
                valve=dataclasses.replace(load_machine("c180").valve, spool_slew_limit=2.0),
            ),
            [
                f"{axis}: its spool takes 5 s from the centre to full open by its spool_slew_limit of 2 V/s"
                for axis in ("swing", "boom", "stick")
            ],
        ),
        (
            bursting(80.0),
            ["boom.holding_1: more than 80 L/min shut it, and at full speed 1", "L/min leave the boom"],
        ),
    ],
    ids=[
        "resolver",
        "transducer",
        "unit beyond its link",
        "unit that nobody reads",
        "no swing",
        "no pressures",
        "pressure",
        "boom's inertia",
        "stick's inertia",
        "chassis",
        "setting under the load",
        "setting over the relief",
        "chart over the cylinder",
        "slow spool",
        "rupture valve under full speed",
    ],
)
def test_what_is_not_wise_is_told(machine, parts):
    found = "\n".join(told(machine))
    assert found
    for part in parts:
        assert part in found


def test_a_chart_within_the_cylinder_and_a_rupture_valve_above_full_speed_are_wise():
    assert told(charted(1.0)) == []
    assert told(bursting(250.0)) == []


def test_a_resolver_that_is_not_there_is_not_judged():
    short = dataclasses.replace(C180.sensors.resolver, full_scale=6.2)
    assert told(by_inertia(resolver=short)) == told(changed("sensors", resolver=short))[:1]
    assert told(by_inertia()) == []


def test_a_valve_that_damps_by_itself_needs_no_pressures():
    crane = load_machine("c180")
    assert crane.boom.holding_1 is not None
    blind = dataclasses.replace(
        crane, capacity=None, sensors=dataclasses.replace(crane.sensors, pressure=None)
    )
    assert told(blind) == told(crane)


def test_a_valve_at_the_unloaded_side_may_open_early():
    """Under its own weight a boom presses its head side alone."""
    assert told(holding("holding_2", 5e6, 1e6)) == []


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
