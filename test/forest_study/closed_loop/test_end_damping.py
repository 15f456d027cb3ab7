"""Claims about arriving at the ends of the strokes, on the full machine."""

import itertools
import math

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_control.config import controller_settings
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import compiled_loop

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")
DIRECTIONS = [d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)]
LEAST, FARTHEST = 0.49, 3.0  # [deg] that a joint must keep, and may stay away


def pushed(machine, levers, settings, duration):
    """Return a session with the levers held for a duration [s], and the joints' margins [deg]."""
    rows = np.tile([*levers, 1.0], (round(duration / PERIOD), 1))
    start = pose_at(start_tip(machine), machine)
    moved = compiled_loop.run(machine, rows, start, settings, valve_driver_parameters.Settings())
    low, high = np.array(joint_limits(machine)).T
    return moved, np.degrees(np.minimum(moved.angles - low, high - moved.angles))


@pytest.mark.parametrize("machine", [C180, LOADER], ids=["c180_hoses", "loader"])
@pytest.mark.parametrize("sign", [-1.0, 1.0], ids=["retracts", "extends"])
@pytest.mark.parametrize("joint", [1, 2], ids=["boom", "stick"])
def test_a_cylinder_slows_down_by_its_stroke_and_does_not_overshoot(machine, joint, sign):
    levers = Levers(0.0, *(sign if joint == i else 0.0 for i in (1, 2)))
    settings = controller_settings.Settings(scheme=Scheme.JOINT, joint_rates=(0.8, 0.5, 0.5))
    moved, margins = pushed(machine, levers, settings, 10.0)
    margin = margins[:, joint]
    assert margin.min() > LEAST
    assert margin[-1] < FARTHEST
    assert margin.min() > margin[-1] - 0.05
    limits = controller_settings.parameters(machine, settings).velocity_limits
    stroke = limits.strokes[joint]
    lengths = [cylinder_length(angle, stroke.linkage) for angle in moved.angles[:, joint].tolist()]
    left = stroke.longest - np.array(lengths) if sign > 0.0 else np.array(lengths) - stroke.shortest
    arriving = (left > 0.005) & (left < 0.08)
    speed = np.abs(np.gradient(lengths, PERIOD))[arriving]
    assert np.count_nonzero(arriving) > 50
    # It lags behind its command by some 50 ms, and rocks.
    assert np.all(speed < limits.approach[joint] * (1.15 * left[arriving] + 0.004))


def test_the_loaders_swing_is_fed_what_its_hoses_take_and_its_pump_leaves():
    """Of the directions that it swings in, the worst: 31 mm beside the line without that."""
    along = np.array((0.0, -1.0, -1.0)) / math.sqrt(2.0)
    levers = levers_for_tip_velocity(tuple(along.tolist()), 1.0)
    moved, _ = pushed(LOADER, levers, controller_settings.Settings(tip_speed=1.0), 1.0)
    way = moved.tip - moved.tip[0]
    assert np.linalg.norm(way - np.outer(way @ along, along), axis=1).max() < 0.019


def test_in_all_26_directions_at_full_speed_the_tip_keeps_its_line_and_arrives():
    settings = controller_settings.Settings(tip_speed=1.0)
    for direction in DIRECTIONS:
        along = np.array(direction) / np.linalg.norm(direction)
        moved, margin = pushed(C180, levers_for_tip_velocity(tuple(along.tolist()), 1.0), settings, 10.0)
        way = moved.tip - moved.tip[0]
        aside = np.linalg.norm(way - np.outer(way @ along, along), axis=1)
        assert margin.min() > LEAST, direction
        assert margin[-1].min() < FARTHEST, direction
        assert aside.max() < 0.007, direction
