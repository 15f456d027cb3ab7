"""What a change does on the matrix' plants: the matrix' own figures, of plants that the crane may lift."""

import pytest

pytest.importorskip("llvmlite")

from forest_description.machine import load_machine
from forest_study.ablation import plants
from forest_study.ablation.constants import changed
from forest_study.ablation.plants import NOT_ENDED, liftable
from forest_study.matrix.matrix_rows import matrix_rows
from forest_study.matrix.matrix_runs import run_row

REAL, INCH = load_machine("c180"), matrix_rows()["inch"]


def test_the_plants_are_the_matrix_first_that_the_crane_may_lift():
    outcomes = run_row(INCH, REAL, range(12))
    within = [one.seed for one in outcomes if not one.overloaded]
    assert 0 < len(within) < 12
    assert liftable(INCH, REAL, len(within)) == within


def test_figures_are_median_and_worst_of_the_matrix_and_heed_a_change(monkeypatch):
    monkeypatch.setattr(plants, "FIGURES", {"inch": {"end_mm": "end, mm"}})
    settings = changed({})
    ends = sorted(one.figures.end_mm for one in run_row(INCH, REAL, liftable(INCH, REAL, 3)))
    found = plants.plants(REAL, settings, 3)
    assert found == {"inch, median, end, mm": ends[1], "inch, worst, end, mm": ends[2], NOT_ENDED: 0.0}
    assert plants.plants(REAL, changed({"valve_driver.adapt": False}), 3) != found


def test_a_row_in_which_no_plant_ends_is_a_failure_of_control(monkeypatch):
    lost = run_row(INCH, REAL, [0])[0]._replace(figures=None)
    monkeypatch.setattr(plants, "run_row", lambda *_, **__: [lost])
    with pytest.raises(ValueError, match="no plant of the row plain"):
        plants.plants(REAL, changed({}), 1)
