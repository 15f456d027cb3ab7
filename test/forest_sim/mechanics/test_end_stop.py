"""Claims about the ends of a stroke: they push back, never pull, and give back less than they take."""

import math

import numpy as np
import pytest

from forest_sim.mechanics.end_stop import EndStop, end_stop_force, end_stop_resistance

STOP = EndStop(lower=1.3, upper=2.2, stiffness=3e8, damping=2e6)
NONE = EndStop(-math.inf, math.inf, 0.0, 0.0)


def test_between_the_ends_nothing_pushes():
    for position, speed in np.random.default_rng(1).uniform((1.3, -2.0), (2.2, 2.0), (100, 2)):
        assert end_stop_force(position, speed, STOP) == 0.0
        assert end_stop_resistance(position, speed, STOP, 1e-3) == 0.0


def test_beyond_an_end_a_spring_pushes_back_in():
    assert end_stop_force(1.3 - 1e-3, 0.0, STOP) == pytest.approx(3e5)
    assert end_stop_force(2.2 + 1e-3, 0.0, STOP) == pytest.approx(-3e5)


def test_moving_deeper_in_is_resisted_more():
    assert end_stop_force(1.3 - 1e-3, -0.1, STOP) == pytest.approx(3e5 + 2e5)
    assert end_stop_force(2.2 + 1e-3, 0.1, STOP) == pytest.approx(-3e5 - 2e5)


def test_a_stop_never_pulls_on_what_leaves_it():
    for depth, speed in np.random.default_rng(2).uniform((0.0, -5.0), (5e-3, 5.0), (200, 2)):
        assert end_stop_force(1.3 - depth, speed, STOP) >= 0.0
        assert end_stop_force(2.2 + depth, speed, STOP) <= 0.0
    assert end_stop_force(1.3 - 1e-3, 1.0, STOP) == 0.0
    assert end_stop_force(2.2 + 1e-3, -1.0, STOP) == 0.0


def test_both_ends_mirror_each_other():
    for depth, speed in np.random.default_rng(3).uniform((0.0, -1.0), (5e-3, 1.0), (100, 2)):
        assert end_stop_force(1.3 - depth, speed, STOP) == pytest.approx(
            -end_stop_force(2.2 + depth, -speed, STOP), rel=1e-6
        )


def test_the_force_does_not_jump_when_the_piston_arrives_however_fast():
    for speed in (0.05, 0.5, 5.0):
        forces = [end_stop_force(2.2 + depth, speed, STOP) for depth in np.linspace(0.0, 1e-3, 10_001)]
        assert max(np.abs(np.diff(forces))) < 1e-3 * -forces[-1]


@pytest.mark.parametrize("start", [1.3, 2.2])
def test_resistance_is_the_forces_slope_along_an_implicit_step(start):
    """Where the damper grips wholly, from a third of a millimetre on, and where it does not yet."""
    step, h, luck = 3e-4, 1e-6, np.random.default_rng(4)
    outward = math.copysign(1.0, start - 1.75)
    deep = luck.uniform((4e-4, -0.02), (5e-3, 0.5), (50, 2))
    shallow = luck.uniform((2e-5, -0.02), (1.5e-4, 0.4), (50, 2))
    for depth, speed in (*deep, *shallow):
        base, u = start + outward * depth, outward * speed

        def force(v, base=base):
            return end_stop_force(base + step * v, v, STOP)

        slope = (force(u - h) - force(u + h)) / (2.0 * h)
        assert end_stop_resistance(base + step * u, u, STOP, step) == pytest.approx(slope, rel=1e-4, abs=1.0)


def test_a_mass_leaves_the_stop_slower_than_it_came():
    position, speed, h = 2.2, 0.3, 1e-6
    while position >= 2.2:
        speed += h * end_stop_force(position, speed, STOP) / 3e4
        position += h * speed
    assert -0.3 < speed < -0.05


def test_a_machine_without_stops_feels_none():
    for position in (-1e6, 0.0, 1e6):
        assert end_stop_force(position, 3.0, NONE) == 0.0
        assert end_stop_resistance(position, 3.0, NONE, 1e-3) == 0.0
