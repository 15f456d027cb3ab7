"""The offline loop runs the node's guard: what stops the crane live stops it here, compiled or not."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.levers import REST, Levers, levers_for_tip_velocity
from forest_control.pipeline.control_state import ValveFeedback
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import (
    Permission,
    PermissionParameters,
    armed_watch,
)
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.sensors.signal_processing import Measurement, Motion
from forest_study.closed_loop import loop_core
from forest_study.closed_loop.closed_loop import Links, Operator, run
from forest_study.closed_loop.link_model import Quality, Reports
from forest_study.closed_loop.loop_core import Guarded, Knowledge, Loop
from forest_study.thesis.thesis_machine import machine_of, settings_of

C180 = load_machine("c180_hoses")
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)
PUSHED = levers_for_tip_velocity((0.0, 0.3, 0.2), 0.5)
FAULT = 1.0  # [s]
SETTINGS = Settings(), valve_driver_parameters.Settings()


def session(operator, seconds=FAULT + 1.0, **circumstances):
    return run(C180, operator, seconds, START, *SETTINGS, **circumstances)


def shut_from(moved):
    """Return when the last command other than zero was given [s]."""
    return PERIOD * np.flatnonzero(moved.commands.any(axis=1))[-1]


def pushed(time):
    return Operator(PUSHED if time > 0.1 else REST)


def test_a_joystick_that_falls_silent_stops_the_tip_within_its_timeout_and_a_quarter_second():
    moved = session(lambda time: pushed(time) if time < FAULT else None)
    assert FAULT + 0.15 < shut_from(moved) < FAULT + 0.15 + 0.26


def test_a_link_over_which_no_state_comes_any_more_stops_at_once_after_the_timeout():
    exact, lossy = (session(pushed, ways=Links(state=Quality(loss=loss), seed=1)) for loss in (0.0, 0.985))
    assert (exact.commands[round(FAULT / PERIOD) :].any(axis=1)).all()
    assert not lossy.commands[-1].any()


def test_a_sensor_that_freezes_stops_the_crane():
    moved = session(
        pushed,
        sensor_suite=sensor_suite(C180, noise=True, faults=parse_faults("boom_resolver: frozen from 1 s")),
    )
    assert FAULT < shut_from(moved) < FAULT + 1.0


def test_exact_sensors_of_a_joint_that_has_not_begun_to_move_are_not_taken_for_frozen():
    settings = settings_of(Scheme.COORDINATED, "0.2 Hz"), SETTINGS[1]
    moved = run(machine_of("0.2 Hz"), pushed, 2.0, START, *settings)
    assert moved.commands[round(0.2 / PERIOD) :].any(axis=1).all()


def test_a_joint_without_a_reading_stops_the_crane():
    moved = session(
        pushed, sensor_suite=sensor_suite(C180, faults=parse_faults("boom_resolver: absent from 1 s"))
    )
    assert shut_from(moved) == pytest.approx(FAULT, abs=0.02)


def test_the_deadman_pressed_with_deflected_levers_moves_nothing():
    moved = session(lambda time: Operator(PUSHED, enabled=time > 0.1))
    assert not moved.voltages.any()


SEEN = Measurement(*(None,) * len(Measurement._fields))._replace(pressures=(1e7, 2e6) * 6)


def wild(rng, rows):
    """Yield levers, deadman, what sensors say and the driver's voltages, now and then nonsense or frozen."""
    seen, volts, levers = np.array([0.2, 0.4, -1.5]), np.zeros(3), REST
    broken = frozenset()
    for row in range(rows):
        if row % 150 == 0:
            broken = frozenset(rng.choice(["nonsense", "blind", "frozen", "deaf", "none"], 1).tolist())
        if row % 50 < 5:
            levers = REST
        elif row % 50 == 5:
            levers = Levers(*rng.uniform(-1.0, 1.0, 3).tolist())
        if "frozen" not in broken:
            seen = seen + rng.normal(0.0, 1e-5, 3)
        nonsense = "blind" in broken or ("nonsense" in broken and row % 7 == 0)
        angles = (9.0, 0.4, -1.5) if nonsense else tuple(seen.tolist())
        volts = np.zeros(3) if "deaf" in broken else rng.uniform(-5.0, 5.0, 3)
        joints, actuators = Motion(angles, ZERO, ZERO), Motion((math.nan,) * 3, ZERO, ZERO)
        yield (
            levers,
            bool(row % 130 > 3),
            SEEN._replace(joints=joints, actuators=actuators),
            tuple(volts.tolist()),
        )


@pytest.mark.parametrize("seed", range(3))
def test_the_kernels_guard_decides_as_the_nodes_does(seed):
    """Both ask `decide`; what they do about it is told twice, so here both hear the same, faults and all."""
    k = Knowledge(None, None, parameters(C180, Settings()), None, PermissionParameters())
    node = GuardedController(k.control, PermissionParameters())
    node.guard.permission = Permission(joystick=armed_watch())
    kernel, stopped, moved = Guarded(), 0, 0
    for row, (levers, held, seen, volts) in enumerate(wild(np.random.default_rng(seed), 2000)):
        now = row * PERIOD
        loop = Loop(None, None, kernel, valve_driver.REST._replace(voltages=volts), Reports())
        kernel, velocity = loop_core.guarded(loop, levers, held, True, seen, k, row)
        node.guard.hear(loop_core.sample(levers, held, row))
        machine = loop_core.machine_state(seen, (row + 1) * PERIOD_NS, now)
        valves = ValveFeedback(voltages=volts, driver=DriverSample(volts, now))
        node.stops_without_state(now)
        _, telemetry = node.advance(machine, valves, now)
        assert kernel.command == node.command
        assert velocity == (telemetry.output.tip_velocity_reference if telemetry else ZERO)
        assert kernel.permission == node.guard.permission
        stopped, moved = stopped + (telemetry is None), moved + any(node.command)
    assert stopped > 100
    assert moved > 100
