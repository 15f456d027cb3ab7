"""Experiments on the graph that is running, on iron or on a simulator that keeps the time of day.

Two processes join the graph for each experiment: the scripted operator, which has the driver's compensation
off and the controller's hands off meanwhile, and a recorder. Either way back is kept twice: the operator puts
back what it changed when it ends, and so does this process, in case the operator was killed.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from forest_bag.read.timeseries import read_bag
from forest_bringup import graph as nodes
from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import NodeSpec, Supervisor
from forest_bringup.terminal import ask
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import duration, instructions
from forest_ident.driving.valve_takeover import DRIVER, WANTED, ValveTakeover
from forest_ident.estimators import calibration
from forest_ident.experiments import experiment_metadata
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_msgs_py.interfaces import topics
from forest_msgs_py.introspection.live_graph import LiveGraph, NoAnswer
from forest_study.experiments.experiment_command import LOGS, Progress, conditions_of, make_directory, wanted
from forest_study.experiments.experiment_graph import OPERATOR, Conditions, listener, operator
from forest_study.experiments.thermocouple_calibration import Baths, Recorded

RECORDER = "experiment_recorder"
VOLUME, LITRE = "case_drain_volume", 1e-3  # [m3]
LISTENERS = 2  # driver and recorder hear the commands
RESET = "ros2 service call /reset_emergency_stop std_srvs/srv/Trigger"


def run(options: argparse.Namespace) -> int:
    """Run experiments on the graph that is running; return the exit code.

    Raises:
        SessionError: no such experiment, no directory for it, or nobody said that it is prepared.
        GraphError: there is no such graph, it refuses, or the experiment had to be stopped.
        Stopped: the user asked to stop.
    """
    if options.exact:
        raise SessionError("--exact is of simulated sensors; allowed with --live: without it")
    if options.yes and options.name == "all":
        raise SessionError("all: each experiment wants another set-up; allowed with --live --yes: one NAME")
    graph = LiveGraph(options.namespace)
    try:
        return _run(options, graph)
    except NoAnswer as error:
        raise GraphError(str(error)) from error
    finally:
        graph.close()


def _run(options: argparse.Namespace, graph: LiveGraph) -> int:
    drivers = _machine_of_driver(graph)
    named = options.machine or drivers
    machine = load_machine(named)
    names, conditions = wanted(options, machine), conditions_of(options, named)
    _refuse_emergency_stop(graph)
    make_directory(options)
    for name in names:
        print(instructions(name, machine, conditions.longest), flush=True)
        _ask_whether_prepared(options.yes)
        bag, logs = options.out / name, options.out / LOGS / name
        bar = Progress({name: duration(name, machine, conditions.longest)})
        bar.begin(name)
        if name == calibration.NAME:
            _demand(graph, topics.PRESSURES)
            known = _calibration(options.namespace, bag, logs, bar.tell, options.yes)
        else:
            known = _experiment(graph, name, conditions, bag, logs, bar.tell)
            _warn_of_pauses(bag, machine.command_timeout)
        bar.end()
        session_bag.write_metadata(bag, name, known)  # before the last question: nobody need answer it
        if name.startswith("motor") and not options.yes:
            session_bag.write_metadata(bag, name, known | _vessel(bag))
        print(f"  recorded: {bag}\n", flush=True)
    return 0


def _machine_of_driver(graph: LiveGraph) -> str:
    """Return the machine that the valve driver was told.

    Raises:
        NoAnswer: there is no driver, or it commands nothing.
    """
    if not graph.wait_for(DRIVER):
        raise NoAnswer(
            f"no graph is running in {graph.place}: there is no node {DRIVER}; start one with "
            "scripts/graph.sh, or leave --live away"
        )
    known = graph.get(DRIVER, ("machine", "shadow"))
    if known["shadow"]:
        raise NoAnswer(f"{DRIVER} publishes no voltage; start the graph without --shadow")
    return str(known["machine"])


def _refuse_emergency_stop(graph: LiveGraph) -> None:
    if graph.is_stopped():
        raise NoAnswer(f"the emergency stop is pressed; when the crane is safe, reset it: {RESET}")


def _demand(graph: LiveGraph, topic: topics.Topic) -> None:
    if not graph.has_message(topic):
        raise NoAnswer(f"nobody publishes {topic.name} in {graph.place}: no machine is behind the graph")


def _ask_whether_prepared(sure: bool) -> None:
    """Ask a person to confirm that what the experiment wants by hand is done.

    Raises:
        SessionError: nobody did.
    """
    if sure:
        return
    if not sys.stdin.isatty():
        raise SessionError("--live asks before each experiment, and nobody can answer here; allowed: --yes")
    if ask("  Prepared, and nobody near the crane? It will move. Type yes: ").lower() != "yes":
        raise SessionError("not confirmed; the experiment was not begun")


def _experiment(
    graph: LiveGraph, name: str, conditions: Conditions, bag: Path, logs: Path, tell: Callable[[float], None]
) -> dict[str, float]:
    """Drive and record one experiment; return what no topic tells of it."""
    plan = conditions.plan(name)
    _demand(graph, topics.PRESSURES if plan.bench else topics.JOINT_STATES)
    _refuse_emergency_stop(graph)
    takeover = ValveTakeover(graph)
    _tell_of_leftovers(takeover)
    specs = [operator(name, conditions, LISTENERS), _recorder(bag)]
    try:
        with _joining(specs, conditions.namespace, logs, listener(tell)) as running:
            running.run(until=OPERATOR)
    finally:
        if failed := takeover.restore():
            print(f"warning: {failed}", file=sys.stderr, flush=True)
    return dict(plan.metadata)


def _warn_of_pauses(bag: Path, timeout: float) -> None:
    """Say so if voltages came so late that the machine shut its valves meanwhile, which no topic tells.

    Args:
        bag: of the experiment.
        timeout: after which a machine shuts its valves [s].
    """
    pauses = np.diff(read_bag(bag).sent_ns(topics.VALVE_VOLTAGES)) * 1e-9
    late = pauses[pauses > timeout]
    if len(late):
        print(
            f"  warning: the voltages paused {len(late)} times, for up to {np.max(late):.2f} s; a machine "
            f"shuts its valves after {timeout:g} s without: this computer was too busy",
            flush=True,
        )


def _joining(specs: list[NodeSpec], namespace: str, logs: Path, echo: Callable[[str], None]) -> Supervisor:
    """Return the supervisor of nodes that join a graph; its driver says zero, not we."""
    return Supervisor(specs, namespace, logs, may_publish=False, on_log_line=echo, exclusive=False)


def _recorder(bag: Path) -> NodeSpec:
    """Return a recorder beside the graph's own, without which there is no experiment."""
    own = nodes.recorder(bag)
    return own._replace(name=RECORDER, arguments=(*own.arguments, "-r", f"__node:={RECORDER}"), needed=True)


def _tell_of_leftovers(takeover: ValveTakeover) -> None:
    """Tell of switches that were thrown before we came: they stay so."""
    for node, found in takeover.found.items():
        for name, value in found.items():
            if value == WANTED[node][name]:
                print(f"  note: {node}'s {name} is {value} already, and will be left so", flush=True)


def _vessel(bag: Path) -> dict[str, float]:
    """Ask what the vessel under the case drain holds.

    Raises:
        SessionError: nobody answers; the message says where the volume can be written.
    """
    while sys.stdin.isatty():
        try:
            text = ask("  Oil in the vessel [L], nothing if the drain has a meter: ")
        except SessionError as error:
            later = f"the record is whole, write {VOLUME} into {bag / session_bag.FILE}"
            raise SessionError(f"{error}; {later}") from error
        if not text:
            break
        try:
            return {VOLUME: experiment_metadata.checked(VOLUME, text, LITRE)}
        except ValueError as error:
            print(f"  {error} L")
    return {}


def _calibration(
    namespace: str, bag: Path, logs: Path, tell: Callable[[float], None], sure: bool
) -> dict[str, float]:
    """Record the sensors, first in ice, then in boiling water; return when which began and ended [s]."""
    baths = Baths(tell, sure)
    with contextlib.suppress(Recorded), _joining([_recorder(bag)], namespace, logs, _ignored) as running:
        running.run(progress=baths.watch)
    first = int(read_bag(bag).series(topics.PRESSURES).log_time_ns[0])
    ice, boiling = ((mark - first) * 1e-9 for mark in baths.marks)
    return {"ice_until": ice, "boiling_from": boiling}


def _ignored(_line: str) -> None:
    """Take a line of a node's log."""
