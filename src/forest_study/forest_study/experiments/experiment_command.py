"""`forest-ident experiment`: scripted experiments in a graph, as bags from which `forest-ident fit` learns.

| | who makes the bags |
|---|---|
| by default | a graph of its own, in lockstep with the simulated machine |
| `--live` | the graph that is running, in its own time: on iron, or on the simulator |
| `--direct` | no graph: the same laws in this process, much faster |
"""

from __future__ import annotations

import argparse
import math
import shutil
from pathlib import Path

from forest_bringup.graph import ros_namespace
from forest_bringup.supervisor import Stopped
from forest_description.machine import Machine, load_machine
from forest_ident.cli.fit_command import Bar
from forest_ident.driving.simulated_experiment import duration, experiment, instructions
from forest_ident.estimators import calibration
from forest_ident.experiments import experiment_plan
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_msgs_py.runtime.command_line import Subcommands, number, subcommand, whole
from forest_study.experiments import experiment_graph
from forest_study.experiments.experiment_graph import Conditions

DEFAULT = "c180_hoses"
LOGS = "log"  # beside the bags


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "run the experiments of the identification, on a simulated machine or on the graph that runs"
    parser = subcommand(verbs, "experiment", text, run)
    parser.add_argument(
        "name", metavar="NAME|all", help="name of an experiment; 'list' prints all with their set-up"
    )
    parser.add_argument(
        "--machine", metavar="NAME|FILE", help=f"default: {DEFAULT}; with --live: the valve driver's"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="directory to be made, with one bag per experiment"
    )
    parser.add_argument(
        "--seed",
        type=whole(0),
        default=0,
        metavar="N",
        help="seed of sensor noise and drawn values (default: 0)",
    )
    parser.add_argument("--exact", action="store_true", help="exact sensors instead of Table 4.2's")
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--live", action="store_true", help="run on the live graph: the crane moves")
    how.add_argument("--direct", action="store_true", help="run in this process, without a graph: fast")
    parser.add_argument(
        "--yes", action="store_true", help="with --live: start without the question whether all is prepared"
    )
    parser.add_argument(
        "--timeout",
        type=number(0.01, 1.0, "s"),
        default=0.1,
        metavar="S",
        help="with --live: the machine's state "
        "is lost, and the experiment ends, when none has come for so long (default: %(default)s)",
    )
    parser.add_argument(
        "--trial",
        type=number(2.5, 1e6, "s"),
        default=math.inf,
        metavar="S",
        help="end each experiment after this time",
    )
    parser.add_argument(
        "--namespace", type=ros_namespace, default="/", help="ROS namespace of the graph (default: /)"
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: no such experiment, or no directory for it.
        GraphError: the graph could not start, or had to end.
        KeyboardInterrupt: the user stopped it.
    """
    if options.name == "list":
        machine = load_machine(options.machine or DEFAULT)
        print("\n\n".join(instructions(name, machine) for name in experiment_plan.names(machine)))
        return 0
    made_here = options.out is not None and not options.out.exists()
    try:
        if options.live:
            from forest_study.experiments import experiment_live  # ROS takes a third of a second

            return experiment_live.run(options)
        return _simulated(options)
    except Stopped as stopped:
        raise KeyboardInterrupt from stopped
    finally:
        if made_here and not any(options.out.rglob("*.mcap")):  # the same command shall work another time
            shutil.rmtree(options.out, ignore_errors=True)


def _simulated(options: argparse.Namespace) -> int:
    """Run experiments on a simulated machine."""
    named = options.machine or DEFAULT
    machine = load_machine(named)
    names = wanted(options, machine)
    make_directory(options)
    conditions, longest = conditions_of(options, named), options.trial
    in_graph = [name for name in names if not options.direct and name != calibration.NAME]
    bar = Progress({name: duration(name, machine, longest) if name in in_graph else 0.0 for name in names})
    for name in names:
        print(instructions(name, machine, longest), flush=True)
        bar.begin(name)
        bag, logs = options.out / name, options.out / LOGS / name
        if name in in_graph:
            experiment_graph.run(name, conditions, bag, logs, bar.tell)
        else:
            session_bag.write(experiment(name, machine, options.seed, options.exact, longest), bag)
        bar.end()
        print(f"  {duration(name, machine, longest):.0f} s recorded: {bag}\n", flush=True)
    return 0


def conditions_of(options: argparse.Namespace, machine: str) -> Conditions:
    """Return how the experiments are made, with a machine's name or file."""
    return Conditions(
        machine=machine,
        seed=options.seed,
        exact=options.exact,
        longest=options.trial,
        timeout=options.timeout,
        namespace=options.namespace,
    )


def wanted(options: argparse.Namespace, machine: Machine) -> tuple[str, ...]:
    """Return the experiments that are asked for.

    Raises:
        SessionError: the machine has no such experiment.
    """
    known = experiment_plan.names(machine)
    if options.name not in ("all", *known):
        raise SessionError(
            f"no experiment {options.name!r} for {machine.name}; allowed: all, {', '.join(known)}"
        )
    return known if options.name == "all" else (options.name,)


def make_directory(options: argparse.Namespace) -> None:
    """Make the directory for the bags.

    Raises:
        SessionError: it is not named, or exists.
    """
    if options.out is None:
        raise SessionError("experiment: --out DIR is missing")
    if options.out.exists():
        raise SessionError(f"{options.out} exists already; choose another --out or remove it")
    options.out.mkdir(parents=True)


class Progress:
    """How far a row of experiments is, with the time that is left.

    Args:
        durations: of each [s]; 0 where it takes no time worth telling.
    """

    def __init__(self, durations: dict[str, float]) -> None:
        self._durations, self._bar = durations, Bar()
        self._name, self._done = "", 0.0

    def begin(self, name: str) -> None:
        """Begin the next experiment."""
        self._name = name

    def tell(self, time: float) -> None:
        """Tell the time in the experiment [s]."""
        self._bar(self._name, (self._done + time) / max(1e-9, sum(self._durations.values())))

    def end(self) -> None:
        """End the experiment."""
        self._done += self._durations[self._name]
        self._bar.end()
