"""Claims about joystick inputs: the thesis' test input, and files of levers."""

import math

import numpy as np
import pytest
from recorded import recorded

from forest_control.operator.joystick_sources import (
    THESIS_DURATION,
    LeverError,
    read_levers,
    thesis_levers,
    thesis_tip_velocity,
)
from forest_control.operator.levers import REST, Levers

HEADER = "time_s,swing,boom,stick\n"


@pytest.fixture
def written(tmp_path):
    def write(text, encoding="utf-8"):
        path = tmp_path / "levers.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


@pytest.mark.parametrize(
    ("time", "x", "z"),
    [
        *((0.0, 0, 0), (0.999, 0, 0), (1.0, 0.30, 0), (2.499, 0.30, 0), (2.5, 0.30, 0.25)),
        *((3.999, 0.30, 0.25), (4.0, 0, 0.25), (5.499, 0, 0.25), (5.5, 0, 0), (9.0, 0, 0)),
    ],
)
def test_thesis_input_steps_in_x_and_z_when_it_should(time, x, z):
    assert thesis_tip_velocity(time)[::2] == (x, z)


def test_thesis_input_swings_in_y_from_the_start():
    time = np.linspace(0.0, THESIS_DURATION, 20001)
    y = np.array([thesis_tip_velocity(t)[1] for t in time])
    assert y[0] == 0.0
    assert y[1] > 0.0
    assert max(y) == pytest.approx(0.47, rel=1e-4)
    rising = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    assert np.diff(time[rising]) == pytest.approx(1.0 / 1.18, abs=1e-3)


def test_thesis_levers_wish_the_thesis_velocity_and_stay_within_their_range():
    for time in np.linspace(0.0, THESIS_DURATION, 501).tolist():
        levers = thesis_levers(time, 0.5)
        wish = 0.5 * levers.stick, 0.5 * levers.swing, 0.5 * levers.boom
        assert wish == pytest.approx(thesis_tip_velocity(time), abs=1e-15)
        assert max(map(abs, levers)) <= 1.0


def test_levers_go_on_lines_from_row_to_row(written):
    record = read_levers(written(HEADER + "0.5,0.1,-0.2,0.3\n0.55,0.2,-0.2,0\n0.6,0,0.5,0\n"))
    assert record.at(0.5) == Levers(0.1, -0.2, 0.3)
    assert record.at(0.51) == pytest.approx((0.12, -0.2, 0.24))
    assert record.at(0.575) == pytest.approx((0.1, 0.15, 0.0))
    assert record.at(0.6) == Levers(0.0, 0.5, 0.0)


@pytest.mark.parametrize("gap", [0.1, 0.4, 3.0])
def test_a_row_that_is_followed_late_holds_until_a_tenth_of_a_second_before_the_next(written, gap):
    record = read_levers(written(HEADER + f"0,0.2,0,0\n{gap},1,-1,0\n"))
    assert record.at(gap - 0.1 - 1e-9) == (Levers(0.2, 0.0, 0.0) if gap > 0.1 else REST)
    assert record.at(gap - 0.05) == pytest.approx((0.6, -0.5, 0.0))
    assert record.at(gap) == Levers(1.0, -1.0, 0.0)


def test_samples_as_they_are_hold_until_the_next(written):
    record = read_levers(written(HEADER + "0.5,0.1,-0.2,0.3\n0.7,1,-1,0\n1.0,0,0.5,0\n"))
    record = record._replace(interpolated=False)
    assert record.at(0.5) == record.at(0.6999) == Levers(0.1, -0.2, 0.3)
    assert record.at(0.7) == record.at(0.9) == Levers(1.0, -1.0, 0.0)
    assert record.at(1.0) == Levers(0.0, 0.5, 0.0)


def test_a_record_rests_before_its_first_and_after_its_last_row(written):
    record = read_levers(written(HEADER + "0.5,0.1,-0.2,0.3\n1.0,0,0.5,0\n"))
    assert record.at(0.4999) == record.at(1.0001) == record.at(math.inf) == REST


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_blanks_crlf_and_a_byte_order_mark_are_welcome(written, encoding):
    text = "time_s, swing, boom, stick\r\n\r\n0.0, 0.1, 0.2, 0.3\r\n\r\n"
    assert read_levers(written(text, encoding)).at(0.0) == Levers(0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("", 1, "the header must be time_s,swing,boom,stick, found nothing"),
        ("t,a,b,c\n0,0,0,0\n", 1, "the header must be time_s,swing,boom,stick, found t,a,b,c"),
        ("\n0,0,0,0\n", 2, "the header must be time_s,swing,boom,stick, found 0,0,0,0"),
        (HEADER, 1, "no rows below the header; allowed: one or more"),
        (HEADER + "0,0,0\n", 2, "3 columns; allowed are the 4 of the header"),
        (HEADER + "0,0,0,0,0\n", 2, "5 columns; allowed are the 4 of the header"),
        (HEADER + "0,0,0,0\n1,0,up,0\n", 3, "boom is 'up'; allowed: -1 .. 1"),
        (HEADER + "0,0,0,0\n1,0,,0\n", 3, "boom is ''; allowed: -1 .. 1"),
        (HEADER + "0,1.01,0,0\n", 2, "swing is '1.01'; allowed: -1 .. 1"),
        (HEADER + "0,0,0,nan\n", 2, "stick is 'nan'; allowed: -1 .. 1"),
        (HEADER + "inf,0,0,0\n", 2, "time_s is 'inf'; allowed: 0 .. 86400"),
        (HEADER + "1e300,0,0,0\n", 2, "time_s is '1e300'; allowed: 0 .. 86400"),
        (HEADER + "-0.1,0,0,0\n", 2, "time_s is '-0.1'; allowed: 0 .. 86400"),
        (HEADER + "0,0,0,0\n1,0,0,0\n1,0,0,0\n", 4, "time_s is 1 after 1; times must rise"),
        (HEADER + "0,0,0,0\n\n\n2,0,0,0\n\n1,0,0,0\n", 7, "time_s is 1 after 2; times must rise"),
    ],
)
def test_a_refused_file_is_told_file_line_and_what_is_allowed(written, text, line, said):
    path = written(text)
    with pytest.raises(LeverError) as refused:
        read_levers(path)
    assert str(refused.value) == f"{path}:{line}: {said}"


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", None], ids=["not text", "absent"])
def test_an_unreadable_file_is_named(tmp_path, content):
    path = tmp_path / "levers.csv"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LeverError, match="cannot be read as CSV") as refused:
        read_levers(path)
    assert str(refused.value).startswith(f"{path}: ")


def test_a_persons_levers_are_read_whole():
    person = recorded("operator_levers.csv")
    record = read_levers(person)
    rows = np.loadtxt(person, delimiter=",", skiprows=1)
    assert record.times == tuple(rows[:, 0])
    assert np.array_equal(record.levers, rows[:, 1:])
    assert record.times[-1] >= 95.0
    middle = record.at(0.5 * (record.times[100] + record.times[101]))
    assert middle == pytest.approx(0.5 * (rows[100, 1:] + rows[101, 1:]))
    assert (
        max(abs(record.at(t + 0.005).swing - record.at(t).swing) for t in np.arange(0.0, 95.0, 0.005)) < 0.2
    )
