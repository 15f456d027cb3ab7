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


@pytest.mark.parametrize("seed", [1, 7])
def test_each_movement_costs_the_round_trip_and_no_more(seed):
    """The tenth of the time at 150 ms is a mean over the command's targets: a miss costs a movement."""
    prompt, late = (placed(C180, trip, seed) for trip in (0.0, 0.15))
    assert prompt.miss < NEAR + 0.01
    assert late.miss < NEAR + 0.01
    assert late.movements == prompt.movements
    assert 0.15 < late.time - prompt.time < 0.15 * (1 + late.movements) + 0.05


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
