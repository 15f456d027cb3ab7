"""Pictures of the report show what they are for."""

import matplotlib as mpl
import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.report import report_plots


@pytest.mark.parametrize("draw", [report_plots.inertance, report_plots.capacitance])
def test_a_jump_between_two_samples_does_not_shrink_the_picture(draw):
    mpl.use("Agg")
    from matplotlib import pyplot

    machine = load_machine("c180_hoses")
    figure, axes = pyplot.subplots()
    draw(axes, machine, experiment("hose", machine, seed=3, longest=16.0))
    read, fitted = axes.lines
    x, y = read.get_data()
    inside = np.abs(x) < axes.get_xlim()[1]
    assert 0.97 < np.mean(inside) < 1.0
    ends = np.interp(fitted.get_xdata(), *fitted.get_data())
    assert ends[1] > 0.7 * axes.get_ylim()[1]  # the line fills it
    slope = ends[1] / fitted.get_xdata()[1]
    assert np.median(np.abs(y - slope * x)[inside]) < 0.05 * ends[1]
    pyplot.close(figure)
