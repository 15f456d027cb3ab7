"""A sensor that stands still while its joint is told to move is not believed; a joint that rests is."""

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.pipeline.controller import to_voltage
from forest_control.safety.frozen_sensor import MOVING, Stillness, frozen, is_frozen, updated_stillness
from forest_description.machine import load_machine
from forest_description.types import AXES

P = controller_settings.parameters(load_machine("c180_hoses"), controller_settings.Settings())._replace(
    rated_speeds=(0.4, 0.2, 0.3), rated_voltages=(10.0, 9.0, 8.0)
)
DT = 0.005
START = (0.2, 0.4, -1.5)
every_joint = pytest.mark.parametrize("joint", range(3), ids=AXES)


def after(seconds, rates, angles):
    """What `frozen` says first, and when; `angles(time)` is what the sensors read."""
    still = MOVING
    for step in range(round(seconds / DT)):
        s = angles(step * DT)
        still = updated_stillness(still, s, to_voltage(rates, s, P), P, DT)
        assert is_frozen(still) == bool(frozen(still))
        if frozen(still):
            return step * DT, frozen(still)
    return seconds, ""


def stuck(joint, at, rate):
    """Angles of joints that move at a rate [rad/s], but one that stays at an angle [rad]."""

    def angles(time):
        moved = [angle + rate * time for angle in START]
        moved[joint] = at
        return tuple(moved)

    return angles


@every_joint
@pytest.mark.parametrize("at", [START, (0.0, 0.0, 0.0)], ids=["anywhere", "at zero"])
@pytest.mark.parametrize("rate", [0.1, -0.1], ids=["up", "down"])
def test_a_joint_whose_sensor_is_frozen_is_named_soon(joint, at, rate):
    when, said = after(1.0, (rate, rate, rate), stuck(joint, at[joint], rate))
    assert when == pytest.approx(0.2, abs=2.1 * DT)  # 0.02 rad
    assert said.startswith(f"joint state: {AXES[joint]} is the same to the last bit")


@every_joint
@pytest.mark.parametrize("at", [START, (0.0, 0.0, 0.0)], ids=["anywhere", "at zero"])
@pytest.mark.parametrize("rate", [0.3, -0.3], ids=["up", "down"])
def test_a_quick_joint_has_time_to_begin(joint, at, rate):
    when, _ = after(1.0, (rate, rate, rate), stuck(joint, at[joint], rate))
    assert when == pytest.approx(0.15, abs=2.1 * DT)


@every_joint
def test_to_and_fro_counts_as_way_in_both_directions(joint):
    still = MOVING
    for step in range(60):
        sign = (-1.0) ** (step // 5)
        still = updated_stillness(still, START, to_voltage((sign * 0.1,) * 3, START, P), P, DT)
    assert still.ways[joint] == pytest.approx(59 * DT * 0.1)
    assert frozen(still)


def test_a_sample_that_differs_clears_its_own_joint_alone():
    still, command = MOVING, to_voltage((0.1, 0.1, 0.1), START, P)
    for joint in range(3):
        for _ in range(10):
            still = updated_stillness(still, START, command, P, DT)
        moved = tuple(angle + (i == joint) * 1e-12 for i, angle in enumerate(START))
        after_it = updated_stillness(still, moved, command, P, DT)
        for other in range(3):
            assert (after_it.ways[other] == 0.0) == (after_it.times[other] == 0.0) == (other == joint)


@every_joint
def test_at_the_bounds_themselves_a_joint_is_still_believed(joint):
    def bounds(way, time):
        quiet = [0.0, 0.0, 0.0]
        ways, times = (tuple(x if i == joint else y for i, y in enumerate(quiet)) for x in (way, time))
        still = Stillness(START, ways, times)
        assert is_frozen(still) == bool(frozen(still))
        return frozen(still)

    assert bounds(0.02, 1.0) == ""
    assert bounds(1.0, 0.15) == ""
    assert AXES[joint] in bounds(0.0201, 0.1501)


def test_a_crane_that_rests_or_is_slow_on_a_coarse_sensor_is_believed():
    step = 2.0 * np.pi / 4096  # of 12 bits
    coarse = lambda time: (step * (0.03 * time // step), *START[1:])  # noqa: E731
    assert after(3.0, (0.03, 0.0, 0.0), coarse)[1] == ""
    assert after(3.0, (0.0, 0.0, 0.0), lambda time: START)[1] == ""
    assert after(3.0, (0.0, 0.006, 0.0), lambda time: START)[1] == ""
