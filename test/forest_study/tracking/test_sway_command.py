"""The hanging head after a stop: anti-sway leaves it at rest, and costs the work no time."""

import json

import pytest

from forest_description.machine import load_machine
from forest_study.cli import main
from forest_study.tracking.sway_command import stopped

LOADER = load_machine("loader")


@pytest.mark.parametrize("machine", [LOADER, load_machine("forwarder")])
def test_the_residual_sway_is_less_by_60_percent_and_the_head_rests_sooner(machine):
    without, with_it = (stopped(machine, machine, "inwards", 0.5, 1.5, on) for on in (False, True))
    assert without.sway_deg > 2.0
    assert with_it.sway_deg < 0.4 * without.sway_deg
    assert with_it.head_rests_s < without.head_rests_s
    assert with_it.moved_m > without.moved_m


def test_the_command_tells_and_draws(tmp_path, capsys):
    options = ["--machine", "loader", "--speed", "0.3", "--seconds", "0.5"]
    assert main(["sway", *options, "--out", str(tmp_path / "sway")]) == 0
    assert "| to the left | on |" in capsys.readouterr().out
    report = json.loads((tmp_path / "sway" / "sway.json").read_text())
    assert [run["anti_sway"] for run in report["runs"]] == [False, True] * 2
    assert (tmp_path / "sway" / "sway.png").stat().st_size > 10_000


def test_a_machine_without_a_hanging_head_is_refused(tmp_path, capsys):
    assert main(["sway", "--machine", "c180_hoses", "--out", str(tmp_path / "sway")]) == 1
    assert (
        "nothing hangs from the tip of c180_hoses; allowed: manipulator.pendulum" in capsys.readouterr().err
    )
