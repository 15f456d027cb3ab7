"""A simulated operator who moves and waits: what a round trip costs in reaching and placing."""

import json

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_study.cli import main
from forest_study.latency import placing
from forest_study.latency.placing import NEAR, REACTION, Person, placed

C180 = load_machine("c180_hoses")


@pytest.mark.parametrize("trip", [0.0, 0.3])
def test_the_person_waits_until_what_it_did_is_seen_and_then_reacts(trip):
    person, tip, moves = Person(np.array([0.4, 0.0, 0.0]), trip, 1), np.zeros(3), []
    for k in range(600):
        person.watch(tip)
        levers = person.act(k * PERIOD).levers
        moves.append(any(levers))
    begins = [k for k in range(1, 600) if moves[k] and not moves[k - 1]]
    ends = [k for k in range(1, 600) if moves[k - 1] and not moves[k]]
    assert begins[0] * PERIOD == pytest.approx(REACTION, abs=0.02)
    waits = [(begin - end) * PERIOD for end, begin in zip(ends, begins[1:], strict=False)]
    assert waits == pytest.approx([trip + REACTION] * len(waits), abs=0.02)  # the tip never moves


def test_at_150_ms_reaching_and_placing_lose_at_most_a_tenth_of_the_time():
    """Of the targets of `forest-study placing`, the first two; the command has twenty."""
    prompt, late = ([placed(C180, trip, seed) for seed in (0, 1)] for trip in (0.0, 0.15))
    assert all(one.miss < NEAR + 0.01 for one in (*prompt, *late))
    assert sum(one.time for one in late) < 1.1 * sum(one.time for one in prompt)


def test_the_command_tells_each_round_trip(tmp_path, capsys, monkeypatch):
    found = {0.0: 4.0, 0.4: 5.0}
    monkeypatch.setattr(placing, "TRIPS", tuple(found))
    monkeypatch.setattr(
        placing, "placed", lambda _, trip, seed: placing.Placed(found[trip], 2, 0.01 * seed, 0.0)
    )
    assert main(["placing", "--targets", "3", "--out", str(tmp_path / "out")]) == 0
    assert "| 400 | 5.00 | 25 % | 2.0 | 20 |" in capsys.readouterr().out
    rows = json.loads((tmp_path / "out" / "placing.json").read_text())["round_trips"]
    assert rows[1]["lost"] == pytest.approx(0.25)
