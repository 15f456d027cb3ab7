"""`forest-study bode`: each joint's position loop at some poses, with margins and a picture."""

import argparse
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from forest_bringup.profile_choice import add_profile_option
from forest_control.config.controller_settings import Settings
from forest_control.config.profile_file import with_gains_of
from forest_description.derived.limits import start_tip
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Vec3
from forest_msgs_py.runtime.command_line import add_machine_option, number
from forest_sim.simulation.open_loop import require_within_rating, start_angles
from forest_study.results import StudyError, new_directory, write_json
from forest_study.stability.margins import Margins, margins
from forest_study.stability.position_loop import FREQUENCY, PositionLoop, position_loop

VOLTAGE = 4.0  # [V] as forest-sim's steps


class Result(NamedTuple):
    """One joint at one pose."""

    tip: Vec3  # [m]
    axis: int
    loop: PositionLoop
    plant: Margins  # its gain: the K_p [1/s] from which proportional control alone swings up
    controlled: Margins


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    add_machine_option(parser)
    parser.add_argument(
        "--tip",
        nargs=3,
        action="append",
        type=number(-100.0, 100.0, "m"),
        metavar=("X", "Y", "Z"),
        help="position of the tip, may be repeated (default: where the simulator starts)",
    )
    parser.add_argument(
        "--voltage",
        type=number(-24.0, 24.0, "V"),
        default=VOLTAGE,
        metavar="V",
        help="voltage of the joint's spool at the operating point (default: %(default)g)",
    )
    add_profile_option(
        parser, "profile whose gains are used, as tune writes them (default: gains by the machine's rule)"
    )


def run(options: argparse.Namespace) -> int:
    """Print the margins, and write `bode.json` and `bode.png`; return the exit code.

    Raises:
        StudyError: a pose out of reach, or a voltage that leaves a valve shut or is beyond its rating.
    """
    machine = load_machine(options.machine)
    tips = [(x, y, z) for x, y, z in options.tip or [start_tip(machine)]]
    settings = with_gains_of(Settings(), options.profile) if options.profile else Settings()
    try:
        poses = [(tip, start_angles(machine, tip)) for tip in tips]
        require_within_rating(machine, (options.voltage,) * 3)
        found = [
            _looked_at(machine, tip, angles, axis, options.voltage, settings)
            for tip, angles in poses
            for axis in range(3)
        ]
    except ValueError as error:
        raise StudyError(f"bode: {error}") from error
    new_directory(options.out)
    loops = [_as_json(one) for one in found]
    write_json(
        options.out / "bode.json", {"machine": machine.name, "voltage_v": options.voltage, "loops": loops}
    )
    print(f"  {machine.name}, each joint in the steady motion of {options.voltage:g} V\n{_table(found)}")
    print(f"  {_draw(machine, found, options.out / 'bode.png')}")
    return 0


def _looked_at(
    machine: Machine, tip: Vec3, angles: Vec3, axis: int, voltage: float, settings: Settings
) -> Result:
    loop = position_loop(machine, angles, axis, voltage, settings)
    return Result(tip, axis, loop, margins(FREQUENCY, loop.plant), margins(FREQUENCY, loop.controlled))


def _as_json(one: Result) -> dict[str, Any]:
    return {
        "tip_m": one.tip,
        "axis": AXES[one.axis],
        "rate_rad_s": one.loop.rate,
        "gains": one.loop.gains,
        "without_gains": _finite(one.plant),
        "with_gains": _finite(one.controlled),
    }


def _finite(found: Margins) -> dict[str, float | None]:
    return {name: value if math.isfinite(value) else None for name, value in found._asdict().items()}


def _table(found: list[Result]) -> str:
    margins_head = (
        "swings up from K_p = at          the gains' margins, crossover                   1/|1 + L|"
    )
    head = f"{'K_p K_i D':<14} {margins_head}"
    lines = [f"  {'tip, m':<16} {'joint':<6} {'rad/s':>6}  {head}"]
    for one in found:
        tip = ", ".join(f"{x:g}" for x in one.tip) if one.axis == 0 else ""
        bare, closed = one.plant, one.controlled
        decibels = 20.0 * math.log10(closed.gain)
        lines.append(
            f"  {tip:<16} {AXES[one.axis]:<6} {one.loop.rate:6.3f}  "
            f"{'{:g} {:.3g} {:g}'.format(*one.loop.gains):<14} "
            f"{bare.gain:6.1f} 1/s      {bare.gain_frequency:5.2f} Hz    "
            f"{decibels:5.1f} dB at {closed.gain_frequency:5.2f} Hz, "
            f"{closed.phase:4.0f} deg at {closed.crossover:4.2f} Hz  {closed.sensitivity:5.2f}"
        )
    return "\n".join(lines)


def _draw(machine: Machine, found: list[Result], out: Path) -> Path:
    from matplotlib.figure import Figure  # takes half a second, which the other verbs need not wait

    figure = Figure(figsize=(13.0, 7.0), dpi=100, layout="constrained")
    figure.suptitle(
        f"Position loops of {machine.name}: with the controller's gains, and dashed with K_p = 1 1/s"
    )
    grid = figure.subplots(2, 3, sharex=True, sharey="row")
    for place, one in enumerate(found):
        size, phase = grid[:, one.axis]
        colour = f"C{place // 3}"
        label = f"tip ({', '.join(f'{x:g}' for x in one.tip)}) m"
        for values, style, width in ((one.loop.controlled, "-", 1.5), (one.loop.plant, "--", 0.9)):
            size.semilogx(FREQUENCY, 20.0 * np.log10(np.abs(values)), style, color=colour, linewidth=width)
            turned = np.degrees(np.unwrap(np.angle(values)))
            turned -= 360.0 * np.round((turned[0] + 90.0) / 360.0)
            phase.semilogx(
                FREQUENCY, turned, style, color=colour, linewidth=width, label=label if style == "-" else None
            )
    for (size, phase), name in zip(grid.T, AXES, strict=True):
        size.set_title(name)
        size.axhline(0.0, color="k", linewidth=0.8)
        phase.axhline(-180.0, color="k", linewidth=0.8)
        phase.set(xlabel="frequency [Hz]", ylim=(-450.0, 0.0), yticks=range(-450, 1, 90))
        size.set_ylim(-80.0, 40.0)
        for axes in (size, phase):
            axes.grid(alpha=0.3)
    grid[0, 0].set_ylabel("|L| [dB]")
    grid[1, 0].set_ylabel("phase [deg]")
    grid[1, 0].legend(fontsize="small")
    figure.savefig(out)
    return out
