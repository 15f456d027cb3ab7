"""Options that several subcommands of `forest-sim` share, each beside what it stands for."""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

from forest_description.config.parameter import MachineError
from forest_description.derived.temperature import at_temperature
from forest_description.machine import Machine, load_machine
from forest_description.types import Vec3
from forest_msgs_py.runtime.command_line import number
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.load_schedule import Loads, parse_loads
from forest_sim.simulation.open_loop import Run, require_within_limits, start_angles
from forest_sim.simulation.voltage_profiles import InputError, Voltages

ZERO_CELSIUS = 273.15  # [K]
LONGEST = 7.0 * 86400.0  # [s]
START = "5.5 0 1, or the middle of its range for a crane that does not reach there"


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what a run over an input needs."""
    volts, hertz = number(0.0, voltage_profiles.GREATEST, "V"), number(1e-3, 1000.0, "Hz")
    parser.add_argument(
        "--voltages",
        default="step",
        metavar="step|chirp|thesis|FILE.csv",
        help="voltages of the valves (default: %(default)s); a CSV has the columns time,swing,boom,stick "
        "in s and V, and each row holds until the next",
    )
    parser.add_argument(
        "--duration",
        type=number(0.01, LONGEST, "s"),
        metavar="S",
        help="length of the run (default: as long as the input; chirp 60)",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="directory to be made")
    parser.add_argument(
        "--start-tip",
        nargs=3,
        type=number(-100.0, 100.0, "m"),
        metavar=("X", "Y", "Z"),
        help=f"position of the tip at the start, at rest (default: {START})",
    )
    parser.add_argument(
        "--rate",
        type=number(0.1, 10_000.0, "Hz"),
        default=200.0,
        help="rate of the rows [Hz] (default: 200)",
    )
    parser.add_argument(
        "--step",
        type=number(1e-6, 0.1, "s"),
        default=1e-3,
        help="step of the integrator [s] (default: 0.001)",
    )
    parser.add_argument(
        "--amplitude", type=volts, help="amplitude [V] (default: 4 of step and chirp, 5 of thesis)"
    )
    parser.add_argument(
        "--chirp-from",
        type=hertz,
        default=0.1,
        metavar="HZ",
        help="first frequency of the chirp (default: 0.1)",
    )
    parser.add_argument(
        "--chirp-to", type=hertz, default=5.0, metavar="HZ", help="last frequency of the chirp (default: 5)"
    )


def run_of(
    options: argparse.Namespace, machine: Machine | None = None
) -> tuple[Machine, Voltages, Vec3, Run]:
    """Return machine, input, joint angles at the start [rad], and how long and in which steps it runs.

    Args:
        options: of `add_run_options`.
        machine: in place of the options'.

    Raises:
        InputError: a file of voltages that cannot be read, or that has no duration.
        MachineError: as `machine_of`.
        RunError: the crane cannot start there.
    """
    machine = machine or machine_of(options)
    voltages = _voltages(options)
    duration = options.duration or voltages.duration
    if duration <= 0.0:
        raise InputError(f"{options.voltages}: its only row is at time 0; allowed: also a --duration")
    angles = start_angles(machine, _tip(options.start_tip))
    return machine, voltages, angles, Run(duration, options.rate, options.step)


def _voltages(options: argparse.Namespace) -> Voltages:
    name, amplitude = options.voltages, options.amplitude
    if name == "step":
        return voltage_profiles.steps(4.0 if amplitude is None else amplitude)
    if name == "chirp":
        length = options.duration or 60.0
        return voltage_profiles.chirp(
            4.0 if amplitude is None else amplitude, options.chirp_from, options.chirp_to, length
        )
    if name == "thesis":
        return voltage_profiles.thesis(5.0 if amplitude is None else amplitude)
    path = Path(name)
    if not path.is_file():
        options.parser.error(
            f"argument --voltages: no file {name!r}; "
            f"allowed: {', '.join(voltage_profiles.NAMES)} or a CSV file"
        )
    return voltage_profiles.read_voltages(path)


def add_loads_option(parser: argparse.ArgumentParser) -> None:
    """Add the logs that the head grasps and lets go."""
    parser.add_argument(
        "--loads",
        default="",
        metavar="TEXT",
        help="logs in the head, such as '500 kg from 2 s; 800 kg, 5 m from 4 s; 0 kg from 6 s'",
    )


def loads_of(options: argparse.Namespace) -> Loads:
    """Return the schedule of the logs; a bad one ends the program with a sentence."""
    loads: Loads = ()
    try:
        loads = parse_loads(options.loads)
    except ValueError as error:
        options.parser.error(f"argument --loads: {error}")
    return loads


def add_pose_options(parser: argparse.ArgumentParser) -> None:
    """Add where the crane is: by its tip or by its joints."""
    pose = parser.add_mutually_exclusive_group()
    pose.add_argument(
        "--tip",
        nargs=3,
        type=number(-100.0, 100.0, "m"),
        metavar=("X", "Y", "Z"),
        help=f"position of the tip (default: {START})",
    )
    pose.add_argument(
        "--angles",
        nargs=3,
        type=number(-720.0, 720.0, "deg"),
        metavar=("SWING", "BOOM", "STICK"),
        help="angles of the joints [deg]",
    )


def pose_of(options: argparse.Namespace, machine: Machine) -> Vec3:
    """Return the joint angles [rad] of a pose.

    Raises:
        RunError: it is out of reach, or beyond a joint's limit.
    """
    if options.angles is not None:
        a, b, c = (math.radians(angle) for angle in options.angles)
        return require_within_limits(machine, (a, b, c))
    return start_angles(machine, _tip(options.tip))


def _tip(given: Sequence[float] | None) -> Vec3 | None:
    return None if given is None else (given[0], given[1], given[2])


def machine_of(options: argparse.Namespace, name: str = "") -> Machine:
    """Return a machine, by default `--machine`, its oil at the temperature asked for.

    Raises:
        MachineError: no such machine, or one without oil that has a temperature.
    """
    machine = load_machine(name or options.machine)
    if options.temperature is None:
        return machine
    if machine.oil is None:
        raise MachineError(f"{machine.name} has no oil section, so --temperature means nothing to it")
    return at_temperature(machine, options.temperature + ZERO_CELSIUS)
