"""The loop's bound against the machine: a sampled position controller swings up about where it is told."""

import json
from dataclasses import replace

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.types import PERIOD
from forest_sim.analysis.frequency_response import response_of
from forest_sim.analysis.modes import operating_point, unguarded
from forest_sim.equations.plant import at_joints
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.compiled_plant import compiled_advance
from forest_study.cli import main
from forest_study.stability.margins import margins
from forest_study.stability.position_loop import FREQUENCY, position_loop

STEP = 1e-3  # [s]
TIP = (5.5, 0.0, 1.0)


def swings(machine, axis, volts, gain, seconds):
    """Drive a joint through its pose by u = a + K (r - s), a period late; return the errors [rad]."""
    p, angles = unguarded(plant_parameters(machine)), start_angles(machine, TIP)
    rate, response, *_ = response_of(angles, axis, volts, p, FREQUENCY[:1])
    begun = tuple(q - 0.5 * rate * seconds * (place == axis) for place, q in enumerate(angles))
    given = [volts if place == axis else 0.0 for place in range(3)]
    point, advance = operating_point(begun, tuple(given), p), compiled_advance()
    wanted, errors = volts, []
    reference = at_joints(point.plant, p).axes[axis].angle + 1e-4  # pushed at the start
    for _ in range(round(seconds / PERIOD)):
        given[axis] = wanted
        errors.append(reference - at_joints(point.plant, p).axes[axis].angle)
        wanted = volts + gain * errors[-1] / abs(response[0])
        point = advance(point, tuple(given), STEP, round(PERIOD / STEP), p)
        reference += rate * PERIOD
    return np.array(errors)


def linear(machine):
    """The machine without what the loop leaves out: play, slew limit and load holding of its valves.

    Their dead time is left out, too: with it the stick's push fades into the pose's own change. So is the
    play of the swing's gear: a swaying head frees its teeth, and they rattle at any gain.
    """
    return replace(
        machine,
        valve=replace(machine.valve, hysteresis=None, dead_time=None, spool_slew_limit=None),
        swing=replace(machine.swing, backlash=None),
        boom=replace(machine.boom, holding_1=None),
        stick=replace(machine.stick, holding_1=None, holding_2=None),
    )


@pytest.mark.parametrize(
    ("name", "axis", "volts"),
    [("c180", 0, 3.0), ("c180", 1, 3.0), ("c180", 2, 3.0), ("forwarder", 1, 4.0)],
)
def test_proportional_control_swings_up_beyond_the_gain_that_is_told_and_calms_below(name, axis, volts):
    machine = linear(load_machine(name))
    loop = position_loop(machine, start_angles(machine, TIP), axis, volts, Settings())
    told = margins(FREQUENCY, loop.plant)
    cycle = round(1.0 / told.gain_frequency / PERIOD)  # samples
    grown = {}
    for share in (0.75, 1.25):
        errors = swings(machine, axis, volts, share * told.gain, 9 * cycle * PERIOD)
        slow = np.convolve(errors, np.ones(cycle) / cycle, mode="same")  # the pose changes, too
        waves = (errors - slow)[cycle:-cycle]
        grown[share] = np.std(waves[-2 * cycle :]) / np.std(waves[: 2 * cycle])
    assert grown[0.75] < 1.0 < grown[1.25], grown


def test_from_the_command_line(tmp_path, capsys):
    out = tmp_path / "bode"
    assert main(["bode", "--machine", "c180_hoses", "--tip", "5.5", "0", "1", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert all(axis in printed for axis in AXES)
    told = json.loads((out / "bode.json").read_text("utf-8"))
    assert [loop["axis"] for loop in told["loops"]] == list(AXES)
    assert all(
        loop["with_gains"]["gain"] > 2.0 and loop["with_gains"]["phase"] > 30.0 for loop in told["loops"]
    )
    assert (out / "bode.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--voltage", "0"], "0 V leave the valve shut"),
        (["--voltage", "11"], "swing's spool at 11 V; allowed: up to 10 V, its rating"),
        (["--tip", "20", "0", "1"], "is out of reach"),
    ],
)
def test_what_cannot_be_is_told(arguments, reason, tmp_path, capsys):
    assert main(["bode", *arguments, "--out", str(tmp_path / "out")]) == 1
    assert reason in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
