"""Faults of processes in a live graph: a few of the table's cells; the whole is `scripts/faults.sh`."""

import json
import math
import os
import random
import tempfile
from pathlib import Path

import pytest
from live_crane import Ears, LiveCrane, Outcome
from live_faults import broken, cells, page
from processes import ForkedNode

WHOLE = int(os.environ.get("LIVE_FAULTS", "0"))  # repetitions of every cell; 0: the short form
SHORT = ("controller: SIGSTOP", "simulator: restarted")
CELLS = cells()
WELL = Outcome(0.1, 0.0, 0.05, ("x: y",), False, True, 0, 0, (), False)


@pytest.fixture(scope="session")
def warm():
    """The first process waits until the server has imported everything: it is none of a crane's."""
    with tempfile.TemporaryDirectory() as folder:
        assert ForkedNode("forest_bringup.graph", ["--help"], Path(folder) / "log").ended() == 0


@pytest.fixture
def crane(warm, start_process, make_node, tmp_path):
    ears = Ears(make_node("ears", start_parameter_services=False, enable_rosout=False))
    return LiveCrane(start_process, ears, tmp_path)


@pytest.mark.parametrize("repetition", range(max(1, WHOLE)))
@pytest.mark.parametrize("name", CELLS if WHOLE else SHORT)
def test_a_live_fault_keeps_its_bound(crane, name, repetition):
    chance = random.Random(f"{name} {repetition}").random()
    outcome = crane.end(CELLS[name].do(crane, chance))
    if out := os.environ.get("LIVE_FAULTS_OUT"):
        with Path(out).open("a") as rows:
            print(json.dumps([name, outcome]), file=rows)
    assert broken(CELLS[name], outcome) == [], outcome


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, []),
        ({"zero": 0.3, "waited": 0.2}, []),
        ({"zero": 0.3}, ["open for 0.30 s, of which 0.00 s waited; allowed: 0.11 s"]),
        ({"zero": math.inf}, ["open for inf s, of which 0.00 s waited; allowed: 0.11 s"]),
        ({"way": 0.7}, ["the tip went 0.70 m; allowed: 0.6 m"]),
        ({"restarted": True}, ["it moved again without a deliberate act"]),
        ({"again": False}, ["it did not move after the deliberate act"]),
        ({"code": 1}, ["exit code 1; wanted: 0"]),
        ({"orphans": ("simulator",)}, ["simulator outlived the graph"]),
        ({"traceback": True}, ["a traceback was printed"]),
    ],
)
def test_what_breaks_a_bound_is_named(change, said):
    assert broken(CELLS["controller: SIGSTOP"], WELL._replace(**change)) == said


def test_who_may_end_must_not_stop_the_crane_and_who_must_tell_does():
    assert broken(CELLS["recorder: SIGSTOP"], WELL) == ["the crane stopped after 0.10 s"]
    ended = WELL._replace(code=1, again=False)
    assert broken(CELLS["controller: SIGKILL"], ended) == ["nobody is told 'controller', but ('x: y',)"]


def test_the_page_has_the_worst_repetition_after_what_the_host_took():
    later, taken = WELL._replace(zero=0.105), WELL._replace(zero=0.5, waited=0.49)
    rows = [json.dumps(["controller: SIGSTOP", one]) for one in (WELL, later, taken)]
    assert "the worst of 3 repetitions" in page(rows)
    assert "| zero in 0.11 s | 0.10 | 0.00 | 0.05 | 0 |" in page(rows)


def test_the_page_has_a_fault_that_broke_its_bound_in_bold():
    rows = [json.dumps(["controller: SIGSTOP", one]) for one in (WELL, WELL._replace(zero=0.2))]
    assert "\n| **controller: SIGSTOP** |" in page(rows)
    assert "\n| controller: SIGSTOP |" in page(rows[:1])
