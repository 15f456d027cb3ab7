"""The metering curve of a valve is read off its rig's record."""

import numpy as np
import pytest
from foreign_plants import foreign

from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.readings import openings
from forest_ident.model_choice import candidates
from forest_ident.model_choice.measured_curve import with_measured_curves
from forest_ident.refinement.identification import identify

CURVED = foreign("curved_valve", 1)


@pytest.fixture(scope="module")
def valve():
    return experiment("valve", CURVED.crane, seed=1)


def opening(machine, volts):
    """Return the flow through an edge of port 1 at one pressure drop, over voltages."""
    law = machine.valve.law
    shape = openings(volts, law.forward, law.curve)
    return shape / shape[-1]  # a fit finds the gain


def test_the_measured_curve_is_nearer_to_the_truth_than_the_straight_law_and_the_usual_notch(valve):
    straight = identify(CURVED.told, [valve], refine=False)
    usual = next(c for c in candidates.CANDIDATES if c.name == "curve").add(CURVED.told)
    measured = with_measured_curves(usual, [valve])
    volts = np.linspace(0.0, CURVED.crane.valve.rated_voltage, 60)
    truth = opening(CURVED.crane, volts)
    away = [np.max(np.abs(opening(m, volts) - truth)) for m in (measured, straight.machine, usual)]
    assert away[0] < 0.02
    assert away[0] < 0.5 * min(away[1:])


def test_without_a_record_of_the_rig_the_usual_curve_stays():
    usual = next(c for c in candidates.CANDIDATES if c.name == "curve").add(CURVED.told)
    assert with_measured_curves(usual, []) == usual
