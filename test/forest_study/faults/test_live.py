"""What is asked of a live graph whose nodes get signals; the graph itself is `test_supervisor.py`'s."""

import math

import pytest

from forest_control.operator.joystick_sources import read_levers
from forest_study.faults.live import LiveOutcome, broken, levers, table

WELL = LiveOutcome(
    "controller", "SIGKILL", 0.19, 0.0, 1, "graph: controller was killed by SIGKILL", 0, False, 0
)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, []),
        ({"zero": 0.3, "waited": 0.15}, []),
        ({"zero": 0.3}, ["voltages for 0.30 s, of which it waited 0.00 s; allowed: 0.2 s"]),
        ({"zero": math.inf}, ["voltages for inf s, of which it waited 0.00 s; allowed: 0.2 s"]),
        ({"orphans": 2}, ["2 nodes outlived the graph"]),
        ({"traceback": True}, ["a traceback was printed"]),
        ({"node": "recorder", "zero": math.inf}, []),
        ({"node": "recorder"}, ["the crane stopped; a recorder may end"]),
    ],
)
def test_what_a_signal_breaks_is_named(change, said):
    one = WELL._replace(**change)
    assert broken(one) == [f"{one.node}, SIGKILL: {text}" for text in said]


def test_the_table_has_the_worst_repetition_after_what_the_host_took():
    rows = table([WELL, WELL._replace(zero=0.5, waited=0.49), WELL._replace(zero=0.195)]).splitlines()
    assert len(rows) == 3
    assert rows[-1].startswith("| controller | SIGKILL | zero in 0.2 s | 0.20 | 0.00 | 1 |")


def test_the_levers_never_rest(tmp_path):
    played = read_levers(levers(tmp_path))
    assert all(max(map(abs, played.at(0.05 * k))) >= 0.05 for k in range(1000))
