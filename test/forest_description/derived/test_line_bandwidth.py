"""Claims about the one-lump limit: the thesis' own figure, what its own hose says, and the warning."""

import dataclasses
import math

import pytest

from forest_description.derived.line_bandwidth import lump_frequency, lump_limit, one_lump_warnings
from forest_description.derived.temperature import at_temperature
from forest_description.hydraulics.hose import BLASIUS, GeometricHose
from forest_description.machine import load_machine

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
RIGID = GeometricHose(0.01905, None, BLASIUS, 1e-3)


def test_the_thesis_has_51_hertz_for_4_metres_of_its_oil():
    assert lump_frequency(math.sqrt(1.6e9 / 970.0), 4.0) == pytest.approx(51.0, abs=0.2)


def test_the_thesis_own_hose_allows_less_than_half_of_that():
    """Measured I and C: a wave at 574 m/s instead of 1284 m/s."""
    four_metres = dataclasses.replace(THESIS.boom, line_1_length=4.0)
    limit = lump_limit(dataclasses.replace(THESIS, boom=four_metres), 1, 1)
    assert limit == pytest.approx(lump_frequency(4.0 / math.sqrt(3.062e7 * 1.585e-12), 4.0), rel=1e-12)
    assert limit == pytest.approx(22.8, abs=0.1)


def test_a_rigid_hose_has_the_limit_of_its_oil():
    machine = dataclasses.replace(C180, hose=RIGID)
    for axis, port, length in ((0, 1, 1.0), (1, 2, 2.2), (2, 2, 4.9)):
        expected = lump_frequency(math.sqrt(1.6e9 / 860.0), length)
        assert lump_limit(machine, axis, port) == pytest.approx(expected, rel=1e-12)


def test_a_soft_wall_or_warm_oil_lowers_the_limit():
    rigid = dataclasses.replace(C180, hose=RIGID)
    soft = dataclasses.replace(C180, hose=dataclasses.replace(RIGID, wall_modulus=1.6e9))
    assert lump_limit(soft, 2, 2) == pytest.approx(lump_limit(rigid, 2, 2) / math.sqrt(2.0), rel=1e-12)
    assert lump_limit(at_temperature(rigid, 353.15), 2, 2) < lump_limit(rigid, 2, 2)


def test_no_hose_is_faster_than_sound_in_its_oil():
    quick = dataclasses.replace(C180.hose, capacitance=1e-15)
    expected = lump_frequency(math.sqrt(1.6e9 / 860.0), 1.0)
    assert lump_limit(dataclasses.replace(C180, hose=quick), 0, 1) == pytest.approx(expected, rel=1e-12)
    without_oil = dataclasses.replace(C180, hose=quick, oil=None)
    assert lump_limit(without_oil, 0, 1) > 10.0 * expected


def test_below_every_limit_there_is_no_warning():
    for machine in (C180, THESIS):
        assert one_lump_warnings(machine, 15.0) == []


def test_the_warning_names_hose_length_limit_and_frequency_and_what_to_do():
    (warning,) = one_lump_warnings(C180, 20.0)
    for part in ("stick: ", "hose 2 (4.9 m)", "below 18.6 Hz", "eq. 3.3", "20 Hz", "stick.line_2_length"):
        assert part in warning
    assert [text[:12] for text in one_lump_warnings(C180, 60.0)] == [
        "boom: one lu",
        "boom: one lu",
        "stick: one l",
        "stick: one l",
    ]


def test_a_hose_at_its_very_limit_is_warned_of():
    limit = lump_limit(C180, 2, 2)
    assert one_lump_warnings(C180, limit)
    assert not one_lump_warnings(C180, limit * (1.0 - 1e-9))


@pytest.mark.parametrize(("axis", "port"), [(3, 1), (0, 0)])
def test_a_hose_that_is_not_there_is_refused(axis, port):
    with pytest.raises(ValueError, match="axes are 0, 1, 2 and ports 1, 2"):
        lump_limit(C180, axis, port)
