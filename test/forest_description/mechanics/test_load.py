"""Claims about what hangs on the tip as a machine file describes it."""

import dataclasses

import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum

MANIPULATOR = load_machine("c180_hoses").manipulator
HANGING = dataclasses.replace(MANIPULATOR, pendulum=Pendulum(0.9, 60.0, 250.0))
LOADED = """based_on: c180_hoses
manipulator:
  log:
    mass: {value: 900, unit: kg, source: weighed}
    x: {value: 400, unit: mm, source: measured}
    y: {value: 0, unit: m, source: measured}
  pendulum:
    length: {value: 0.9, unit: m, source: measured}
    inertia: {value: 60, unit: kg*m2, source: computed}
    damping: {value: 250, unit: N*m*s/rad, source: "assumed: a brake link"}
"""


def test_shipped_machines_carry_nothing():
    for name in ("c180_hoses", "c180_thesis"):
        m = load_machine(name).manipulator
        assert (m.log, m.pendulum) == (None, None)


def test_a_machine_file_may_give_log_and_pendulum(tmp_path):
    path = tmp_path / "loaded.yaml"
    path.write_text(LOADED)
    m = load_machine(path).manipulator
    assert m.log == Log(900.0, 0.4, 0.0)
    assert m.pendulum == Pendulum(0.9, 60.0, 250.0)
    assert dataclasses.replace(m, log=None, pendulum=None) == MANIPULATOR


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"head_mass": 0.0}, "head_mass"),
        ({"log": Log(100.0, 0.5, 0.2)}, "y 0 m"),
        ({"log": Log(100.0, -0.5, 0.0)}, "x at least 0 m"),
        ({"head_folding": "half"}, "head_folding.*'half'.*thesis.*full"),
    ],
)
def test_what_cannot_be_is_refused(change, named):
    with pytest.raises(MachineError, match=named):
        dataclasses.replace(HANGING, **change)


def test_only_a_head_that_hangs_needs_its_log_on_the_axis():
    assert dataclasses.replace(MANIPULATOR, log=Log(100.0, -0.5, 0.2)).log == Log(100.0, -0.5, 0.2)
