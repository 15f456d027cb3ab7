import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator import joystick_interpolation
from forest_control.operator.joystick_sources import thesis_levers
from forest_control.operator.levers import REST
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.compiled_loop import by_heart as run

SPEED, SECONDS = 0.5, 4.0  # [m/s], [s]
C180 = load_machine("c180_hoses")


def greatest_error(period, held):
    """Greatest distance [m] of the tip from its wish, with a joystick of so long a period [s]."""
    heard, said, hold, every = REST, 0.0, joystick_interpolation.CENTRED, round(period / PERIOD)

    def operator(time):
        nonlocal heard, said, hold
        if round(time / PERIOD) % every == 0:
            heard, said = thesis_levers(time - 0.2, SPEED) if time > 0.2 else REST, time
        hold = joystick_interpolation.interpolated(hold, heard, said, time, PERIOD)
        return Operator(hold.levers if held else heard, enabled=True)

    start = pose_at(start_tip(C180), C180)
    moved = run(
        C180, operator, SECONDS, start, controller_settings.Settings(), valve_driver_parameters.Settings()
    )
    return np.linalg.norm(moved.tip_error(), axis=1).max()


@pytest.mark.parametrize("period", [0.01, 0.05])
def test_a_slow_joystick_leads_the_tip_as_well_as_a_quick_one(period):
    assert greatest_error(period, held=True) < 0.012
    assert greatest_error(period, held=False) > 0.02  # a staircase throws the swing's valve to and fro
