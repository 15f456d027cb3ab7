"""Claims about the four schemes of thesis fig. 5.2 around the linear plant."""

import math

import numpy as np
import pytest

from forest_control.operator.joystick_sources import thesis_tip_velocity
from forest_description.derived.limits import THESIS_START
from forest_description.geometry.kinematics import joint_rates
from forest_description.machine import load_machine
from forest_study.thesis.thesis_plant import DRIVE, State, at_rest, simulate
from forest_study.thesis.thesis_schemes import ACCELERATION, SCHEMES, poles, servo

W_N = 2.0 * math.pi * 2.0
SINUSOID = 2.0 * math.pi * 1.18  # [rad/s]


@pytest.fixture(scope="module")
def links():
    return load_machine("c180_thesis").manipulator.links


def run(name, links, gains, wish=thesis_tip_velocity, duration=6.0, step=0.005, mismatch=0.0):
    w_n = gains.natural_frequency * (1.0 + mismatch)
    start = at_rest(THESIS_START, links)
    return simulate(SCHEMES[name](gains, links), w_n, start, links, duration, wish, step)


def apart(one, other):
    return float(np.abs(one.position - other.position).max())


def sinusoid(time):
    return 0.0, 0.05 * math.sin(SINUSOID * time), 0.0


@pytest.mark.parametrize(
    ("hertz", "pole", "k_v", "k_star", "k_p", "k_d"),
    [(2.0, 16.5, 0.313, 4.195, 21.66, 3.307), (0.2, 11.5, 0.815, 1.123, 10.52, 2.902)],
)
def test_gains_are_the_documented_ones(hertz, pole, k_v, k_star, k_p, k_d):
    made = servo(2.0 * math.pi * hertz, pole)
    assert made[2:] == pytest.approx((k_v, k_star, k_p, k_d), rel=1e-3)


def test_both_servos_have_one_closed_loop_frequency():
    found = poles(servo(W_N, 16.5), W_N)
    assert found["velocity"] == pytest.approx([-16.5])
    assert math.prod(found["position"]) == pytest.approx(16.5**2)
    assert sum(found["position"]) == pytest.approx(-2.0 * 1.64 * 16.5)


def test_servos_are_those_of_the_diagram(links):
    made = servo(W_N, 16.5)
    state = State((0.1, 0.4, -1.5), (0.02, -0.03, 0.05), (0.12, 0.38, -1.49), THESIS_START)
    wished = (0.1, 0.2, -0.1)
    a = joint_rates(state.angles, wished, links)
    velocity, position = (SCHEMES[name](made, links)(state, wished) for name in "cd")
    for i in range(3):
        v, behind = state.rates[i], state.reference[i] - state.angles[i]
        assert velocity.drive[i] == pytest.approx(
            DRIVE * made.velocity_gain * (made.pre_loop_gain * a[i] - v)
        )
        assert position.drive[i] == pytest.approx(
            DRIVE * (made.position_gain * behind - made.damping_gain * v)
        )
    assert position.reference_rates == a


@pytest.mark.parametrize(("inverse_kinematics", "jacobian"), [("a", "c"), ("b", "d")])
def test_inverse_kinematics_and_jacobian_agree_as_far_as_the_jacobian_is_constant(
    inverse_kinematics, jacobian, links
):
    """Half the motion, a quarter of the difference: what is left is of second order."""
    made = servo(W_N, 16.5)

    def difference(share):
        def wish(time):
            return tuple(share * v for v in thesis_tip_velocity(time))

        return apart(*(run(name, links, made, wish) for name in (inverse_kinematics, jacobian)))

    small, smaller = difference(0.1), difference(0.05)
    assert 1e-6 < small < 1e-3
    assert small / smaller == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("name", list("abcd"))  # ours has no pole to choose, and ramps its wish
def test_a_fast_servo_does_what_is_wished_by_any_scheme(name, links):
    fast = run(name, links, servo(W_N, 400.0), duration=3.0, step=0.001)
    assert np.abs(fast.position_error).max() < 0.004


def test_inverse_kinematics_leave_nothing_behind_and_a_jacobian_at_lagging_joints_does(links):
    made = servo(W_N, 16.5)
    left = {name: run(name, links, made, duration=10.0).position_error[-1, 0] for name in SCHEMES}
    assert abs(left["a"]) < 1e-3
    assert abs(left["b"]) < 1e-3
    assert -0.020 < left["c"] < -0.008
    assert -0.035 < left["d"] < -0.020


@pytest.mark.parametrize("name", ["c", "d"])
def test_in_a_steady_sinusoid_velocity_error_over_position_error_is_its_frequency(name, links):
    """A linear loop's, so the four pairs that the thesis quotes cannot all belong to one sinusoid."""
    steady = run(name, links, servo(W_N, 16.5), sinusoid, duration=8.0)
    late = steady.time > 4.0
    velocity, position = steady.velocity_error[late, 1], steady.position_error[late, 1]
    assert np.ptp(velocity) / np.ptp(position) == pytest.approx(SINUSOID, rel=2e-3)


def test_errors_in_a_steady_sinusoid_are_those_of_the_transfer_functions(links):
    made, s = servo(W_N, 16.5), 1j * SINUSOID
    closed = {"c": 16.5 / (s + 16.5), "d": 16.5**2 / (s * s + 2.0 * 1.64 * 16.5 * s + 16.5**2)}
    for name, gain in closed.items():
        steady = run(name, links, made, sinusoid, duration=8.0)
        error = np.abs(steady.velocity_error[steady.time > 4.0, 1]).max()
        assert error == pytest.approx(0.05 * abs(gain - 1.0), rel=3e-3)


def test_without_the_pre_loop_gain_the_velocity_servo_does_a_quarter_of_the_wish(links):
    made = servo(W_N, 16.5)

    def ahead(time):
        return (0.1 if time < 4.0 else 0.0), 0.0, 0.0

    whole, part = (run("c", links, gains, ahead) for gains in (made, made._replace(pre_loop_gain=1.0)))
    assert whole.position[-1, 0] - 5.5 == pytest.approx(0.4, rel=0.01)
    assert part.position[-1, 0] - 5.5 == pytest.approx(0.4 / made.pre_loop_gain, rel=0.01)


def test_coordinated_follows_its_ramped_wish_exactly_on_the_plant_it_was_made_for(links):
    """What is left of a step is the ramp: v^2 / (2 a) and what `RAMP_LAG` adds."""
    moved = run("coordinated", links, servo(W_N, 16.5), lambda time: (0.3 if time < 4.0 else 0.0, 0.0, 0.0))
    ramp = 0.3**2 / (2.0 * ACCELERATION)
    assert ramp < np.abs(moved.position_error).max() < ramp + 0.3 * 0.01
    assert abs(moved.position_error[-1, 0]) < 1e-3


def test_coordinated_comes_back_to_its_path_on_a_plant_that_is_off(links):
    for mismatch in (-0.3, 0.3):
        moved = run("coordinated", links, servo(W_N, 16.5), duration=10.0, mismatch=mismatch)
        assert np.abs(moved.position_error[-1, [0, 2]]).max() < 2e-3
