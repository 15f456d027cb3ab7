"""A study's file is read and checked before anything runs."""

import math

import pytest

from forest_study.results import StudyError
from forest_study.sweep.study import Span, read_study

WHOLE = """
kind: track
with: {machine: c180_hoses, noise: false}
vary:
  path: [sweep, radial]
  plant.manipulator.platform_tilt: {low: -5, high: 5, unit: deg}
  control.feedback_gain.boom: {low: 1, high: 4}
design: sobol
points: 8
seeds: 3
seed: 10
"""


@pytest.fixture
def read(tmp_path):
    """Read a study's text."""

    def read(text):
        file = tmp_path / "study.yaml"
        file.write_text(text, encoding="utf-8")
        return read_study(file)

    return read


def test_a_study_is_read_with_machines_numbers_in_si(read):
    study = read(WHOLE)
    assert study.common == {"machine": "c180_hoses", "noise": False}
    assert study.lists == {"path": ("sweep", "radial")}
    tilt = study.ranges["plant.manipulator.platform_tilt"]
    assert tilt == pytest.approx((-math.radians(5.0), math.radians(5.0)))
    assert study.ranges["control.feedback_gain.boom"] == Span(1.0, 4.0)
    assert (study.design, study.points, study.seeds) == ("sobol", 8, range(10, 13))


def test_a_number_of_the_machine_may_be_a_list_with_its_unit(read):
    study = read("vary: {machine.manipulator.head_mass: {values: [200, 400], unit: kg}}")
    assert study.lists == {"machine.manipulator.head_mass": (200.0, 400.0)}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[1, 2]", "the study is no mapping"),
        ("vary: {speed: {low: 1", "not YAML"),
        ("kind: dance", "'kind' is 'dance'; allowed: one of track, placing"),
        ("hurry: true", "'hurry'; allowed: kind, design"),
        ("with: {paht: sweep}", "paht: not a key of this kind; allowed: machine, model, path"),
        ("with: {speed: 7}", "0.01 .. 3 m/s"),
        ("with: {path: nowhere}", "no path of this name"),
        ("with: {step: 0.002}", "step is 0.002 s; allowed: 0.005 s over a whole number"),
        ("vary: {step: [0.001, 0.01]}", "0.00025 .. 0.005 s"),
        ("with: {machine: c181}", "no machine named 'c181'"),
        ("with: {speed: 0.5}\nvary: {speed: [0.4]}", "vary.speed stands under with, too"),
        ("vary: {speed: [0.4, 0.4]}", "has a value twice"),
        ("vary: {speed: []}", "allowed: a list of values"),
        ("vary: {speed: {low: 0.3, high: 0.6}}", "grid for lists alone"),
        ("vary: {speed: {low: 0.6, high: 0.3}}\ndesign: sobol", "low less than high"),
        ("vary: {speed: {low: 0.3, high: 0.6}}\ndesign: sobol\npoints: 12", "a power of two"),
        (
            "vary: {plant.manipulator.head_mass: [200]}",
            "needs its unit; allowed: {value: NUMBER, unit: kg or",
        ),
        ("vary: {plant.manipulator.head_mas: {values: [2], unit: kg}}", "no number of this name"),
        ("vary: {plant.manipulator.head_mass: {values: [-2], unit: kg}}", "allowed: 0 .. 1e+06 kg"),
        ("vary: {control.tip_accel: [2]}", "'tip_accel' is unknown"),
        ("vary: {control.tip_acceleration: [200]}", "-1 .. 20"),
        ("kind: placing\nvary: {control.tip_acceleration: [2]}", "not a key of this kind"),
        ("with: {mismatch: dedband=1}", "'dedband=1'"),
        (
            (
                "with: {machine: c180_hoses}\n"
                "vary: {plant.boom.elasticity.stiffness: {values: [1e7], unit: N*m/rad}}"
            ),
            "is not there",
        ),
    ],
)
def test_what_is_wrong_is_named_with_what_is_allowed(read, text, told):
    with pytest.raises(StudyError) as caught:
        read(text)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
