"""Claims about the delay that a hand feels: as long as that of a true step in simulated time."""

import numpy as np
import pytest

from forest_bag.read.timeseries import Series, bag_of
from forest_control.config import controller_settings
from forest_control.operator import joystick_interpolation
from forest_control.operator.levers import REST, Levers, axes_from_levers
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.compiled_loop import by_heart as run
from forest_study.latency.lever_delay import lever_to_valve_ms

C180 = load_machine("c180_hoses")
SECONDS, THROWN = 1.6, 0.5  # [s]
PUSHED = Levers(0.0, 0.0, 0.6)
NOTHING = {"first": None, "half_step": None, "half_way": None}
LATER = 1_000_000  # [ns] after its state a voltage is heard


def thrown(time):
    return PUSHED if time >= THROWN - 1e-9 else REST


def wave(time):
    return Levers(0.6 * np.sin(2.0 * np.pi * 0.8 * time), 0.0, 0.0)


def driven(hand, period, interpolated=True):
    """A session in simulated time with a joystick of so long a period [s]."""
    heard, said, hold, every = REST, 0.0, joystick_interpolation.CENTRED, round(period / PERIOD)

    def operator(time):
        nonlocal heard, said, hold
        if round(time / PERIOD) % every == 0:
            heard, said = hand(time), time
        hold = joystick_interpolation.interpolated(hold, heard, said, time, PERIOD)
        return Operator(hold.levers if interpolated else heard)

    start = pose_at(start_tip(C180), C180)
    return run(
        C180, operator, SECONDS, start, controller_settings.Settings(), valve_driver_parameters.Settings()
    )


def series(topic, values, stamps, later=0):
    values = np.asarray(values, dtype=float)
    return Series(stamps, stamps + later, values, topic.labels, topic.units, 0)


def recorded(moved, hand, period, wish=topics.TIP_TWIST_COMMAND):
    """The bag of a session; in the joint scheme the tip's wish is not in it."""
    steps = 1_000_000_000 + round(PERIOD * 1e9) * np.arange(len(moved.voltages))
    every = slice(None, None, round(period / PERIOD))
    joy = [axes_from_levers(hand(k * PERIOD)) for k in range(len(steps))[every]]
    padded = np.hstack([moved.tip_wish, np.zeros_like(moved.tip_wish)])
    status = np.tile([1.0, 0.0, 1.0, 1.0, 0.0], (len(steps), 1))
    told = {
        topics.JOY: series(topics.JOY, joy, steps[every]),
        topics.JOINT_STATES: series(topics.JOINT_STATES, np.zeros((len(steps), 9)), steps),
        topics.CONTROLLER_STATUS: series(topics.CONTROLLER_STATUS, status, steps),
        topics.VALVE_VOLTAGES: series(topics.VALVE_VOLTAGES, moved.voltages, steps, LATER),
        wish: series(wish, padded if wish == topics.TIP_TWIST_COMMAND else moved.commands, steps),
    }
    return bag_of(told)


@pytest.mark.parametrize(("period", "first", "half"), [(0.01, 16, 51), (0.02, 26, 61), (0.05, 56, 91)])
def test_from_a_levers_step_it_is_as_long_as_the_voltages_and_the_wish_of_that_step_take(period, first, half):
    moved, still = driven(thrown, period), driven(lambda _: REST, period)
    differ = np.flatnonzero((moved.voltages != still.voltages).any(axis=1))[0] * PERIOD - THROWN
    wished = np.flatnonzero(moved.tip_wish[:, 0] >= 0.5 * moved.tip_wish[-1, 0])[0] * PERIOD - THROWN
    assert (1e3 * differ + 1.0, 1e3 * wished + 1.0) == pytest.approx((first, half))
    told = lever_to_valve_ms(recorded(moved, thrown, period))
    assert told == {
        "first": {"p50": first, "p99": first},
        "half_step": {"p50": half, "p99": half},
        "half_way": None,
    }


def test_what_the_graph_alone_takes_is_told_of_levers_that_are_followed_at_once():
    told = lever_to_valve_ms(recorded(driven(thrown, PERIOD, interpolated=False), thrown, PERIOD))
    assert told["first"] == {"p50": 1.0, "p99": 1.0}
    assert told["half_step"] == {"p50": 36.0, "p99": 36.0}  # 0.15 m/s at 4 m/s^2


@pytest.mark.parametrize(("period", "behind"), [(0.02, 41.0), (0.05, 101.0)])
def test_a_movement_is_no_step_and_follows_two_periods_behind(period, behind):
    told = lever_to_valve_ms(recorded(driven(wave, period), wave, period))
    assert told["half_step"] is None
    assert told["half_way"]["p50"] == pytest.approx(behind, abs=5.5)


def test_in_the_joint_scheme_the_valves_command_is_what_was_wished():
    moved = driven(thrown, 0.02)
    told = lever_to_valve_ms(recorded(moved, thrown, 0.02, topics.VALVE_COMMANDS))
    commands = np.abs(moved.commands[:, 2])
    half = np.flatnonzero(commands >= 0.5 * commands.max())[0] * PERIOD - THROWN
    assert told["half_step"]["p50"] == pytest.approx(1e3 * half + 1.0)


def test_while_the_joystick_moves_nothing_there_is_no_delay():
    bag = recorded(driven(thrown, 0.02), thrown, 0.02)
    bag.series(topics.CONTROLLER_STATUS).column("armed")[:] = 0.0
    assert lever_to_valve_ms(bag) == NOTHING


def test_no_sample_waits_until_the_levers_are_armed_again():
    bag = recorded(driven(thrown, 0.02), thrown, 0.02)
    bag.series(topics.CONTROLLER_STATUS).column("armed")[150:250] = 0.0
    assert lever_to_valve_ms(bag)["first"]["p99"] == 26.0


def test_a_joystick_of_too_few_axes_tells_nothing():
    bag = recorded(driven(thrown, 0.02), thrown, 0.02)
    joy = bag.series(topics.JOY)
    bag._series["joy"] = joy._replace(values=joy.values[:, :2])
    assert lever_to_valve_ms(bag) == NOTHING
