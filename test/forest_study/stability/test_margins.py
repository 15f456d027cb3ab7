"""Margins against closed forms."""

import math

import numpy as np
import pytest

from forest_study.stability.margins import margins

FREQUENCY = np.geomspace(0.01, 50.0, 2000)
S = 2j * np.pi * FREQUENCY


def test_of_an_integrator_with_a_delay():
    gain, delay = 4.0, 0.05
    found = margins(FREQUENCY, gain * np.exp(-delay * S) / S)
    assert found.gain == pytest.approx(math.pi / (2.0 * delay * gain), rel=1e-3)
    assert found.gain_frequency == pytest.approx(1.0 / (4.0 * delay), rel=1e-3)
    assert found.phase == pytest.approx(90.0 - math.degrees(gain * delay), abs=0.1)
    assert found.crossover == pytest.approx(gain / (2.0 * math.pi), rel=1e-3)


def test_a_resonance_over_the_crossover_is_seen():
    gain, natural, damping = 3.0, 2.0 * math.pi * 4.0, 0.1
    loop = gain / S / (1.0 + 2.0 * damping * S / natural + (S / natural) ** 2)
    found = margins(FREQUENCY, loop)
    assert found.gain == pytest.approx(2.0 * damping * natural / gain, rel=1e-2)
    assert found.gain_frequency == pytest.approx(4.0, rel=1e-3)
    assert found.sensitivity == pytest.approx(np.max(np.abs(1.0 / (1.0 + loop))))
    loud = margins(FREQUENCY, 2.0 * loop)
    assert loud.gain < 1.0
    assert loud.phase < 0.0


def test_a_loop_that_never_turns_over_has_no_bound():
    found = margins(FREQUENCY, 1.0 / S)
    assert found.gain == math.inf
    assert math.isnan(found.gain_frequency)
    assert found.phase == pytest.approx(90.0, abs=0.01)


def test_a_phase_that_rises_over_the_bound_sets_none():
    assert margins(FREQUENCY, 4.0 * (S + 1.0) ** 2 / S**3).gain == math.inf
