"""Claims about friction that sticks: curves, energy, and a stick-slip against an independent integration."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from forest_description.mechanics.drives import BearingFriction
from forest_sim.mechanics.bristles import NO_BRISTLES, bristles, rubbing, sliding_friction, stuck_after

BEARING = BearingFriction(
    coulomb_torque=800.0,
    breakaway_torque=1100.0,
    stribeck_speed=0.01,
    stiffness=1e7,
    damping=5e4,
    elastic_share=0.8,
)
LAW = bristles(BEARING)


def pulled(law, speed, way, step=1e-3):
    """Deflections and torques while the joint is pulled over a way [rad] at a speed [rad/s]."""
    z, rows = 0.0, []
    for _ in range(round(way / abs(speed) / step)):
        stuck = stuck_after(z, speed, step, law)
        z = stuck.deflection
        rows.append((z, stuck.force))
    return np.array(rows)


def test_before_it_slides_a_bearing_is_a_spring():
    z, torque = pulled(LAW, 1e-6, 6e-5)[-1]
    assert z == pytest.approx(6e-5, rel=1e-9)
    assert torque == pytest.approx(1e7 * 6e-5, rel=1e-3)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_pulled_slowly_it_breaks_away_at_its_breakaway_torque(sign):
    torques = pulled(LAW, sign * 1e-5, 1.5e-3)[:, 1]
    assert np.max(sign * torques) == pytest.approx(1100.0, rel=1e-3)


@pytest.mark.parametrize("speed", [1e-3, 5e-3, 0.01, 0.02, 0.3, -0.01])
def test_steady_sliding_follows_stribecks_curve(speed):
    expected = 800.0 + 300.0 / (1.0 + (speed / 0.01) ** 2)
    assert sliding_friction(speed, LAW) == pytest.approx(expected, rel=1e-12)
    end = pulled(LAW, speed, 5e-3)[-1]
    assert end[1] == pytest.approx(math.copysign(expected, speed), rel=1e-6)
    assert rubbing(end[0], speed, LAW).rate == pytest.approx(0.0, abs=1e-6 * abs(speed))


def test_friction_gives_energy_at_no_state():
    rng = np.random.default_rng(1)
    for z, u in zip(rng.normal(0.0, 2e-4, 3000), rng.normal(0.0, 1.0, 3000) ** 5, strict=True):
        rub = rubbing(z, u, LAW)
        assert rub.force * u - LAW.stiffness * z * rub.rate >= -1e-9


def test_a_step_solves_the_law_and_tells_its_slope():
    rng = np.random.default_rng(2)
    for z_0, u in zip(rng.normal(0.0, 1e-4, 500), 0.05 * rng.normal(0.0, 1.0, 500) ** 3, strict=True):
        h, d = 3e-4, 1e-4 * abs(u)
        stuck = stuck_after(z_0, u, h, LAW)
        rub = rubbing(stuck.deflection, u, LAW)
        if z_0 * u > 0.0:  # else the known part lies on the other side, where a step may not end
            assert stuck.deflection == pytest.approx(z_0 + h * rub.rate, abs=1e-15)
            assert stuck.force == pytest.approx(rub.force, rel=1e-9)
        if abs(u) < 1e-9:
            continue  # too slow for a difference
        sides = [stuck_after(z_0, u + s * d, h, LAW).force for s in (1, -1)]
        assert stuck.resistance == pytest.approx((sides[0] - sides[1]) / (2.0 * d), rel=1e-3, abs=10.0)


def pulled_mass(law, torque, seconds, h=1e-3, inertia=2e4):
    """Angles, speeds and deflections of an inertia under a torque of angle and time, by implicit steps."""
    q = u = z = 0.0
    rows = []
    for k in range(round(seconds / h)):
        guess = u
        for _ in range(30):
            stuck = stuck_after(z, guess, h, law)
            pull, slope = torque(q + h * guess, (k + 1) * h)
            change = (inertia * (guess - u) + h * (stuck.force - pull)) / (
                inertia + h * (stuck.resistance + h * slope)
            )
            guess -= change
            if abs(change) < 1e-13:
                break
        z, u = stuck_after(z, guess, h, law).deflection, guess
        q += h * u
        rows.append((q, u, z))
    return np.array(rows).T


def test_a_trembling_load_below_the_elastic_share_does_not_drift():
    """LuGre's bristles creep under such a load; these only bend (Dupont et al. 2002, section II)."""
    q, _, z = pulled_mass(
        LAW, lambda _, t: (min(1.0, 0.5 * t) * (450.0 + 100.0 * math.sin(3.0 * t)), 0.0), 20.0
    )
    assert np.ptp(q[10_000:]) > 1e-5
    np.testing.assert_allclose(q, z, rtol=0.0, atol=1e-15)


PULL = dataclasses.replace(BEARING, coulomb_torque=2000.0, breakaway_torque=6000.0)
INERTIA, SPRING, TURNED = 2e4, 3e5, 0.008  # kg m2, N m/rad, rad/s of the spring's far end


def slipping(t, y):
    """Dupont's law, written apart: joint angle, rate and bristles of an inertia that a spring pulls along."""
    q, u, z = y
    slide = (2000.0 + 4000.0 / (1.0 + (u / 0.01) ** 2)) / 1e7
    bend = 0.8 * 2000.0 / 1e7
    yielding = max(0.0, (abs(z) - bend) / (slide - bend)) if z * u > 0.0 else 0.0
    rate = u * (1.0 - yielding)
    friction = 1e7 * z + 5e4 / (1.0 + (5e4 * u / 2000.0) ** 2) * rate
    return [u, (SPRING * (TURNED * t - q) - friction) / INERTIA, rate]


def test_stick_slip_has_the_amplitude_and_period_of_an_independent_integration():
    h, seconds = 1e-3, 20.0
    q, _, _ = pulled_mass(
        bristles(PULL), lambda q, t: (SPRING * (TURNED * t - q), SPRING), seconds, h, INERTIA
    )
    times = h * np.arange(1, len(q) + 1)
    truth = solve_ivp(slipping, (0.0, seconds), [0.0] * 3, method="Radau", t_eval=times, rtol=1e-6, atol=1e-9)
    ours, theirs = (SPRING * (TURNED * times - angle)[5000:] for angle in (q, truth.y[0]))
    assert np.ptp(theirs) > 3000.0  # it does stick and slip
    assert np.ptp(ours) == pytest.approx(np.ptp(theirs), rel=0.02)
    slips = [np.flatnonzero(np.diff(np.sign(torque - np.mean(theirs))) < 0) for torque in (ours, theirs)]
    assert len(slips[1]) >= 3
    assert np.mean(np.diff(slips[0])) == pytest.approx(np.mean(np.diff(slips[1])), rel=0.02)


def test_no_friction_is_none():
    assert bristles(None) == NO_BRISTLES
    assert rubbing(1e-4, 1.0, NO_BRISTLES) == (0.0, 0.0)
    assert stuck_after(0.0, 1.0, 1e-3, NO_BRISTLES) == (0.0, 0.0, 0.0)
