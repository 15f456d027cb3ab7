"""Claims about the controller's core: from levers to commands for ideal valves."""

import math

import numpy as np
import pytest

from forest_control import compiled
from forest_control.config import controller_settings
from forest_control.config.controller_settings import Settings
from forest_control.limits.load_moment import NO_CAPACITY
from forest_control.limits.velocity_scaling import ENOUGH, Limit, flow_demand
from forest_control.limits.workspace import MOST, NO_WALL, PLANE, Wall, Workspace
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.operator.operator_profile import rate_mode_velocity
from forest_control.pipeline import controller, joint_servo
from forest_control.pipeline.control_state import REST, Inputs, State
from forest_control.servo import coordinated_servo
from forest_control.servo.schemes import Scheme, closes_on_position
from forest_description.derived.actuator_kinematics import actuator_speeds_to_joint_rates, rated_speeds
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import tip_position, tip_velocity
from forest_description.machine import load_machine
from forest_description.types import ZERO

MACHINE = load_machine("c180_hoses")
LINKS = MACHINE.manipulator.links
PERIOD = 0.005
MIDDLE = (0.2, 0.4, -1.5)
TIP_SCHEMES = list(Scheme)[1:5]
every_scheme = pytest.mark.parametrize("scheme", list(Scheme))
every_tip_scheme = pytest.mark.parametrize("scheme", TIP_SCHEMES)


def parameters(scheme=Scheme.JACOBIAN_POSITION, **settings):
    return controller_settings.parameters(MACHINE, Settings(scheme=scheme, **settings))


def inputs(levers=(0.0, 0.0, 0.0), angles=MIDDLE, rates=ZERO, enabled=True):
    return Inputs(angles, rates, Levers(*levers), enabled)


def rates_of(command, angles):
    """Joint rates that ideal valves give for a command."""
    speeds = tuple(volts / 10.0 * speed for volts, speed in zip(command, rated_speeds(MACHINE), strict=True))
    return actuator_speeds_to_joint_rates(angles, speeds, MACHINE.linkages)


def drive(p, levers_at, seconds, angles=MIDDLE, bandwidth=math.inf, held_at=lambda _: True):
    """Play levers on a machine whose joints follow ideal valves with a bandwidth [rad/s]; yield each step."""
    state, rates, step = REST, ZERO, compiled.controller_step()
    weight = 1.0 - math.exp(-bandwidth * PERIOD)
    for k in range(round(seconds / PERIOD)):
        heard = inputs(levers_at(k * PERIOD), angles, rates, held_at(k * PERIOD))
        state, told = step(state, heard, p, PERIOD)
        wanted = rates_of(told.output.command, angles)
        rates = tuple(v + weight * (u - v) for v, u in zip(rates, wanted, strict=True))
        angles = tuple(q + PERIOD * v for q, v in zip(angles, rates, strict=True))
        yield state, told.output, angles


@every_scheme
def test_without_the_deadman_nothing_moves_and_the_reference_rests_on_the_machine(scheme):
    p, rng = parameters(scheme), np.random.default_rng(6)
    for _ in range(200):
        reference, angles, rates, levers = map(tuple, rng.uniform(-1.0, 1.0, (4, 3)).tolist())
        before = State(reference, bool(rng.integers(2)))
        after, output = controller.step(before, inputs(levers, angles, rates, enabled=False), p, PERIOD)
        assert (output.command, output.tip_velocity_reference, output.scaling.factor) == (ZERO, ZERO, 0.0)
        assert after == State(angles, False)


@every_scheme
def test_with_the_deadman_a_lever_moves_the_machine(scheme):
    _, output = controller.step(REST, inputs((0.5, 0.0, 0.0)), parameters(scheme), PERIOD)
    assert output.command[0] > 0.0


def test_no_step_when_enabled_again():
    p = parameters()
    state = REST
    for _ in range(400):  # the machine stalls: the reference runs ahead
        state, output = controller.step(state, inputs((0.0, 1.0, 0.0)), p, PERIOD)
    assert abs(output.command[1]) > 1.0
    for _ in range(round(0.25 / PERIOD)):  # in which it stops
        state, _ = controller.step(state, inputs((0.0, 1.0, 0.0), enabled=False), p, PERIOD)
    moved = (0.3, 0.1, -1.2)
    state, output = controller.step(state, inputs(angles=moved), p, PERIOD)
    assert output.command == ZERO
    assert (state.reference, state.enabled, state.rates) == (moved, True, ZERO)


def test_the_reference_runs_no_further_ahead_than_the_lead():
    p, state = parameters(lead=0.1), REST
    for _ in range(2000):
        state, _ = controller.step(state, inputs((1.0, 0.0, 0.0)), p, PERIOD)
    assert state.reference[0] == pytest.approx(MIDDLE[0] + 0.1, abs=1e-12)


def test_the_reference_integrates_the_wish():
    p, state = parameters(Scheme.JOINT, joint_rates=(0.4, 0.2, 0.1)), REST
    for _ in range(10):
        state, _ = controller.step(state, inputs((0.5, -1.0, 1.0)), p, PERIOD)
    expected = np.add(MIDDLE, 10 * PERIOD * np.array([0.2, -0.2, 0.1]))
    assert state.reference == pytest.approx(expected, abs=1e-12)


@every_tip_scheme
@pytest.mark.parametrize("pose", [(0.0, 0.4, 0.0), (0.0, 0.4, -math.pi)], ids=["straight", "folded"])
def test_at_a_singular_pose_the_machine_stands_and_the_limit_is_named(scheme, pose):
    _, output = controller.step(REST, inputs((0.3, 0.5, 0.7), pose), parameters(scheme), PERIOD)
    assert output.command == ZERO
    assert output.tip_velocity_reference == ZERO
    assert output.scaling == (0.0, Limit.SINGULARITY)


def test_joint_scheme_moves_out_of_a_singular_pose():
    _, output = controller.step(
        REST, inputs((0.0, 0.0, -1.0), (0.0, 0.4, 0.0)), parameters(Scheme.JOINT), PERIOD
    )
    assert output.command[2] != 0.0
    assert output.scaling.limit is not Limit.SINGULARITY


def test_commands_are_clipped_at_the_rated_voltage():
    p, rng, clipped = parameters(position_gain=(50.0, 50.0, 50.0), lead=1.0), np.random.default_rng(7), 0
    for _ in range(500):
        reference = tuple(np.add(MIDDLE, rng.uniform(-0.3, 0.3, 3)).tolist())
        _, output = controller.step(State(reference, True), inputs(), p, PERIOD)
        errors = np.subtract(reference, MIDDLE)
        assert max(map(abs, output.command)) <= 10.0
        moved = np.abs(errors) > joint_servo.NEAR  # nearer, a joint that rests may hold
        assert all((np.sign(output.command) == np.sign(errors))[moved])
        clipped += sum(abs(volts) == 10.0 for volts in output.command)
    assert clipped > 500


def test_joint_levers_ask_for_joint_rates_through_the_lever_arms():
    rng, p = np.random.default_rng(8), parameters(Scheme.JOINT, joint_rates=(0.4, 0.1, 0.08))
    for _ in range(200):
        levers = tuple(rng.uniform(-1.0, 1.0, 3).tolist())
        angles = (rng.uniform(-2.0, 2.0), rng.uniform(-0.2, 0.7), rng.uniform(-1.8, -1.2))
        _, output = controller.step(REST, inputs(levers, angles), p, PERIOD)
        assert rates_of(output.command, angles) == pytest.approx(
            np.multiply(levers, (0.4, 0.1, 0.08)), abs=1e-12
        )
        assert output.tip_velocity_reference == ZERO  # in joint mode nobody asks for a tip motion


@every_tip_scheme
def test_the_velocity_reference_is_what_the_levers_ask_times_the_scaling_factor(scheme):
    p, rng, slowed = parameters(scheme), np.random.default_rng(9), 0
    for _ in range(500):
        levers = tuple(rng.uniform(-1.0, 1.0, 3).tolist())
        angles = (rng.uniform(-2.0, 2.0), rng.uniform(-0.5, 1.1), rng.uniform(-2.0, -1.0))
        _, output = controller.step(REST, inputs(levers, angles), p, PERIOD)
        asked = np.multiply(rate_mode_velocity(Levers(*levers), MIDDLE, p.profile), output.scaling.factor)
        assert output.tip_velocity_reference == pytest.approx(asked, abs=1e-12)
        slowed += output.scaling.factor < 1.0
    assert 0 < slowed < 500


@pytest.mark.parametrize("most", [0.02, 0.8], ids=["held back", "free"])
def test_a_ramp_that_begins_where_limits_left_it_is_told_as_a_share_of_what_the_levers_ask(most):
    p = parameters(Scheme.COORDINATED, joint_rates=(most, most, most))
    shares = []

    def levers_at(t):
        return Levers(0.0, 0.0, 0.4) if 0.5 < t < 1.5 else Levers(0.1, 0.0, 0.0)

    for number, (_, output, _) in enumerate(drive(p, levers_at, 2.0)):
        went = np.linalg.norm(output.tip_velocity_reference)
        shares.append(output.scaling.factor)
        if 0.9 < number * PERIOD < 1.5:
            assert shares[-1] == pytest.approx(went / 0.2, abs=1e-3)
    assert (min(shares) < 0.5) == (most < 0.1)
    assert shares[-1] == 1.0


def test_a_motion_that_is_resumed_from_its_stop_is_no_less_than_its_levers_ask():
    levers, held = Levers(0.0, 0.0, 0.4), lambda time: not 0.8 < time < 0.9
    steps = drive(parameters(Scheme.COORDINATED), lambda _: levers, 1.5, held_at=held)
    told = [output.scaling.factor for _, output, _ in steps]
    assert min(told[:160]) == 1.0  # until it is let go
    assert min(told[-119:]) == 1.0  # from where it is held again


@every_tip_scheme
@pytest.mark.parametrize("direction", range(3), ids="xyz")
def test_the_tip_of_an_ideal_machine_goes_where_the_lever_points(scheme, direction):
    levers = [Levers(0.0, 0.0, 0.4), Levers(0.4, 0.0, 0.0), Levers(0.0, 0.4, 0.0)][direction]
    p, wished = parameters(scheme), np.zeros(3)
    steps = list(drive(p, lambda t: levers if t < 1.5 else Levers(0, 0, 0), 4.0, bandwidth=4.0 * math.pi))
    for _, output, _ in steps:
        wished += PERIOD * np.array(output.tip_velocity_reference)
    moved = np.subtract(tip_position(steps[-1][2], p.links), tip_position(MIDDLE, p.links))
    assert wished[direction] == pytest.approx(0.3, abs=1e-9)
    assert moved == pytest.approx(wished, abs=0.005 if closes_on_position(scheme) else 0.03)


@every_scheme
def test_no_levers_drive_a_joint_over_its_limits(scheme):
    p, rng = parameters(scheme), np.random.default_rng(10)
    held = rng.uniform(-1.5, 1.5, (10, 3)).clip(-1.0, 1.0).tolist()
    lower, upper = np.array(joint_limits(MACHINE)).T
    least, most, held_back = np.full(3, math.inf), np.full(3, -math.inf), 0
    for _, output, angles in drive(p, lambda t: Levers(*held[int(t / 3.0)]), 30.0, bandwidth=4.0 * math.pi):
        least, most = np.minimum(least, angles), np.maximum(most, angles)
        held_back += output.scaling.limit == Limit.JOINT
    assert all(least > lower)
    assert all(most < upper)
    assert held_back > 500  # it was tried


def test_beyond_a_limit_the_reference_does_not_pull_the_joint_in():
    upper = parameters().velocity_limits.upper[1]
    state, output = controller.step(REST, inputs(angles=(0.0, upper + 0.01, -1.5)), parameters(), PERIOD)
    assert state.reference[1] == upper + 0.01
    assert output.command == ZERO


@pytest.mark.parametrize("scheme", [s for s in Scheme if closes_on_position(s)])
@pytest.mark.parametrize("outwards", [0.01, -0.01])
def test_between_margin_and_limit_noise_does_not_draw_the_reference_in(scheme, outwards):
    """It went with the innermost sample, and the tip 26 mm after it."""
    p, rng, state = parameters(scheme), np.random.default_rng(4), REST
    edge = p.velocity_limits.upper if outwards > 0.0 else p.velocity_limits.lower
    pose = (0.0, edge[1] + outwards, edge[2] + outwards)
    for _ in range(400):
        read = tuple((pose + rng.normal(0.0, 2e-4, 3)).tolist())
        state, _ = controller.step(state, inputs(angles=read), p, PERIOD)
    assert state.reference == pytest.approx(pose, abs=4e-4)  # the schemes of the thesis begin with one sample


def test_parameters_keep_the_margin_from_every_joint_limit():
    p = parameters(joint_margin=0.05)
    for i, (low, high) in enumerate(joint_limits(MACHINE)):
        assert p.velocity_limits.lower[i] == pytest.approx(low + 0.05)
        assert p.velocity_limits.upper[i] == pytest.approx(high - 0.05)
    assert p.rated_speeds == rated_speeds(MACHINE)
    assert p.rated_voltages == (10.0, 10.0, 10.0)


def test_each_axis_is_clipped_at_and_scaled_with_its_own_valve_s_rated_voltage():
    loader = load_machine("loader")
    p = controller_settings.parameters(loader, Settings(scheme=Scheme.JOINT, joint_rates=(3.0, 3.0, 3.0)))
    p = p._replace(velocity_limits=p.velocity_limits._replace(pumps=ENOUGH), capacity=NO_CAPACITY)
    assert p.rated_voltages == (6.0, 8.0, 8.0)
    _, output = controller.step(REST, inputs((1.0, 1.0, 1.0)), p, PERIOD)
    assert output.command == (6.0, 8.0, 8.0)
    half = 0.5 * rated_speeds(loader)[0]
    p = controller_settings.parameters(loader, Settings(scheme=Scheme.JOINT, joint_rates=(half, 0.1, 0.1)))
    _, output = controller.step(REST, inputs((1.0, 0.0, 0.0)), p, PERIOD)
    assert output.command[0] == pytest.approx(3.0)


@pytest.mark.parametrize("scheme", [scheme for scheme in Scheme if scheme != Scheme.JOINT])
def test_of_random_wishes_no_rate_and_no_flow_is_over_its_limit_and_the_tip_keeps_its_direction(scheme):
    p = controller_settings.parameters(MACHINE, Settings(scheme=scheme, tip_speed=3.0))
    rng, held = np.random.default_rng(100 + int(scheme)), set()
    lower, upper = np.array(p.velocity_limits.lower), np.array(p.velocity_limits.upper)
    for _ in range(600):  # 3000 in all
        q = tuple(rng.uniform(lower - 0.02, upper + 0.02).tolist())
        wish = tuple(rng.normal(0.0, 0.7, 3).tolist())
        moving = coordinated_servo.in_motion(wish, ZERO, coordinated_servo.MOST_SAMPLES)
        state = REST._replace(reference=q, enabled=True, memory=moving, scheme=scheme)
        levers = levers_for_tip_velocity(wish, 3.0)
        after, output = controller.step(state, inputs(levers, q, ZERO), p, PERIOD)
        a = after.memory.swing.a, after.memory.boom.a, after.memory.stick.a
        speed = math.dist(wish, ZERO)
        moved = tip_velocity(q, a, p.links)
        assert math.dist(np.cross(moved, wish), ZERO) <= 1e-9 * speed**2
        assert np.dot(moved, wish) >= 0.0
        assert moved == pytest.approx(output.tip_velocity_reference, abs=1e-9)
        assert all(
            abs(rate) <= most * (1.0 + 1e-12) for rate, most in zip(a, p.velocity_limits.rates, strict=True)
        )
        assert flow_demand(q, a, p.velocity_limits.pumps) <= p.velocity_limits.pumps.limit * (1.0 + 1e-9)
        held.add(output.scaling.limit)
    assert {Limit.RATE, Limit.JOINT} <= held


@every_scheme
def test_at_a_wall_the_tip_slides_and_the_cause_is_told(scheme):
    tip = tip_position(MIDDLE, LINKS)
    ground = Wall(PLANE, (0.0, 0.0, 1.0), ZERO, tip[2])
    walls = Workspace((ground, *(NO_WALL,) * (MOST - 1)), 4.0, 1)
    p = controller_settings.parameters(MACHINE, Settings(scheme=scheme, tip_speed=0.3), walls)
    state, output = REST, None
    for _ in range(100):
        state, output = controller.step(state, inputs((0.5, -0.5, 0.0)), p, PERIOD)
    a = state.memory.swing.a, state.memory.boom.a, state.memory.stick.a
    assert tip_velocity(MIDDLE, a, LINKS)[2] >= -1e-3
    assert output.scaling.limit == Limit.WALL
    if scheme != Scheme.JOINT:
        assert output.tip_velocity_reference[1] == pytest.approx(0.15, abs=1e-3)
