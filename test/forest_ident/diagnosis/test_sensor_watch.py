import math

import numpy as np

from forest_ident.diagnosis.sensor_watch import UNSEEN, heard, is_frozen, is_missing, judged

NOISE = np.random.default_rng(2).normal(size=(60, 100))


def lived(windows, sensor=UNSEEN, stands=True):
    for window in windows:
        for reading in window:
            sensor = heard(sensor, reading)
        sensor = judged(sensor, stands)
    return sensor


def test_a_sensor_that_jittered_and_repeats_itself_for_two_seconds_is_frozen():
    lively = lived(NOISE[:20])
    assert not is_frozen(lively)
    assert not is_frozen(lived([[0.3] * 100] * 3, lively))
    frozen = lived([[0.3] * 100] * 5, lively)
    assert is_frozen(frozen)
    assert not is_frozen(lived(NOISE[:1], frozen))


def test_an_exact_sensor_of_a_standing_machine_is_not_frozen():
    moving = lived(NOISE[:40], stands=False)  # it changes, but only because the machine moves
    assert not is_frozen(lived([[0.3] * 100] * 50, moving))


def test_a_transducer_at_zero_is_at_the_end_of_its_range():
    assert not is_frozen(lived([[0.0] * 100] * 50, lived(NOISE[:20])))


def test_a_sensor_is_missing_where_the_file_has_it_or_where_it_was():
    silent = [[math.nan] * 100]
    assert is_missing(lived(silent * 2), fitted=1)
    assert not is_missing(lived(silent * 2), fitted=0)
    assert not is_missing(lived(silent), fitted=1)
    assert is_missing(lived(silent * 2, lived(NOISE[:1])), fitted=0)


def test_a_sensor_that_loses_samples_is_there():
    assert not is_missing(lived([[math.nan] * 99 + [1.0]] * 10), fitted=1)
