"""docs/explanation/equations.md agrees on one lump per hose with the modes, the hoses' limits and `check`."""

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from forest_description.derived.limits import joint_limits
from forest_description.derived.line_bandwidth import lump_limit
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.analysis.machine_check import warnings
from forest_sim.analysis.modes import SHUT, modes, slow_modes
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.manipulator import dynamics
from forest_sim.simulation.open_loop import start_angles

DOCS = Path(__file__).parents[3] / "docs" / "explanation" / "equations.md"
C180 = load_machine("c180_hoses")
P = plant_parameters(C180)
START = start_angles(C180)


def cells(head):
    """The cells after the first of each row, by the first one, of the table whose head begins so."""
    lines = iter(DOCS.read_text(encoding="utf-8").splitlines())
    next(line for line in lines if line.startswith(head))
    rows = itertools.takewhile(lambda line: line.startswith("|"), lines)
    parted = [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]
    return {row[0]: row[1:] for row in parted[1:]}


def slow(angles):
    return {axis: mode.frequency for axis, mode in slow_modes(modes(angles, SHUT, P)).items()}


def residual(frequency, places):
    """det(K(w) - w^2 M) of some axes over their masses, every hose a wave guide that is shut at its valve."""
    w = 2.0 * math.pi * frequency
    d = dynamics(START, (0.0, 0.0, 0.0), P.body)
    mass = np.array([[d.m_11, 0.0, 0.0], [0.0, d.m_22, d.m_23], [0.0, d.m_23, d.m_33]])
    arms = 1.0, lever_arm(START[1], P.boom_linkage), lever_arm(START[2], P.stick_linkage)
    stiffness = []
    for axis, arm in zip((P.swing, P.boom, P.stick), arms, strict=True):
        a = axis.actuator
        ports = ((a.displacement_1, axis.line_1), (a.displacement_2, axis.line_2))
        x = [w * math.sqrt(line.inertance * line.capacitance) for _, line in ports]
        shares = [arm * arm * area * area / line.capacitance for area, line in ports]
        stiffness.append(sum(k * y / math.tan(y) for k, y in zip(shares, x, strict=True)))
    system = (np.diag(stiffness) - w * w * mass)[np.ix_(places, places)]
    return float(np.linalg.det(system / np.diag(mass)[list(places)]))


def told(axis):
    """The docs' figures for an axis: one lump, with waves, (least, most), limit."""
    one, waves, span, limit = cells("| `c180_hoses` | one lump")[axis]
    least, most = span.split(" .. ")
    return float(one), float(waves), (float(least), float(most)), float(limit)


def test_the_docs_have_the_modes_of_one_lump_at_the_start_and_over_the_poses():
    ranges = [(low, 0.5 * (low + high), high) for low, high in joint_limits(C180)[1:]]
    poses = [slow((0.0, *pose)) for pose in itertools.product(*ranges)]
    for axis, frequency in slow(START).items():
        one, _, span, _ = told(axis)
        assert one == pytest.approx(frequency, abs=0.006)
        assert span == pytest.approx((min(p[axis] for p in poses), max(p[axis] for p in poses)), abs=0.006)


@pytest.mark.parametrize(
    ("axis", "places", "below", "above"),
    [("swing", (0,), 2.0, 5.0), ("boom", (1, 2), 5.0, 12.0), ("stick", (1, 2), 16.0, 23.0)],
)
def test_the_docs_have_what_the_waves_in_the_hoses_make_of_them(axis, places, below, above):
    with_waves = brentq(residual, below, above, args=(places,))
    one, waves, _, _ = told(axis)
    assert waves == pytest.approx(with_waves, rel=0.003)
    assert abs(one / waves - 1.0) < 0.01 if axis != "stick" else one / waves > 1.15


def test_the_docs_have_the_limits_and_the_command_warns_of_the_hoses_that_they_call_too_long():
    fastest = told("stick")[0]
    for axis, name in enumerate(AXES):
        assert told(name)[3] == pytest.approx(min(lump_limit(C180, axis, port) for port in (1, 2)), abs=0.06)
    warned = [
        re.match(r"(\w+): one lump stands for hose (\d) .* not up to ([\d.]+) Hz", w) for w in warnings(C180)
    ]
    assert [(w[1], w[2]) for w in warned] == [("stick", "1"), ("stick", "2")]
    assert all(float(w[3]) == pytest.approx(fastest, abs=0.06) for w in warned)
    too_long = [name for name in AXES if told(name)[0] >= told(name)[3]]
    assert too_long == ["stick"]


def test_the_docs_have_both_ends_of_the_loaders_dry_friction(capsys):
    from forest_sim.cli.main import main

    assert main(["modes", "--machine", "loader"]) == 0
    small, large = capsys.readouterr().out.split("large oscillations")
    for axis, (held, free) in cells("| `loader`, start pose").items():
        for said, printed in ((held, small), (free, large)):
            speed = re.search(r"[\d.]+ mm/s", said)[0]
            assert f"{axis} {speed}" in printed
            numbers = re.findall(r"[\d.]+", said.rpartition(",")[0])
            row = re.search(rf"([\d.]+) +([\d.]+) +{axis} +links", printed)
            assert (list(row.groups()) if row else []) == numbers
