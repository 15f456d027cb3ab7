"""The built-in inputs do what they are documented to do; a voltage file is held between its rows."""

import pickle

import numpy as np
import pytest

from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.voltage_profiles import InputError, read_voltages


def volts(voltages, *times):
    return voltages.at(np.array(times)).tolist()


@pytest.fixture
def table(tmp_path):
    def write(text):
        path = tmp_path / "volts.csv"
        path.write_text(text)
        return path

    return write


def test_steps_drive_one_axis_at_a_time_to_both_sides():
    step = voltage_profiles.steps(4.0)
    assert step.duration == 9.5
    assert volts(step, 0.0, 0.5, 1.499, 1.5) == [[0, 0, 0], [4, 0, 0], [4, 0, 0], [0, 0, 0]]
    assert volts(step, 2.5, 4.0, 5.5, 7.0, 8.5) == [[-4, 0, 0], [0, 4, 0], [0, -4, 0], [0, 0, 4], [0, 0, -4]]
    assert volts(step, 9.4) == [[0, 0, 0]]


def test_the_chirp_sweeps_each_axis_from_the_first_to_the_last_frequency():
    h = 1e-4
    chirp = voltage_profiles.chirp(3.0, 0.5, 5.0, 60.0)
    for axis in range(3):
        time = np.arange(0.0, 20.0, h)
        wave = chirp.at(20.0 * axis + time)
        assert np.count_nonzero(np.delete(wave, axis, axis=1)) == 0
        assert np.abs(wave[:, axis]).max() == pytest.approx(3.0, abs=1e-3)
        crossings = time[:-1][np.diff(np.sign(wave[:, axis])) != 0]
        assert 0.5 / (crossings[2] - crossings[1]) == pytest.approx(0.5, rel=0.25)
        assert 0.5 / (crossings[-1] - crossings[-2]) == pytest.approx(5.0, rel=0.02)
        assert len(crossings) == pytest.approx(2 * 20.0 * (5.0 - 0.5) / np.log(10.0), abs=2)


def test_a_chirp_whose_frequencies_fall_is_refused():
    with pytest.raises(InputError, match="from 5 to 1 Hz; allowed: 0 < from < to"):
        voltage_profiles.chirp(3.0, 5.0, 1.0)


def test_the_thesis_input_pulls_swing_and_stick_both_ways_without_jumps():
    thesis = voltage_profiles.thesis(5.0)
    wave = thesis.at(np.arange(0.0, thesis.duration, 1e-3))
    assert wave.max(axis=0).tolist() == [5.0, 0.0, 5.0]
    assert wave.min(axis=0).tolist() == [-5.0, 0.0, -5.0]
    assert np.abs(np.diff(wave, axis=0)).max() <= 5.0 / 0.3 * 1e-3 + 1e-9
    assert volts(thesis, thesis.duration) == [[0.0, 0.0, 0.0]]


def test_a_row_of_a_file_holds_until_the_next_and_the_last_to_the_end(table):
    given = read_voltages(table("time,swing,boom,stick\n0.1,1,2,3\n0.3,-1,0,0.5\n"))
    assert given.duration == 0.3
    assert volts(given, 0.0, 0.1, 0.299, 0.3, 99.0) == [
        *([0, 0, 0], [1, 2, 3], [1, 2, 3]),
        *([-1, 0, 0.5], [-1, 0, 0.5]),
    ]


def test_a_row_acts_at_its_step_in_spite_of_rounding(table):
    given = read_voltages(table("time,swing,boom,stick\n0.3,1,0,0\n"))
    assert volts(given, 3 * 0.1 - 1e-16, 0.1 + 0.1 + 0.1) == [[1, 0, 0], [1, 0, 0]]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", ":1: the header must be time,swing,boom,stick, found nothing"),
        ("t,a,b,c\n", ":1: the header must be time,swing,boom,stick, found t,a,b,c"),
        ("time,swing,boom,stick\n", ":1: no rows below the header"),
        ("time,swing,boom,stick\n0,1,2\n", ":2: 3 columns; allowed are the 4 of the header"),
        ("time,swing,boom,stick\n0,1,2,x\n", ":2: stick is 'x'; allowed: -100 .. 100 V"),
        ("time,swing,boom,stick\n0,1,2,nan\n", ":2: stick is 'nan'; allowed: -100 .. 100 V"),
        ("time,swing,boom,stick\n-1,1,2,3\n", ":2: time is '-1'; allowed: 0 .. 86400 s"),
        ("time,swing,boom,stick\n0,1,2,3\n\n0,1,2,3\n", ":4: time is 0 after 0; times must rise"),
    ],
)
def test_a_bad_file_is_told_by_name_line_and_what_is_allowed(table, text, complaint):
    path = table(text)
    with pytest.raises(InputError) as caught:
        read_voltages(path)
    assert str(caught.value).startswith(str(path) + complaint)


def test_a_file_that_is_not_there_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"nowhere.csv: cannot be read as CSV: .*No such file"):
        read_voltages(tmp_path / "nowhere.csv")


@pytest.mark.parametrize(
    "voltages", [voltage_profiles.steps(), voltage_profiles.chirp(), voltage_profiles.thesis()]
)
def test_inputs_go_to_other_processes(voltages):
    times = np.linspace(0.0, 60.0, 1001)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(voltages)).at(times), voltages.at(times))
