"""The matrix' plants: what a change does on cranes that nobody knows exactly.

Plants whose head is heavier than the crane may lift are left out: there the load-moment limit decides.
"""

import itertools

import numpy as np

from forest_description.machine import Machine
from forest_study.ablation.constants import Settings
from forest_study.closed_loop import model_mismatch
from forest_study.matrix.matrix_rows import MatrixRow, matrix_rows
from forest_study.matrix.matrix_runs import lifted, run_row
from forest_study.matrix.rivals import Rival

NOT_ENDED = "not ended"
TRIED = 20  # seeds for each plant: a crane that lifts less than a twentieth of them has fewer plants
FIGURES = {
    "plain": {"cross_track_rms_mm": "cross-track, mm", "governed_rms_mm": "governed, mm", "activity": "V/s"},
    "both": {"cross_track_rms_mm": "cross-track, mm", "governed_rms_mm": "governed, mm"},
    "slow": {"cross_track_rms_mm": "cross-track, mm", "velocity_rms": "velocity, m/s"},
    "inch": {"end_mm": "end, mm", "overshoot_mm": "overshoot, mm"},
}
"""What is told of which row of the matrix: by the name in `matrix.figures.Figures`, name and unit."""


def plants(machine: Machine, settings: Settings, number: int) -> dict[str, float]:
    """Return median and worst of the figures over some plants of each row, and how many did not end.

    Raises:
        ValueError: none of a row's plants came to an end.
    """
    law, lost, found = Rival(settings.control, settings.drive), 0, dict[str, float]()
    for row, told in FIGURES.items():
        of = matrix_rows()[row]
        outcomes = run_row(of, machine, liftable(of, machine, number), settings.drive.adapt, rival=law)
        ended = [one.figures for one in outcomes if one.figures is not None]
        if not ended:
            raise ValueError(f"no plant of the row {row} comes to its end")
        lost += len(outcomes) - len(ended)
        for name, text in told.items():
            values = [float(getattr(figures, name)) for figures in ended]
            found[f"{row}, median, {text}"] = float(np.median(values))
            found[f"{row}, worst, {text}"] = max(values)
    return found | {NOT_ENDED: float(lost)}


def liftable(row: MatrixRow, machine: Machine, number: int) -> list[int]:
    """Return the first seeds whose head the machine's file lets it lift on the row's paths."""
    most = lifted(row, machine)
    seeds = range(TRIED * number)
    within = (seed for seed in seeds if (model_mismatch.draw(seed, row.ranges).head or 0.0) <= most)
    return list(itertools.islice(within, number))
