"""Claims about the loader crane: it is another machine than the C-180, and its geometry is sound."""

import math

import numpy as np
import pytest

from forest_description.config.source_tree import read
from forest_description.config.units import UNITS
from forest_description.derived.limits import joint_limits, workspace_limits
from forest_description.export.machine_numbers import choices, declared
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine, sources

LOADER, C180 = load_machine("loader"), load_machine("c180_hoses")
NEUTRAL = (0.0, 1.0)
"""Numbers that say "none" or "as it is"; any two machines may share them."""


def in_si(name):
    """Return every number of a machine, in SI, by dotted key."""
    found = {}
    for row in sources(name):
        for k, value in enumerate(row.value if isinstance(row.value, tuple) else (row.value,)):
            found[row.key, k] = value * UNITS[row.unit].factor
    return found


def test_it_is_told_from_scratch():
    text = read("loader").children
    assert "based_on" not in text
    assert {child.place.split(":")[0] for child in text.values()} == {"loader.yaml"}


def test_it_shares_no_number_with_the_c180():
    ours, theirs = in_si("loader"), in_si("c180_hoses")
    both = {key: ours[key] for key in ours.keys() & theirs.keys() if ours[key] not in NEUTRAL}
    assert len(both) > 60
    assert [key for key, value in both.items() if math.isclose(value, theirs[key], rel_tol=1e-3)] == []


def test_it_says_where_every_number_comes_from():
    rows = sources("loader")
    assert {row.key for row in rows} == set(declared(LOADER)) - {
        key for key, word in choices(LOADER).items() if word == "none"
    }
    assert all(row.source.startswith("assumed: ") and len(row.source) > 20 for row in rows)


def test_it_uses_what_the_c180_does_not():
    m = LOADER
    assert m.pump.kind == "load_sensing"
    assert m.valve.backward is not None
    assert m.valve.port_2_area < 1.0
    assert m.valve.leakage_conductance > 0.0
    assert m.valve.spool_damping is not None
    assert [m.valve_of(axis).rated_voltage for axis in range(3)] == [6.0, 8.0, 8.0]
    assert m.stick.valve.curve.kind == "table"
    assert all(d.friction is not None and d.cushion is not None for d in (m.boom, m.stick))
    assert [d.flow_regime for d in (m.swing, m.boom, m.stick)] == ["turbulent", "laminar", "turbulent"]
    assert m.manipulator.pendulum is not None
    assert (m.hose.kind, m.swing.hose.kind) == ("geometric", "geometric")
    assert m.swing.hose.bore < m.hose.bore
    assert m.sensors.linear_transducer is None


def test_an_axis_own_valve_says_only_what_differs():
    swing, stick, shared = LOADER.swing.valve, LOADER.stick.valve, LOADER.valve
    assert LOADER.boom.valve is None
    assert (stick.deadband_voltage, stick.backward) == (shared.deadband_voltage, shared.backward)
    assert (swing.spool_bandwidth, swing.leakage_conductance) == (
        shared.spool_bandwidth,
        shared.leakage_conductance,
    )
    assert swing.backward is None


@pytest.mark.parametrize("axis", [1, 2], ids=["boom", "stick"])
def test_the_linkage_closes_with_room_and_keeps_its_lever_arm_over_the_stroke(axis):
    drive = (LOADER.boom, LOADER.stick)[axis - 1]
    a, b = drive.pivot_to_base, drive.pivot_to_rod
    assert drive.retracted_length - abs(a - b) > 0.05
    assert a + b - drive.retracted_length - drive.stroke > 0.05
    arms = [lever_arm(angle, drive.linkage) for angle in np.linspace(*joint_limits(LOADER)[axis], 101)]
    assert min(arms) > 0.15
    assert max(arms) <= min(a, b)


@pytest.mark.parametrize(("axis", "low", "high"), [(0, -210.0, 210.0), (1, -16.2, 70.3), (2, -130.4, -36.7)])
def test_joint_ranges_are_those_that_the_file_tells_of(axis, low, high):
    assert np.degrees(joint_limits(LOADER)[axis]) == pytest.approx((low, high), abs=0.05)


def test_reach_and_areas_are_those_that_the_file_tells_of():
    assert workspace_limits(LOADER).reach_max == pytest.approx(4.2, abs=0.05)
    for drive, bore, rod in ((LOADER.boom, 0.080, 0.045), (LOADER.stick, 0.070, 0.040)):
        assert drive.head_area == pytest.approx(0.25 * math.pi * bore**2, rel=1e-4)
        assert drive.rod_area == pytest.approx(0.25 * math.pi * (bore**2 - rod**2), rel=1e-4)
    m = LOADER.manipulator
    assert 150.0 < m.base_mass + m.boom_mass + m.stick_mass + m.head_mass < 250.0
