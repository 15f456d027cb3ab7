"""Parts of everyday work: they begin at rest, carry no log, and cover what was driven."""

import dataclasses

import numpy as np
import pytest
from everyday_work import driven, everyday_work

from forest_description.machine import load_machine
from forest_ident.everyday import coverage
from forest_ident.everyday.segments import REST, cut
from forest_ident.measurements.session import SessionError
from forest_msgs_py.types import PERIOD
from forest_sim.simulation.load_schedule import parse_loads

C180 = load_machine("c180_hoses")


@pytest.fixture(scope="module")
def work():
    """A minute and a half of work with an empty head."""
    return everyday_work(C180, C180, seed=2, seconds=90.0)


def test_each_part_begins_at_rest_and_moves_later(work):
    parts = cut(C180, {"work": work}).segments
    assert len(parts) >= 5
    for part in parts:
        rows = slice(0, part.opening)
        assert part.opening == round(REST / PERIOD)
        assert np.all(np.abs(part.session.voltages[rows]) == 0.0)
        assert np.any(np.abs(part.session.voltages[part.opening]) > 0.9)
        for axis in ("swing", "boom", "stick"):
            assert np.ptp(part.session.column(f"{axis}_resolver")[rows]) < 0.003
        first = round(part.begin / PERIOD)
        there = slice(first, first + len(part.session.time))
        assert np.array_equal(part.session.column("swing_flow"), work.column("swing_flow")[there])


def test_a_voltage_within_the_overlap_is_rest(work):
    biased = dataclasses.replace(work, voltages=np.where(work.voltages == 0.0, 0.3, work.voltages))
    parts = cut(C180, {"work": biased}).segments
    assert [part.begin for part in parts] == [part.begin for part in cut(C180, {"work": work}).segments]
    for part in parts:
        assert np.all(part.session.voltages[: part.opening] == 0.0)
        assert part.head == pytest.approx(700.0, abs=30.0)


def test_a_part_that_carries_a_log_at_either_end_is_left_out(work):
    carried = driven(C180, work.voltages, 2, parse_loads("300 kg from 40 s; 0 kg from 66 s"))
    found = cut(C180, {"work": carried})
    assert 3 <= len(found.segments) < 8
    for part in found.segments:
        assert part.head == pytest.approx(700.0, abs=30.0)
        until = part.begin + part.session.time[-1]
        assert until < 40.0 or part.begin > 66.0
    assert "parts: a log was carried" in found.left_out[-1]


def test_work_that_never_rests_is_refused_by_a_sentence(work):
    restless = dataclasses.replace(work, voltages=np.where(work.voltages == 0.0, 1.5, work.voltages))
    with pytest.raises(
        SessionError, match=r"day: no motion begins at rest; allowed: work with pauses of 0.4 s"
    ):
        cut(C180, {"day": restless})


def test_a_crane_that_still_rocks_is_no_start(work):
    rocking = np.sin(np.arange(len(work.time)) * PERIOD * 2.0 * np.pi) * 2e6
    readings = dict(work.readings)
    readings["swing_pressure_1_actuator"] = readings["swing_pressure_1_actuator"] + rocking
    with pytest.raises(SessionError, match="no motion begins at rest"):
        cut(C180, {"day": dataclasses.replace(work, readings=readings)})


def _gain(part):
    return np.sum(np.log1p(coverage.seconds_by_kind(C180, part.session)))


def test_a_budget_takes_what_is_unlike_the_rest_and_holds_some_out(work):
    parts = cut(C180, {"work": work}).segments
    total = sum(part.session.time[-1] for part in parts)
    richest = max(parts, key=lambda part: _gain(part) / part.session.time[-1])
    chosen = coverage.chosen(C180, [*[richest] * 20, *parts], budget=total)
    taken = [*chosen.fitted, *chosen.held_out]
    assert 1 <= sum(part.begin == richest.begin for part in taken) <= 7  # of 21
    assert len({part.begin for part in taken}) >= len(parts) - 1
    assert chosen.unused > 12.0 * richest.session.time[-1]
    assert len(chosen.held_out) == len(taken) // coverage.EVERY
    everything = coverage.chosen(C180, parts)
    assert everything.left_out() == []
    assert {part.begin for part in (*everything.fitted, *everything.held_out)} == {p.begin for p in parts}
