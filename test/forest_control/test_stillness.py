"""A sensor that stands still while its joint is told to move is not believed; a joint that rests is."""

import numpy as np
import pytest

from forest_control import controller
from forest_control.execution import to_voltage
from forest_control.stillness import LONG, MOVING, WAY, frozen, watched
from forest_description.machine import load_machine

P = controller.parameters(load_machine("c180"), controller.Settings())
DT = 0.005
START = (0.2, 0.4, -1.5)


def after(seconds, rates, angles):
    """What `frozen` says first, and when; `angles(time)` is what the sensors read."""
    still = MOVING
    for step in range(round(seconds / DT)):
        s = angles(step * DT)
        still = watched(still, s, to_voltage(rates, s, P), P, DT)
        if frozen(still):
            return step * DT, frozen(still)
    return seconds, ""


@pytest.mark.parametrize("joint", [0, 1, 2])
def test_a_joint_whose_sensor_is_frozen_is_named_soon(joint):
    def angles(time):
        moved = [angle + 0.1 * time for angle in START]
        moved[joint] = START[joint]
        return tuple(moved)

    when, said = after(1.0, (0.1, 0.1, 0.1), angles)
    assert when == pytest.approx(WAY / 0.1, abs=2.1 * DT)
    assert said.startswith(f"joint state: {('swing', 'boom', 'stick')[joint]} is the same to the last bit")


def test_a_quick_joint_has_time_to_begin():
    when, _ = after(1.0, (0.0, 1.0, 0.0), lambda time: START)
    assert when == pytest.approx(LONG, abs=2.1 * DT)


def test_a_crane_that_rests_or_is_slow_on_a_coarse_sensor_is_believed():
    step = 2.0 * np.pi / 4096  # of 12 bits
    coarse = lambda time: (step * (0.03 * time // step), *START[1:])  # noqa: E731
    assert after(3.0, (0.03, 0.0, 0.0), coarse)[1] == ""
    assert after(3.0, (0.0, 0.0, 0.0), lambda time: START)[1] == ""
    assert after(3.0, (0.0, 0.006, 0.0), lambda time: START)[1] == ""
