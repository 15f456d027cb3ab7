"""Our controller beside simple policies on the same seeds, by one command."""

import json

import pytest

from forest_study import cli
from forest_study.learning import policies
from forest_study.learning.baseline_command import judged
from forest_study.learning.crane_env import CraneEnv


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("baseline") / "out"
    given = ["--machine", "c180_hoses", "--task", "path", "--seed", "3", "--seeds", "1", "--out", str(out)]
    assert cli.main(["baseline", *given]) == 0
    return json.loads((out / "baseline.json").read_text("utf-8"))


def test_our_controller_follows_the_path_better_than_simple_policies_and_those_better_than_chance(report):
    reached = {(row["actions"], row["policy"]): row["episodes"][0] for row in report["rows"]}
    ours, rates = reached["tip", "ours"], reached["voltages", "resolved rates"]
    assert ours["rms_mm"] < 10.0
    assert ours["rms_mm"] < reached["joint", "resolved rates"]["rms_mm"] < rates["rms_mm"]
    assert all(rates["total"] > one["total"] for (_, name), one in reached.items() if name == "random")
    assert {one["seed"] for one in reached.values()} == {3}
    assert not ours["stopped"]


def test_a_policy_is_judged_as_the_command_judges_ours(report):
    env = CraneEnv("path", "tip", "c180_hoses")
    told = report["rows"][0]["episodes"][0]
    again = judged(env, policies.ours, 3)._asdict()
    assert {**again, "seconds": 0.0} == {**told, "seconds": 0.0}


def test_our_controller_reaches_targets_and_rest_does_not():
    env = CraneEnv("reach", "tip", "c180_hoses")
    assert judged(env, policies.ours, 1).reached >= 4
    assert judged(env, policies.rest, 1).reached == 0
