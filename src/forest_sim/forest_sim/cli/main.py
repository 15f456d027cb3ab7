"""`forest-sim`: the simulator without a graph, from the command line.

Every error is one sentence on standard error. Exit codes: 0 well, 1 failed, 2 wrong arguments, 130
stopped.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from forest_description.config.parameter import MachineError
from forest_description.config.source_tree import shipped_machines
from forest_description.hydraulics.oil import COLDEST, HOTTEST
from forest_description.types import AXES
from forest_msgs_py.runtime import command_line
from forest_msgs_py.runtime.command_line import (
    Command,
    Subcommands,
    add_machine_option,
    number,
    subcommand,
    whole,
)
from forest_sim.cli.options import (
    ZERO_CELSIUS,
    add_loads_option,
    add_pose_options,
    add_run_options,
    loads_of,
    machine_of,
    pose_of,
    run_of,
)
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.open_loop import RunError
from forest_sim.simulation.voltage_profiles import InputError

PROGRAM = "forest-sim"
EPILOGUE = (
    f"Machines: the name of a shipped one ({', '.join(shipped_machines())}) or a YAML file. "
    "Lengths in m, angles in deg."
)


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
    pumps = _command(commands, "pumps", _pumps, "power and energy of one motion on the four types of pump")
    add_run_options(pumps)
    compared = _command(
        commands, "compare", _compare, "draw one axis of several machines under the same input"
    )
    compared.add_argument("machines", nargs="+", metavar="NAME|FILE", help="two or more machines")
    compared.add_argument("--axis", choices=AXES, default="boom", help="axis to be drawn (default: boom)")
    add_run_options(compared)
    add_loads_option(compared)
    rest = _command(commands, "equilibrium", _equilibrium, "pressures, forces and torques at rest at a pose")
    add_pose_options(rest)
    rest.add_argument("--json", action="store_true", help="print JSON in SI units")
    _add_modes(commands)
    _add_export(commands)
    check = _command(commands, "check", _check, "load a machine file and print its derived numbers")
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
        add_machine_option(parser)
    celsius = number(COLDEST - ZERO_CELSIUS, HOTTEST - ZERO_CELSIUS, "degC")
    parser.add_argument(
        "--temperature", type=celsius, metavar="C", help="of all oil [degC]; default: the file's"
    )
    return parser


def _add_simulate(commands: Subcommands) -> None:
    simulate = _command(commands, "simulate", _simulate, "run a machine over an input: MCAP, CSV, pictures")
    add_run_options(simulate)
    simulate.add_argument(
        "--sensor-noise", action="store_true", help="simulate errors, noise, lag and rate of the sensors"
    )
    simulate.add_argument(
        "--seed", type=whole(0), default=0, help="seed of the sensors' errors and noise (default: 0)"
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
        help="constant force on the tip, in the base frame [N]",
    )
    add_loads_option(simulate)
    simulate.add_argument(
        "--sensor-faults",
        default="",
        metavar="TEXT",
        help="faults of sensors, such as 'boom_resolver: frozen from 2 s; swing_flow: absent'",
    )


def _add_modes(commands: Subcommands) -> None:
    modes = _command(
        commands, "modes", _modes, "natural frequencies and damping at a pose or over the workspace"
    )
    add_pose_options(modes)
    modes.add_argument(
        "--voltages",
        nargs=3,
        type=number(-voltage_profiles.GREATEST, voltage_profiles.GREATEST, "V"),
        default=(0.0, 0.0, 0.0),
        metavar=("SWING", "BOOM", "STICK"),
        help="spool positions [V], the crane moving steadily through the pose; default: shut",
    )
    modes.add_argument("--json", action="store_true", help="print JSON in SI units")
    modes.add_argument(
        "--map", action="store_true", help="draw a map of the workspace, valves shut; needs --out"
    )
    modes.add_argument(
        "--spacing", type=number(0.02, 2.0, "m"), default=0.1, help="spacing of the map [m] (default: 0.1)"
    )
    modes.add_argument("--out", type=Path, metavar="DIR", help="directory to be made for the map")


def _add_export(commands: Subcommands) -> None:
    exported = commands.add_parser(
        "export",
        help="a machine as an FMU, for Simulink, Amesim, OpenModelica and others",
        description="Write a machine as an FMU for co-simulation (FMI 2.0).",
        epilog=EPILOGUE,
    )
    exported.set_defaults(command=_export, parser=exported)
    exported.add_argument(
        "--fmu", required=True, metavar="NAME|FILE", dest="machine", help="machine to be exported"
    )
    exported.add_argument(
        "--out", type=Path, metavar="FILE.fmu", help="FMU to be made (default: the machine's name)"
    )


def _simulate(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import simulate
    from forest_sim.sensors.sensor_faults import parse_faults
    from forest_sim.simulation.disturbance import Disturbance, parse_stuck_spools
    from forest_sim.simulation.sensor_log import Sensing

    machine, voltages, angles, run = run_of(options)
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
    return simulate(machine, voltages, angles, run, options.out, sensing, disturbance, loads_of(options))


def _pumps(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import compare_pumps

    return compare_pumps(*run_of(options), options.out)


def _compare(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import compare_machines

    if len(options.machines) < 2:
        options.parser.error("argument NAME|FILE: one machine compares with nothing; allowed: two or more")
    machines = [machine_of(options, name) for name in options.machines]
    given = run_of(options, machines[0])
    return compare_machines(machines, AXES.index(options.axis), *given[1:], options.out, loads_of(options))


def _equilibrium(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import show_equilibrium

    machine = machine_of(options)
    return show_equilibrium(machine, pose_of(options, machine), options.json)


def _modes(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import map_modes, show_modes

    if options.map and (options.out is None or options.json or any(options.voltages)):
        options.parser.error("--map needs --out DIR, and goes with neither --json nor --voltages")
    if options.out is not None and not options.map:
        options.parser.error("--out goes with --map only")
    machine = machine_of(options)
    if options.map:
        return map_modes(machine, options.spacing, options.out)
    return show_modes(machine, pose_of(options, machine), tuple(options.voltages), options.json)


def _export(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import export_fmu

    return export_fmu(options.machine, options.out)


def _check(options: argparse.Namespace) -> int:
    from forest_sim.cli.commands import show_check

    return show_check(machine_of(options))


if __name__ == "__main__":
    sys.exit(main())
