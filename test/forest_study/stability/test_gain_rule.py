"""The gains that the rule makes of a machine's file, against the margins of the machine's own equations."""

import math

import pytest

from forest_control.config.controller_settings import Settings
from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine
from forest_sim.simulation.open_loop import start_angles
from forest_study.stability.margins import margins
from forest_study.stability.position_loop import FREQUENCY, position_loop

SHIPPED = ("c180_thesis", "c180_hoses", "c180", "loader", "forwarder")
DRAWN = ("unknown:1", "unknown:2", "unknown:3", "unknown:4", "unknown:5")


@pytest.mark.parametrize("name", [*SHIPPED, *DRAWN])
def test_every_joint_has_its_margins_by_the_rule(name):
    machine = load_machine(name)
    angles = start_angles(machine, start_tip(machine))
    for axis in range(3):
        loop = position_loop(machine, angles, axis, 4.0, Settings())
        found = margins(FREQUENCY, loop.controlled)
        assert 20.0 * math.log10(found.gain) > 8.0, (axis, loop.gains)
        assert found.phase > 40.0, (axis, loop.gains)
        assert loop.gains[0] > 0.5
