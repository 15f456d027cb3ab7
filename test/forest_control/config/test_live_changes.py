"""Claims about changing scheme, mode and gains while the machine stands or moves: nobody feels a jump."""

import math
from itertools import permutations

import numpy as np
import pytest

from forest_control import compiled
from forest_control.config import controller_settings
from forest_control.config.controller_settings import Settings
from forest_control.operator.levers import Levers
from forest_control.operator.operator_profile import Mode
from forest_control.pipeline.control_state import REST, Inputs
from forest_control.servo.schemes import Scheme
from forest_description.derived.actuator_kinematics import actuator_speeds_to_joint_rates, rated_speeds
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.machine import load_machine
from forest_description.types import ZERO

MACHINE = load_machine("c180_hoses")
LINKS = MACHINE.manipulator.links
PERIOD = 0.005
START = inverse_kinematics((5.5, 0.0, 1.0), LINKS)
BANDWIDTH = 4.0 * math.pi  # [rad/s] of the joints
MOVING = Levers(0.5, 0.3, -0.3)
EVERY_PAIR = list(permutations(Scheme, 2))


class Crane:
    """Joints of a bandwidth behind ideal valves, and the controller, one after the other."""

    def __init__(self, settings):
        self.p, self.state = controller_settings.parameters(MACHINE, settings), REST
        self.angles, self.rates, self.step = START, ZERO, compiled.controller_step()

    def play(self, levers, seconds, seen=lambda q: q):
        """Hold levers, the angles seen through sensors; return commands [N, 3] V and tips [N, 3] m."""
        weight, speeds = 1.0 - math.exp(-BANDWIDTH * PERIOD), rated_speeds(MACHINE)
        commands, tips = [], []
        for _ in range(round(seconds / PERIOD)):
            inputs = Inputs(seen(self.angles), self.rates, levers, True)
            self.state, told = self.step(self.state, inputs, self.p, PERIOD)
            moving = tuple(c / 10.0 * v for c, v in zip(told.output.command, speeds, strict=True))
            wanted = actuator_speeds_to_joint_rates(self.angles, moving, MACHINE.linkages)
            self.rates = tuple(v + weight * (u - v) for v, u in zip(self.rates, wanted, strict=True))
            self.angles = tuple(q + PERIOD * v for q, v in zip(self.angles, self.rates, strict=True))
            commands.append(told.output.command)
            tips.append(tip_position(self.angles, LINKS))
        return np.array(commands), np.array(tips)

    def set(self, **settings):
        """Change parameters as the node does."""
        self.p = controller_settings.parameters(MACHINE, Settings(**settings))
        self.state = self.state._replace(changed=True)


def largest_change(commands):
    return float(np.abs(np.diff(commands, axis=0)).max())


@pytest.fixture(scope="module")
def normal():
    """The largest change of a command in a period when a lever, held for a while, is let go [V]."""
    crane = Crane(Settings(scheme=Scheme.COORDINATED))
    before, _ = crane.play(MOVING, 1.0)
    after, _ = crane.play(Levers(0.0, 0.0, 0.0), 0.5)
    return largest_change(np.vstack([before[-1:], after]))


@pytest.mark.parametrize(("old", "new"), EVERY_PAIR)
@pytest.mark.parametrize("levers", [MOVING, Levers(0.0, 0.0, 0.0)], ids=["moving", "resting"])
def test_a_scheme_takes_over_without_a_jump(old, new, levers, normal):
    crane = Crane(Settings(scheme=old))
    crane.play(MOVING, 0.6)
    before, _ = crane.play(levers, 1.0)
    crane.set(scheme=new)
    after, tips = crane.play(levers, 2.0)
    joined = np.vstack([before[-1:], after])
    assert np.abs(joined[1] - joined[0]).max() < 0.2 * normal
    assert largest_change(joined) < normal
    if levers != MOVING:
        assert np.linalg.norm(tips[-1] - tips[0]) < 0.005


@pytest.mark.parametrize("scheme", list(Scheme))
@pytest.mark.parametrize(("old", "new"), list(permutations(Mode)), ids=["to position", "to rate"])
def test_a_mode_takes_over_without_a_jump(scheme, old, new, normal):
    crane = Crane(Settings(scheme=scheme, mode=old))
    before, _ = crane.play(MOVING, 0.8)
    crane.set(scheme=scheme, mode=new)
    after, _ = crane.play(MOVING, 2.0)
    assert largest_change(np.vstack([before[-1:], after])) < normal


@pytest.mark.parametrize("scheme", [s for s in Scheme if s != Scheme.JOINT])
def test_in_position_mode_a_deflection_is_a_place_about_where_the_deadman_was_pressed(scheme):
    crane = Crane(Settings(scheme=scheme, mode=Mode.POSITION, position_span=0.4))
    _, tips = crane.play(Levers(0.5, 0.0, -0.25), 6.0)  # left, back
    assert tips[-1] - tips[0] == pytest.approx([-0.1, 0.2, 0.0], abs=0.004)
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1) / PERIOD
    assert speeds.max() < 0.55  # of 0.5 m/s
    _, tips = crane.play(Levers(0.0, 0.0, 0.0), 6.0)
    assert tips[-1] == pytest.approx([5.5, 0.0, 1.0], abs=0.004)


def test_in_position_mode_of_the_joint_scheme_a_deflection_is_an_angle():
    crane = Crane(Settings(scheme=Scheme.JOINT, mode=Mode.POSITION, joint_span=(0.2, 0.1, 0.1)))
    crane.play(Levers(0.5, -0.5, 0.3), 6.0)
    assert np.subtract(crane.angles, START) == pytest.approx([0.1, -0.05, 0.03], abs=1e-3)


def test_the_clutch_follows_the_deadman():
    crane = Crane(Settings(mode=Mode.POSITION))
    crane.play(Levers(0.0, 0.0, 0.5), 4.0)
    off = Inputs(crane.angles, ZERO, Levers(0.0, 0.0, 0.5), False)
    crane.state, _ = crane.step(crane.state, off, crane.p, PERIOD)
    _, tips = crane.play(Levers(0.0, 0.0, 0.0), 1.0)  # centred again, it stays where it was let go
    assert tips[-1][0] == pytest.approx(5.75, abs=0.004)


@pytest.mark.parametrize("change", [{"feedback_gain": (8.0, 8.0, 8.0)}, {"tip_speed": 0.2}, {"lead": 0.05}])
def test_gains_and_speeds_change_without_a_jump(change, normal):
    crane = Crane(Settings())
    before, _ = crane.play(MOVING, 1.0)
    crane.set(**change)
    after, _ = crane.play(MOVING, 1.0)
    assert largest_change(np.vstack([before[-1:], after])) < normal


@pytest.mark.parametrize("scheme", list(Scheme))
def test_at_rest_noise_of_the_sensors_moves_no_valve(scheme):
    crane, rng = Crane(Settings(scheme=scheme)), np.random.default_rng(3)
    crane.play(MOVING, 0.5)
    commands, _ = crane.play(
        Levers(0.0, 0.0, 0.0), 6.0, lambda q: tuple((q + rng.normal(0.0, 2e-4, 3)).tolist())
    )
    opened = np.abs(commands[-400:]) > 0.02  # V, the driver's hold zone
    assert np.count_nonzero(opened) <= 0.01 * opened.size
