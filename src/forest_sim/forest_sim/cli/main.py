"""`forest-sim`: the simulator without a graph, from the command line.

Every error is one sentence on standard error. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130
stopped.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from forest_description.config.parameter import MachineError
from forest_description.config.source_tree import shipped_machines
from forest_description.derived.temperature import at_temperature
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Vec3
from forest_msgs_py.runtime import command_line
from forest_msgs_py.runtime.command_line import Command, Subcommands, number, subcommand, whole
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.load_schedule import Loads, parse_loads
from forest_sim.simulation.open_loop import Run, RunError, require_within_limits, start_angles
from forest_sim.simulation.voltage_profiles import InputError, Voltages

PROGRAM = "forest-sim"
ZERO_CELSIUS = 273.15  # [K]
LONGEST = 7.0 * 86400.0  # [s]
EPILOGUE = (
    f"Machines: the name of a shipped one ({', '.join(shipped_machines())}) or a YAML file. "
    "Lengths in m, angles in deg."
)
START = "5.5 0 1, or the middle of its range for a crane that does not reach there"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one subcommand; return its exit code."""
    options = _parser().parse_args(arguments)
    return command_line.run(PROGRAM, options, (InputError, MachineError, RunError))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=PROGRAM, description="Simulate and examine a crane without a running graph.", epilog=EPILOGUE
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    _add_simulate(commands)
    pumps = _command(commands, "pumps", _pumps, "the same motion on the four sorts of pump: power and energy")
    _add_run(pumps)
    compared = _command(commands, "compare", _compare, "the same input on several machines: one axis, drawn")
    compared.add_argument("machines", nargs="+", metavar="NAME|FILE", help="two or more machines")
    compared.add_argument("--axis", choices=AXES, default="boom", help="that is drawn; default: boom")
    _add_run(compared)
    _add_loads(compared)
    rest = _command(commands, "equilibrium", _equilibrium, "pressures, forces and torques at rest at a pose")
    _add_pose(rest)
    rest.add_argument("--json", action="store_true", help="print JSON in SI units")
    _add_modes(commands)
    _add_export(commands)
    check = _command(commands, "check", _check, "load a machine file and tell what it amounts to")
    check.add_argument("machine", metavar="FILE", help="machine file or name")
    return parser


def _command(
    commands: Subcommands,
    name: str,
    function: Command,
    text: str,
) -> argparse.ArgumentParser:
    parser = subcommand(commands, name, text, function, EPILOGUE)
    parser.set_defaults(parser=parser)
    if name not in ("check", "compare"):
        parser.add_argument("--machine", default="c180", metavar="NAME|FILE", help="default: %(default)s")
    celsius = number(-60.0, 200.0, "degC")
    parser.add_argument(
        "--temperature", type=celsius, metavar="C", help="of all oil [degC]; default: the file's"
    )
    return parser


def _add_simulate(commands: Subcommands) -> None:
    simulate = _command(commands, "simulate", _simulate, "run a machine over an input: MCAP, CSV, pictures")
    _add_run(simulate)
    simulate.add_argument(
        "--sensor-noise", action="store_true", help="errors, noise, lag and rate of sensors"
    )
    simulate.add_argument(
        "--seed", type=whole(0), default=0, help="of the sensors' errors and noise; default: 0"
    )
    simulate.add_argument(
        "--stuck-spools", default="", metavar="AXES", help="axes whose spools do not move, e.g. 'boom, stick'"
    )
    simulate.add_argument(
        "--tip-force",
        nargs=3,
        type=number(-1e6, 1e6, "N"),
        default=(0.0, 0.0, 0.0),
        metavar=("X", "Y", "Z"),
        help="on the tip all the time, in the base frame [N]",
    )
    _add_loads(simulate)
    simulate.add_argument(
        "--sensor-faults",
        default="",
        metavar="TEXT",
        help="such as 'boom_resolver: frozen from 2 s; swing_flow: absent'",
    )


def _add_modes(commands: Subcommands) -> None:
    modes = _command(
        commands, "modes", _modes, "natural frequencies and damping at a pose or over the workspace"
    )
    _add_pose(modes)
    modes.add_argument(
        "--voltages",
        nargs=3,
        type=number(-voltage_profiles.GREATEST, voltage_profiles.GREATEST, "V"),
        default=(0.0, 0.0, 0.0),
        metavar=("SWING", "BOOM", "STICK"),
        help="spool positions [V], the crane moving steadily through the pose; default: shut",
    )
    modes.add_argument("--json", action="store_true", help="print JSON in SI units")
    modes.add_argument("--map", action="store_true", help="over the workspace, valves shut; needs --out")
    modes.add_argument("--spacing", type=number(0.02, 2.0, "m"), default=0.1, help="of the map; default: 0.1")
    modes.add_argument("--out", type=Path, metavar="DIR", help="directory to be made for the map")


def _add_export(commands: Subcommands) -> None:
    exported = commands.add_parser(
        "export",
        help="a machine as an FMU, for Simulink, Amesim, OpenModelica and others",
        description="Write a machine as an FMU for co-simulation (FMI 2.0).",
        epilog=EPILOGUE,
    )
    exported.set_defaults(command=_export, parser=exported)
    exported.add_argument("--fmu", required=True, metavar="NAME|FILE", dest="machine", help="the machine")
    exported.add_argument(
        "--out", type=Path, metavar="FILE.fmu", help="to be made; default: the machine's name"
    )


def _add_run(parser: argparse.ArgumentParser) -> None:
    volts, hertz = number(0.0, voltage_profiles.GREATEST, "V"), command_line.number(1e-3, 1000.0, "Hz")
    parser.add_argument(
        "--voltages",
        default="step",
        metavar="step|chirp|thesis|FILE.csv",
        help="what drives the valves (default: %(default)s); a CSV has the columns time,swing,boom,stick "
        "in s and V, and each row holds until the next",
    )
    parser.add_argument(
        "--duration",
        type=number(0.01, LONGEST, "s"),
        metavar="S",
        help="default: as long as the input, 60 for chirp",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="directory to be made")
    parser.add_argument(
        "--start-tip",
        nargs=3,
        type=number(-100.0, 100.0, "m"),
        metavar=("X", "Y", "Z"),
        help=f"where the tip starts, at rest; default: {START}",
    )
    parser.add_argument(
        "--rate",
        type=number(0.1, 10_000.0, "Hz"),
        default=200.0,
        help="of the rows [Hz]; default: 200",
    )
    parser.add_argument(
        "--step",
        type=number(1e-6, 0.1, "s"),
        default=1e-3,
        help="of the integrator [s]; default: 0.001",
    )
    parser.add_argument("--amplitude", type=volts, help="of step (4), chirp (4) and thesis (5) [V]")
    parser.add_argument("--chirp-from", type=hertz, default=0.1, metavar="HZ", help="default: 0.1")
    parser.add_argument("--chirp-to", type=hertz, default=5.0, metavar="HZ", help="default: 5")


def _add_loads(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--loads",
        default="",
        metavar="TEXT",
        help="logs in the head, such as '500 kg from 2 s; 800 kg, 5 m from 4 s; 0 kg from 6 s'",
    )


def _add_pose(parser: argparse.ArgumentParser) -> None:
    pose = parser.add_mutually_exclusive_group()
    pose.add_argument(
        "--tip",
        nargs=3,
        type=number(-100.0, 100.0, "m"),
        metavar=("X", "Y", "Z"),
        help=f"where the tip is; default: {START}",
    )
    pose.add_argument(
        "--angles",
        nargs=3,
        type=number(-720.0, 720.0, "deg"),
        metavar=("SWING", "BOOM", "STICK"),
        help="the joints' angles [deg]",
    )


def _simulate(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import simulate
    from forest_sim.sensors.sensor_faults import parse_faults
    from forest_sim.simulation.disturbance import Disturbance, parse_stuck_spools
    from forest_sim.simulation.sensor_log import Sensing

    machine, voltages, angles, run = _run(options)
    try:
        faults = parse_faults(options.sensor_faults)
    except ValueError as error:
        options.parser.error(f"argument --sensor-faults: {error}")
    try:
        stuck = parse_stuck_spools(options.stuck_spools)
    except ValueError as error:
        options.parser.error(f"argument --stuck-spools: {error}")
    disturbance = Disturbance(stuck, (options.tip_force[0], options.tip_force[1], options.tip_force[2]))
    sensing = Sensing(options.sensor_noise, options.seed, faults)
    return simulate(machine, voltages, angles, run, options.out, sensing, disturbance, _loads(options))


def _pumps(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import compare_pumps

    return compare_pumps(*_run(options), options.out)


def _compare(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import compare_machines

    if len(options.machines) < 2:
        options.parser.error("argument NAME|FILE: one machine compares with nothing; allowed: two or more")
    machines = [_machine(options, name) for name in options.machines]
    given = _run(options, machines[0])
    return compare_machines(machines, AXES.index(options.axis), *given[1:], options.out, _loads(options))


def _equilibrium(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import show_equilibrium

    machine = _machine(options)
    return show_equilibrium(machine, _pose(options, machine), options.json)


def _modes(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import map_modes, show_modes

    if options.map and (options.out is None or options.json or any(options.voltages)):
        options.parser.error("--map needs --out DIR, and goes with neither --json nor --voltages")
    if options.out is not None and not options.map:
        options.parser.error("--out goes with --map only")
    machine = _machine(options)
    if options.map:
        return map_modes(machine, options.spacing, options.out)
    return show_modes(machine, _pose(options, machine), tuple(options.voltages), options.json)


def _export(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import export_fmu

    return export_fmu(options.machine, options.out)


def _check(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import show_check

    return show_check(_machine(options))


def _machine(options: argparse.Namespace, name: str = "") -> Machine:
    """Return a machine, by default `--machine`, its oil at the temperature asked for."""
    machine = load_machine(name or options.machine)
    if options.temperature is None:
        return machine
    if machine.oil is None:
        raise MachineError(f"{machine.name} has no oil section, so --temperature means nothing to it")
    return at_temperature(machine, options.temperature + ZERO_CELSIUS)


def _run(options: argparse.Namespace, machine: Machine | None = None) -> tuple[Machine, Voltages, Vec3, Run]:
    machine = machine or _machine(options)
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


def _loads(options: argparse.Namespace) -> Loads:
    """Return the schedule of the logs; a bad one ends the program with a sentence."""
    loads: Loads = ()
    try:
        loads = parse_loads(options.loads)
    except ValueError as error:
        options.parser.error(f"argument --loads: {error}")
    return loads


def _tip(given: Sequence[float] | None) -> Vec3 | None:
    return None if given is None else (given[0], given[1], given[2])


def _pose(options: argparse.Namespace, machine: Machine) -> Vec3:
    if options.angles is not None:
        a, b, c = (math.radians(angle) for angle in options.angles)
        return require_within_limits(machine, (a, b, c))
    return start_angles(machine, _tip(options.tip))


if __name__ == "__main__":
    sys.exit(main())
