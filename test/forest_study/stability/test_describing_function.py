"""Describing functions against first harmonics, and a limit cycle against the machine."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_study.ablation.bare_loop import Case, seen
from forest_study.stability.describing_function import limit_cycle, relay

PHASE = (np.arange(20000) + 0.5) * 2.0 * math.pi / 20000


def first_harmonic(answer, amplitude):
    """Return the gain from a sine to the first harmonic of the answer."""
    return 2.0 * np.mean(answer(amplitude * np.sin(PHASE)) * np.sin(PHASE)) / amplitude


@pytest.mark.parametrize("amplitude", [0.2, 1.0, 5.0])
def test_a_relay_beside_a_gain(amplitude):
    assert relay(0.3, amplitude) == pytest.approx(first_harmonic(lambda x: x + 0.3 * np.sign(x), amplitude))


def test_the_swing_cycles_as_it_is_told():
    """An overlap thought a tenth too wide, and nothing that would keep the loop from cycling."""
    machine = load_machine("c180_hoses")
    tip = start_tip(machine)
    told = limit_cycle(machine, pose_at(tip, machine), 0, 0.1, Settings())
    simulated = seen(Case(machine="c180_hoses", tip=tip, axis=0, overlap=1.1))
    assert told.angle == pytest.approx(simulated.amplitude, rel=0.25)
    assert told.frequency == pytest.approx(simulated.frequency, rel=0.35)


def test_an_overlap_thought_too_narrow_makes_no_limit_cycle():
    machine = load_machine("c180_hoses")
    assert limit_cycle(machine, pose_at(start_tip(machine), machine), 0, -0.1, Settings()) is None
