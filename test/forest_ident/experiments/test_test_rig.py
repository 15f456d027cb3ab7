"""A rig holds the valve or the hose of a crane, and nothing of its swing."""

import pytest

from forest_description.machine import load_machine
from forest_ident.experiments import test_rig as rig

SWING_ONLY = ("chambers", "friction", "backlash", "holding_1", "holding_2", "elasticity")


@pytest.mark.parametrize("name", ["c180_hoses", "loader", "forwarder"])
def test_friction_play_and_twist_of_the_swing_stay_on_the_crane(name):
    machine = load_machine(name)
    for bench in (rig.valve_bench(machine), rig.hose_bench(machine)):
        assert [getattr(bench.swing, part) for part in SWING_ONLY] == [None] * len(SWING_ONLY)
