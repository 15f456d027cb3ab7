"""An experiment of the identification in a graph of its own: nodes in lockstep with the simulated machine.

The scripted operator, the valve driver with its compensation off, the simulator and the recorder. The
machine is the plan's: the crane, on its tilted platform or not, or a test rig made of its parts; the nodes
get it as a file. Calibration needs ice, boiling water and open lines, which no graph has.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from forest_bringup import graph
from forest_bringup.graph_lock import GraphError
from forest_bringup.lockstep_run import RECORDER, in_lockstep
from forest_bringup.supervisor import NodeSpec, Supervisor
from forest_description.export.machine_yaml import machine_text
from forest_description.machine import Machine, load_machine
from forest_ident.experiments import experiment_plan
from forest_ident.experiments.experiment_plan import Plan
from forest_ident.measurements import session_bag
from forest_msgs_py.types import PERIOD

OPERATOR = "experiment_operator"
OPERATOR_MODULE = "forest_ident.experiment_operator_node"
PROGRESS = OPERATOR.partition("_")[2] + " at"  # begins what the operator says every second

Progress = Callable[[float], None]  # is told the time in the experiment [s]


class Conditions(NamedTuple):
    """What an experiment is made with, in the words of the command's options."""

    machine: str  # name or file of the crane
    seed: int = 0
    exact: bool = False
    longest: float = math.inf  # [s] where programmes are cut off, for a trial
    timeout: float = 0.1  # [s] age at which the operator takes the machine's state for lost
    namespace: str = "/"

    def plan(self, name: str) -> Plan:
        """Return the plan of an experiment."""
        return experiment_plan.plan(name, load_machine(self.machine), self.seed, self.longest)


def run(name: str, conditions: Conditions, bag: Path, logs: Path, progress: Progress) -> None:
    """Make an experiment's bag.

    Args:
        name: of the experiment; not "calibration".
        conditions: machine, sensors.
        bag: directory to be made.
        logs: directory to be made, for the machine's file and what the nodes say.
        progress: told how far it is.

    Raises:
        GraphError: another graph runs in the domain, or a node failed, or stopped the experiment.
        Stopped: the user asked to stop.
    """
    plan = conditions.plan(name)
    steps = round(plan.programme.duration / PERIOD)
    nodes = in_lockstep(_nodes(plan, conditions, bag, _machine_file(plan, logs)), steps)
    heard = listener(progress)
    with Supervisor(nodes, conditions.namespace, logs, on_log_line=heard) as running:
        running.run(until=RECORDER)
    if failed := [name for name, code in running.exit_codes.items() if code != 0]:
        raise GraphError(f"{name}: {', '.join(failed)} ended badly; see the logs in {logs}")
    exact = {"exact_sensors": 1.0} if conditions.exact else {}
    session_bag.write_metadata(bag, name, {**plan.metadata, **exact})


def listener(progress: Progress) -> Callable[[str], None]:
    """Return what takes the nodes' lines and finds in them how far the operator is."""

    def heard(line: str) -> None:
        if line.startswith(PROGRESS):
            progress(float(line.removeprefix(PROGRESS).split()[0]))

    return heard


def operator(name: str, conditions: Conditions, listeners: int) -> NodeSpec:
    """Return the scripted operator of an experiment."""
    values = {
        "experiment": name,
        "seed": conditions.seed,
        "longest": conditions.longest if math.isfinite(conditions.longest) else 0.0,
        "timeout": conditions.timeout,
        "listeners": listeners,
    }
    machine = graph.machine_arguments(conditions.machine)
    return NodeSpec(OPERATOR, OPERATOR_MODULE, (*machine, *graph.parameters(values)))


def _machine_file(plan: Plan, logs: Path) -> Path:
    """Write the machine as it is prepared for the experiment."""
    logs.mkdir(parents=True)
    file = logs / "machine.yaml"
    file.write_text(machine_text(_with_vessel(plan), f"prepared for {plan.name}"), encoding="utf-8")
    return file


def _with_vessel(plan: Plan) -> Machine:
    """Return a plan's machine; with a meter where the motor's drain is led into a vessel."""
    if not plan.name.startswith("motor") or plan.machine.sensors.case_drain is not None:
        return plan.machine
    meter = load_machine("c180_hoses").sensors.case_drain
    return dataclasses.replace(
        plan.machine, sensors=dataclasses.replace(plan.machine.sensors, case_drain=meter)
    )


def _nodes(plan: Plan, conditions: Conditions, bag: Path, machine: Path) -> list[NodeSpec]:
    prepared = graph.machine_arguments(str(machine))
    simulated = {
        "initial_tip": plan.tip,
        "sensor_noise": not conditions.exact,
        "seed": conditions.seed,
        "noise_run": plan.name,
        "rig": plan.bench,
        "oil_warms": not plan.bench,
    }
    raw = graph.parameter("compensate", False)
    return [
        operator(plan.name, conditions, 0),
        NodeSpec("valve_driver", "forest_control.valve_driver_node", (*prepared, *raw)),
        NodeSpec("simulator", "forest_sim.simulator_node", (*prepared, *graph.parameters(simulated))),
        graph.recorder(bag),
    ]
