"""A track run by the nodes themselves: joystick, controller, driver and simulator over DDS, in lockstep.

The levers go into a bag of /joy, a message for every period, which the joystick's node says again; a
recorder writes down what came of it. Row k of a trajectory is step k + 1: the true state of the machine, and
what controller and driver answer to what its sensors say of it. So it is in `closed_loop` and
`compiled_loop`, which give the same numbers without ROS. As there, the oil stays as warm as the machine's
file says.
"""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from forest_bag.read.timeseries import Bag, read_bag
from forest_bag.write.bag_writer import BagWriter
from forest_bringup import graph, lockstep_run
from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import NodeSpec, Stopped
from forest_control.operator.joystick_watch import HEARTBEAT
from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER, Levers, axes_from_levers
from forest_description.types import Floats
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import Topic, message_class
from forest_msgs_py.runtime.parameter_table import typed_values
from forest_msgs_py.serialization.cdr import to_cdr
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.tracking.tracking import Course, Session

SAME = 1e-9  # [mm, m/s, s] by which two figures may differ and be the same
UNITS = {
    "angles": "rad",
    "tip": "m",
    "tip_wish": "m_per_s",
    "commands": "V",
    "voltages": "V",
    "pressures": "Pa",
}


class GraphSettings(NamedTuple):
    """What the nodes are told, in the words of the command's options."""

    machine: str  # the simulator's
    model: str  # controller's and driver's
    adapt: bool
    noise: bool
    static_errors: bool
    seed: int


def run(course: Course, levers: Floats, settings: GraphSettings, directory: Path) -> Trajectory:
    """Run a course through the graph; levers, bag and the nodes' logs go into a new directory.

    Args:
        course: what is driven.
        levers: [N, 4] that the operator gave in the loop without ROS.
        settings: of the nodes.
        directory: to be made.

    Raises:
        GraphError: another graph runs in the domain, or a node failed.
        KeyboardInterrupt: the user stopped it.
    """
    steps = len(levers)
    write_joystick(directory / "joystick", levers)
    nodes = _nodes(course, settings, directory)
    try:
        lockstep_run.run(nodes, steps, directory / "log")
    except Stopped as stopped:
        raise KeyboardInterrupt from stopped
    return trajectory(read_bag(directory / "bag"), steps)


def write_joystick(directory: Path, levers: Floats) -> None:
    """Write a bag of a joystick's messages, one a period, from rows of levers and deadman."""
    writer, topic = BagWriter(directory), topics.JOY
    writer.add_topic(f"/{topic.name}", topic.type, [offered_qos(topic)], "")
    kind = message_class(topic)
    try:
        for count, (swing, boom, stick, held) in enumerate(levers.tolist(), start=1):
            axes, stamp = axes_from_levers(Levers(swing, boom, stick)), count * PERIOD_NS
            message = kind(axes=axes, buttons=[0] * BUTTON_COUNT)
            message.buttons[LEFT_SHOULDER] = int(held > 0.5)
            message.header.stamp, message.header.frame_id = ns_to_stamp(stamp), f"{HEARTBEAT}{count}"
            writer.write(f"/{topic.name}", to_cdr(message), stamp, stamp, count)
    finally:
        writer.close()


def _nodes(course: Course, settings: GraphSettings, directory: Path) -> list[NodeSpec]:
    """Return the graph, the recorder included; the controller is told every setting of the course."""
    label = course.settings.scheme.label
    controller, driver = graph.control(settings.model, label, shadow=False, describe=False)
    typed = typed_values(course.settings)
    del typed["scheme"]  # `graph.control` tells it
    simulated = {
        "initial_tip": course.start,
        "sensor_noise": settings.noise,
        "sensor_static_errors": settings.static_errors,
        "seed": settings.seed,
        "oil_warms": False,
    }
    return [
        graph.joystick(str((directory / "joystick").resolve()), 0.0, 0),
        _with_parameters(controller, typed),
        _with_parameters(driver, {"adapt": settings.adapt}),
        _with_parameters(graph.simulator(settings.machine), simulated),
        graph.recorder(directory / "bag"),
    ]


def _with_parameters(node: NodeSpec, values: Mapping[str, object]) -> NodeSpec:
    return node._replace(arguments=(*node.arguments, *graph.parameters(values)))


def trajectory(bag: Bag, steps: int) -> Trajectory:
    """Return what a bag of a run in lockstep says.

    Raises:
        GraphError: it lacks a step of the machine.
    """
    angles = _rows(bag, topics.GROUND_TRUTH_JOINT_STATES, steps, math.nan)[:, :3]
    tip = _rows(bag, topics.GROUND_TRUTH_TIP_POSE, steps, math.nan)[:, :3]
    if np.isnan(angles).any() or np.isnan(tip).any():
        raise GraphError("the bag of the run through ROS lacks steps of the machine")
    return Trajectory(
        time=PERIOD * np.arange(steps, dtype=np.float64),
        angles=angles,
        tip=tip,
        tip_wish=_rows(bag, topics.TIP_TWIST_COMMAND, steps, 0.0),
        commands=_rows(bag, topics.VALVE_COMMANDS, steps, 0.0),
        voltages=_rows(bag, topics.VALVE_VOLTAGES, steps, 0.0),
        pressures=_rows(bag, topics.PRESSURES, steps, math.nan),
    )


def _rows(bag: Bag, topic: Topic, steps: int, silent: float) -> Floats:
    """Return a topic's numbers, a row for each step; where nothing was said, a number for that."""
    if bag.name(topic) is None:
        return np.full((steps, len(topic.labels)), silent)
    series = bag.series(topic)
    found = np.full((steps, series.values.shape[1]), silent)
    found[series.time_ns // PERIOD_NS - 1] = series.values
    return found


def comparison(alone: Session, through: Session) -> dict[str, Any]:
    """Return the figures without ROS, and how far what happened is from what happened through ROS."""
    pairs = zip((alone.total, *alone.scores), (through.total, *through.scores), strict=True)
    apart = [abs(a - b) for pair in pairs for a, b in zip(*pair, strict=True)]
    return {
        "without_ros": alone.total._asdict(),
        "differences": differences(alone.moved, through.moved),
        "same": all(difference <= SAME for difference in apart),
    }


def differences(one: Trajectory, other: Trajectory) -> dict[str, float]:
    """Return the greatest difference of each of a trajectory's columns; two readings of nothing are equal."""
    pairs = {f"{name}_{unit}": (getattr(one, name), getattr(other, name)) for name, unit in UNITS.items()}
    return {name: _greatest(a, b) for name, (a, b) in pairs.items()}


def _greatest(a: Floats, b: Floats) -> float:
    apart = np.where(np.isnan(a) & np.isnan(b), 0.0, np.abs(a - b))
    return float(np.max(apart))
