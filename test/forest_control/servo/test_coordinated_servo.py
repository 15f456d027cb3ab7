"""Claims about the coordinated scheme's servo: lead, closing the loop, holding."""

import math

import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.levers import REST, Levers
from forest_control.pipeline import control_state
from forest_control.pipeline.control_state import Inputs
from forest_control.pipeline.controller import step
from forest_control.servo import coordinated_servo
from forest_control.servo.schemes import Gains, Scheme, Signals, coordinated
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.machine import load_machine

C180 = load_machine("c180_hoses")
P = parameters(C180, Settings(scheme=Scheme.COORDINATED))
LINKS = C180.manipulator.links
START = inverse_kinematics((5.5, 0.0, 1.0), LINKS)
ZERO = (0.0, 0.0, 0.0)
HOLD = coordinated_servo.HOLD_RATE
PERIOD = 0.005


def test_the_reference_velocity_passes_earlier_by_the_lead():
    gains = Gains(0.0, 0.0, 0.0, feedback=5.0, lead_time=0.03)
    assert coordinated(Signals(0.2, 0.0, 1.0, 1.0, 0.0, 0.0), gains) == 0.2
    assert coordinated(Signals(0.2, 0.1, 1.0, 1.0, 0.0, 0.0), gains) == pytest.approx(0.203)


def test_an_error_of_the_tip_is_closed_and_the_integral_adds():
    gains = Gains(0.0, 0.0, 0.0, feedback=5.0, lead_time=0.03)
    assert coordinated(Signals(0.0, 0.0, 1.01, 1.0, 0.0, 0.002), gains) == pytest.approx(0.052)


def test_a_step_of_the_wish_becomes_a_ramp():
    velocity = coordinated_servo.ramped(ZERO, (0.3, 0.0, 0.4), 4.0, PERIOD)
    assert math.hypot(*velocity) == pytest.approx(4.0 * PERIOD)
    assert coordinated_servo.ramped((0.3, 0.0, 0.39), (0.3, 0.0, 0.4), 4.0, PERIOD) == (0.3, 0.0, 0.4)


def test_the_reference_is_the_integral_of_the_governed_wish_without_drift():
    state, place = control_state.REST, list(tip_position(START, LINKS))
    for k in range(1500):
        levers = Levers(math.sin(0.01 * k), 0.3 * math.cos(0.02 * k), 0.5 * math.sin(0.015 * k))
        # A machine that follows exactly.
        state, output = step(state, Inputs(state.reference if k else START, ZERO, levers, True), P, PERIOD)
        place = [x + PERIOD * v for x, v in zip(place, output.tip_velocity_reference, strict=True)]
    assert tip_position(state.reference, LINKS) == pytest.approx(place, abs=1e-4)


def test_a_resting_joint_holds_until_its_error_has_grown():
    c, memory = P.coordinated, coordinated_servo.REST
    for _ in range(200):
        memory, u = coordinated_servo.servo(memory, ZERO, (2.5e-4, 0.0, 0.0), ZERO, ZERO, ZERO, c, PERIOD)
        assert u == (HOLD, HOLD, HOLD)
        assert coordinated_servo.inches(memory) == ZERO
    asked = 0.0
    for _ in range(100):
        memory, u = coordinated_servo.servo(memory, ZERO, (4e-4, 0.0, 0.0), ZERO, ZERO, ZERO, c, PERIOD)
        asked += PERIOD * coordinated_servo.inches(memory)[0]
    assert 0.0 < asked < 4e-4
    assert u == (HOLD, HOLD, HOLD)
    assert coordinated_servo.inches(memory)[1:] == (0.0, 0.0)


def test_a_joint_holds_while_only_others_are_wished_to_move():
    c, memory, a = P.coordinated, coordinated_servo.REST, (0.0, 0.1, 0.0)
    for _ in range(4000):
        memory, u = coordinated_servo.servo(memory, a, (5e-5, 0.0, 0.0), ZERO, ZERO, ZERO, c, PERIOD)
        assert u[0] == HOLD
        assert u[1] > 0.0
    assert memory.swing.w == 0.0  # for nothing that it could do


def test_the_integral_of_a_resting_joint_learns_only_while_its_valve_is_open():
    c, r = P.coordinated, (1e-3, 0.0, 0.0)
    learnt = {}
    for volts, a in ((0.0, (0.0, 0.1, 0.0)), (1.1, ZERO)):
        memory = coordinated_servo.REST
        for _ in range(2000):
            memory, _ = coordinated_servo.servo(memory, a, r, ZERO, ZERO, (volts, 0.0, 0.0), c, PERIOD)
        learnt[volts] = memory.swing.w
    assert learnt[0.0] == 0.0
    assert learnt[1.1] > 0.01
    for _ in range(200):
        memory, u = coordinated_servo.servo(memory, ZERO, ZERO, ZERO, ZERO, ZERO, c, PERIOD)
    assert (memory.swing.w, u[0]) == (learnt[1.1], HOLD)  # it has opened the valve, and is done


def test_the_reference_starts_from_the_mean_of_what_was_measured_at_rest():
    state = control_state.REST
    for k in range(40):
        noisy = tuple(q + (2e-4 if k % 2 else -2e-4) for q in START)
        state, output = step(state, Inputs(noisy, ZERO, REST, True), P, PERIOD)
        assert output.command == ZERO
    assert state.reference == pytest.approx(START, abs=1e-9)


def test_the_rate_is_heard_only_well_beyond_a_change_of_sign():
    gains = Gains(0.0, 0.0, 0.0, feedback=0.0, lead_time=0.0, rate=0.5)
    assert coordinated(Signals(0.2, 0.0, 0.0, 0.0, 0.1, 0.0), gains) == pytest.approx(0.25)
    assert coordinated(Signals(0.0, 0.0, 0.0, 0.0, 0.1, 0.0), gains) == 0.0
    assert coordinated(Signals(0.01, 0.0, 0.0, 0.0, 0.11, 0.0), gains) == pytest.approx(0.01 - 0.0005)
