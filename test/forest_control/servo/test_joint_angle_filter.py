"""Claims about where boom and stick are taken to be: the cylinders tell the truth, and nothing jumps."""

import math

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.config.controller_settings import Settings
from forest_control.operator.levers import Levers
from forest_control.pipeline import controller
from forest_control.pipeline.control_state import REST, Inputs
from forest_control.servo.joint_angle_filter import (
    NONE,
    UNREAD,
    AngleCorrection,
    Source,
    corrected_angles,
    latched_correction,
    updated_correction,
)
from forest_control.servo.schemes import Scheme
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
LINKAGES = MACHINE.linkages
TRUE = (0.2, 0.4, -1.5)
BIAS = (0.0, 0.002, -0.0015)  # [rad] of the resolvers
PERIOD = 0.005
CENTRED, PUSHED = Levers(0.0, 0.0, 0.0), Levers(0.0, 0.5, 0.3)


def read(true=TRUE, rng=None):
    """Return what resolvers and transducers read."""
    noise = (0.0,) * 5 if rng is None else rng.normal(0.0, (2e-4, 2e-4, 2e-4, 1.8e-4, 1.8e-4)).tolist()
    s = tuple(q + b + n for q, b, n in zip(true, BIAS, noise, strict=False))
    lengths = [cylinder_length(true[i + 1], LINKAGES[i]) + noise[3 + i] for i in (0, 1)]
    return s, (lengths[0], lengths[1])


GOOD = read()[1]


def settled(count, rng=None):
    c = NONE
    for _ in range(count):
        c = updated_correction(c, *read(rng=rng), LINKAGES, PERIOD)
    return c


def parameters(scheme=Scheme.COORDINATED, source=Source.CYLINDERS):
    return controller_settings.parameters(MACHINE, Settings(scheme=scheme, position_source=source))


class Crane:
    """An ideal machine under control whose resolvers are off."""

    def __init__(self, p, rng=None):
        self.p, self.rng, self.angles, self.state, self.command = p, rng, TRUE, REST, (0.0,) * 3

    def step(self, levers=CENTRED, enabled=True, blind=False):
        s, lengths = read(self.angles, self.rng)
        inputs = Inputs(s, self.state.rates, levers, enabled, UNREAD if blind else lengths)
        self.state, output = controller.step(self.state, inputs, self.p, PERIOD)
        self.angles = tuple(q + PERIOD * u for q, u in zip(self.angles, self.state.rates, strict=True))
        self.command = output.command
        return corrected_angles(s, self.state.correction)


def test_the_resolvers_static_error_is_learnt_away():
    assert corrected_angles(read()[0], latched_correction(settled(1), Source.CYLINDERS)) == pytest.approx(
        TRUE, abs=1e-12
    )


def test_noise_is_averaged_and_stays_the_resolvers():
    rng = np.random.default_rng(0)
    c = latched_correction(settled(400, rng), Source.CYLINDERS)
    seen = np.array([corrected_angles(read(rng=rng)[0], c) for _ in range(2000)])
    assert np.abs(seen.mean(axis=0) - TRUE).max() < 7e-5
    assert seen.std(axis=0) == pytest.approx(2e-4, rel=0.1)


@pytest.mark.parametrize(
    "lengths",
    [
        UNREAD,
        (math.nan, read()[1][1]),
        (0.1, read()[1][1]),
        (1e300, -1.0),
        (read()[1][0] + 0.2, read()[1][1]),
    ],
    ids=["none", "one", "no triangle", "nonsense", "far off"],
)
def test_a_transducer_that_cannot_be_right_teaches_nothing(lengths):
    known = settled(3)
    assert updated_correction(known, read()[0], lengths, LINKAGES, PERIOD) == known


def taught(c, boom, stick):
    """The correction after a sample of transducers that differ so much from the resolvers [rad]."""
    s = (0.0, TRUE[1] - boom, TRUE[2] - stick)
    return updated_correction(c, s, GOOD, LINKAGES, PERIOD)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_tenth_of_a_radian_is_the_farthest_that_either_may_be_off(side):
    assert taught(NONE, side * 0.099, -side * 0.098)[:2] == pytest.approx((side * 0.099, -side * 0.098))
    assert taught(NONE, side * 0.101, 0.0) == taught(NONE, 0.0, side * 0.101) == NONE


def test_the_first_samples_are_averaged_and_later_ones_low_passed_by_5_s():
    few = taught(AngleCorrection(0.01, -0.02, 3, True), 0.03, 0.04)
    assert few == (pytest.approx(0.015), pytest.approx(-0.005), 4, True)
    share = 1.0 - math.exp(-PERIOD / 5.0)
    many = taught(AngleCorrection(0.01, -0.02, 5000), 0.03, 0.04)
    assert many[:3] == (pytest.approx(0.01 + share * 0.02), pytest.approx(-0.02 + share * 0.06), 5001)


def test_a_correction_is_used_that_was_learnt_and_is_wanted():
    learnt = AngleCorrection(0.01, -0.02, 1)
    assert latched_correction(learnt, Source.CYLINDERS) == (0.01, -0.02, 1, True)
    assert not latched_correction(learnt, Source.JOINTS).used
    assert not latched_correction(NONE, Source.CYLINDERS).used
    assert corrected_angles((1.0, 2.0, 3.0), learnt) == (1.0, 2.0, 3.0)
    assert corrected_angles((1.0, 2.0, 3.0), learnt._replace(used=True)) == pytest.approx((1.0, 2.01, 2.98))


def test_without_transducers_the_resolvers_are_taken():
    crane = Crane(parameters())
    assert crane.step(blind=True) == read()[0]


@pytest.mark.parametrize("scheme", list(Scheme))
def test_nothing_jumps_when_the_cylinders_vanish_in_motion_and_come_back(scheme):
    crane, angles, commands = Crane(parameters(scheme)), [], []
    for k in range(400):
        moving = k >= 60
        seen = crane.step(PUSHED if moving else CENTRED, blind=200 <= k < 300)
        angles.append(np.subtract(seen, crane.angles))
        commands.append(crane.command)
    assert np.abs(crane.angles - np.array(TRUE)).max() > 0.05
    jumps = np.abs(np.diff(commands[150:], axis=0)).max(axis=1)
    assert jumps.max() < 0.05  # [V]; 2 mrad at K_p would be 0.3
    rate = PERIOD * np.abs(crane.state.rates).max()
    assert np.abs(angles[-1]).max() < rate + 1e-4  # it still goes by the cylinders


def test_the_source_is_chosen_at_rest_and_kept_in_motion():
    crane = Crane(parameters(source=Source.JOINTS))
    for _ in range(100):
        crane.step()
    for _ in range(100):
        crane.step(PUSHED)
    crane.p = parameters(source=Source.CYLINDERS)
    for _ in range(20):
        crane.step(PUSHED)
        assert not crane.state.correction.used
    for _ in range(100):
        crane.step(enabled=False)
    assert crane.state.correction.used
    crane.p = parameters(source=Source.JOINTS)
    crane.step()
    assert not crane.state.correction.used


def test_what_is_learnt_at_rest_moves_nothing():
    crane = Crane(parameters(), np.random.default_rng(3))
    for _ in range(60):
        crane.step()
    there = crane.angles
    for _ in range(400):
        crane.step()
        assert max(map(abs, crane.command)) < 1e-6
    assert crane.angles == pytest.approx(there, abs=1e-7)
