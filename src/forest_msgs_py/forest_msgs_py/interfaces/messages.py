"""Arrays and messages: the only place where numbers are put into, or taken out of, ROS messages.

=============  =============================================================================================
symbol         meaning
=============  =============================================================================================
stamp_ns       ROS time, integer nanoseconds
problem        "" for a good message; otherwise what is wrong with it and what is allowed
data_offset    numbers in front of the values: 2 (sec, nanosec), or 0 (no stamp: counts as of now)
=============  =============================================================================================

Readers never raise: a message from outside may be anything, and a loop must go on. They give a ``Reading``
with a ``problem``, and no values, instead. SI units throughout, volts at the valves; see
:mod:`forest_msgs_py.interfaces.topics`.
"""

import math
from array import array
from collections.abc import Sequence
from typing import Any, NamedTuple

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TwistStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.types import NS_PER_S

STAMP_SIZE = 2  # sec and nanosec in front of the values
POSE_SIZE = 7  # position and quaternion
UNSET = (0.0, 0.0, 0.0, 0.0)  # an orientation that nobody knows
MAX_SEC = 2**31 - 1  # builtin_interfaces/Time holds an int32


class Reading(NamedTuple):
    """What a message said: ``values`` is empty when there is a ``problem``."""

    stamp_ns: int
    values: Any
    problem: str


class JointValues(NamedTuple):
    """One sample of named joints; ``velocity`` and ``effort`` are () where the message has none."""

    position: tuple[float, ...] = ()
    velocity: tuple[float, ...] = ()
    effort: tuple[float, ...] = ()


class JoyValues(NamedTuple):
    """Levers (-1..1) and buttons (0 or 1)."""

    axes: tuple[float, ...] = ()
    buttons: tuple[int, ...] = ()


def stamp_to_ns(stamp: Any) -> int:
    """builtin_interfaces/Time to nanoseconds."""
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def ns_to_stamp(stamp_ns: int) -> Time:
    """Nanoseconds to builtin_interfaces/Time; nanosec is in 0..1e9-1 for times before the epoch, too."""
    sec, nanosec = divmod(stamp_ns, NS_PER_S)
    return Time(sec=sec, nanosec=nanosec)


def float_array(
    topic: Topic,
    stamp_ns: int,
    values: Sequence[float],
    plain: bool = False,
    labels: tuple[str, ...] | None = None,
) -> Float64MultiArray:
    """Values of a topic as a stamped, labelled array.

    Args:
        topic: row of the topic table.
        stamp_ns: ROS time of the values, ns.
        values: one number per label, in the label's unit.
        plain: publish the bare values, for programs that expect ``data_offset`` 0.
        labels: names of the values where a machine has other sensors than the table lists.

    Raises:
        ValueError: the number of values is not the number of labels.
    """
    labels = topic.labels if labels is None else labels
    size = len(labels)
    if len(values) != size:
        raise ValueError(f"{topic.name}: {len(values)} values; allowed: {size} ({', '.join(labels)})")
    message = Float64MultiArray()
    message.layout.dim = [MultiArrayDimension(label=",".join(labels), size=size, stride=size)]
    message.layout.data_offset = 0 if plain else STAMP_SIZE
    message.data = array("d", values if plain else (*divmod(stamp_ns, NS_PER_S), *values))
    return message


def sensor_array(
    topic: Topic, stamp_ns: int, values: Sequence[float], plain: bool = False
) -> Float64MultiArray | None:
    """Readings of a topic's sensors; NaN stands for a sensor without a sample, which has no label either.

    Returns:
        The array of those that have one, or None: there is nothing to say.
    """
    present = [place for place, value in enumerate(values) if not math.isnan(value)]
    if len(present) == len(values):
        return float_array(topic, stamp_ns, values, plain)
    if not present:
        return None
    labels = tuple(topic.labels[place] for place in present)
    return float_array(topic, stamp_ns, [values[place] for place in present], plain, labels)


def read_float_array(
    topic: Topic, message: Any, now_ns: int, labels: tuple[str, ...] | None = None
) -> Reading:
    """Values of an array in the order of ``labels`` (default: the topic's), by name where it has names.

    Args:
        topic: row of the topic table.
        message: Float64MultiArray.
        now_ns: stamp of a message that carries none, ns.
        labels: names wanted; the message may carry more.

    Returns:
        Reading with a tuple of floats, one per label, all finite.
    """
    wanted = topic.labels if labels is None else labels
    data, offset = message.data, message.layout.data_offset
    if offset not in (0, STAMP_SIZE):
        return _bad(topic.name, now_ns, f"data_offset is {offset}", "0, or 2 (sec, nanosec)")
    if len(data) < offset:
        return _bad(topic.name, now_ns, f"{len(data)} numbers", "2 for the stamp, then the values")
    stamp_ns = array_stamp(data) if offset else now_ns
    if stamp_ns is None:
        return _bad(topic.name, now_ns, f"stamp is ({data[0]}, {data[1]})", "whole sec, nanosec 0..999999999")
    text = message.layout.dim[0].label if message.layout.dim else ""
    names = tuple(name.strip() for name in text.split(",")) if text else topic.labels
    if len(data) - offset != len(names):
        expected = f"{len(names)} ({', '.join(names)})"
        return _bad(topic.name, now_ns, f"{len(data) - offset} values", expected)
    return _pick(topic.name, stamp_ns, names, data[offset:], wanted)


def joint_state(
    names: Sequence[str],
    stamp_ns: int,
    position: Sequence[float],
    velocity: Sequence[float] = (),
    effort: Sequence[float] = (),
) -> JointState:
    """One sample of named joints; rad or m, per second, N·m or N."""
    message = JointState(name=list(names))
    message.header.stamp = ns_to_stamp(stamp_ns)
    message.position = array("d", position)
    message.velocity = array("d", velocity)
    message.effort = array("d", effort)
    return message


def sensor_joint_state(
    names: Sequence[str],
    stamp_ns: int,
    position: Sequence[float],
    velocity: Sequence[float],
    effort: Sequence[float],
) -> JointState | None:
    """Readings of joints; one whose position is NaN has no sample and is left out.

    Velocity and effort are told of all joints that are there, or not at all: the message has no gaps.

    Returns:
        The state of those that have a position, or None: there is nothing to say.
    """
    present = [place for place, value in enumerate(position) if not math.isnan(value)]
    if not present:
        return None
    rows = ([data[place] for place in present] for data in (position, velocity, effort))
    told = [() if any(map(math.isnan, row)) else row for row in rows]
    return joint_state([names[place] for place in present], stamp_ns, *told)


def read_joint_state(names: Sequence[str], message: Any) -> Reading:
    """Joints by name, whatever their order in the message; others may be there as well.

    Velocity and effort are optional in a JointState: absent, of a wrong length or not finite, they are ().
    """
    stamp_ns = stamp_to_ns(message.header.stamp)
    index = {name: place for place, name in enumerate(message.name)}
    missing = [name for name in names if index.get(name, len(message.position)) >= len(message.position)]
    if missing:
        return _no_joints(stamp_ns, f"no position of {', '.join(missing)}", ", ".join(names))
    if len(index) != len(message.name) and (many := [n for n in names if message.name.count(n) > 1]):
        return _no_joints(stamp_ns, f"more than one {', '.join(many)}", "each joint once")
    places = [index[name] for name in names]
    position = tuple(message.position[place] for place in places)
    if not all(map(math.isfinite, position)):
        return _no_joints(stamp_ns, f"position is {position}", "finite numbers")
    count = len(message.name)
    values = JointValues(
        position, _optional(message.velocity, places, count), _optional(message.effort, places, count)
    )
    return Reading(stamp_ns, values, "")


def read_joy(message: Any, min_axes: int = 4, min_buttons: int = 1) -> Reading:
    """Levers and buttons, if there are as many as the reader needs and every lever is finite within -1..1."""
    values = JoyValues(tuple(message.axes), tuple(message.buttons))
    return judged_joy(stamp_to_ns(message.header.stamp), values, min_axes, min_buttons)


def judged_joy(stamp_ns: int, values: JoyValues, min_axes: int, min_buttons: int) -> Reading:
    """What `read_joy` says of these levers and buttons."""
    if len(values.axes) < min_axes or len(values.buttons) < min_buttons:
        problem = f"{len(values.axes)} axes and {len(values.buttons)} buttons"
        allowed = f"at least {min_axes} and {min_buttons}"
    elif not all(-1.0 <= axis <= 1.0 for axis in values.axes):  # false for NaN as well
        problem, allowed = f"axes are {values.axes}", "-1..1"
    else:
        return Reading(stamp_ns, values, "")
    return Reading(stamp_ns, JoyValues(), f"joy: {problem}; allowed: {allowed}")


def twist_stamped(stamp_ns: int, frame: str, linear: Sequence[float]) -> TwistStamped:
    """Linear velocity of the tip, [x, y, z], m/s, in ``frame``."""
    message = TwistStamped()
    message.header.stamp, message.header.frame_id = ns_to_stamp(stamp_ns), frame
    vector = message.twist.linear
    vector.x, vector.y, vector.z = map(float, linear)
    return message


def pose_stamped(stamp_ns: int, frame: str, values: Sequence[float]) -> PoseStamped:
    """Pose of the tip in ``frame``: [x, y, z], m, and perhaps the quaternion [qx, qy, qz, qw].

    Without a quaternion, or with NaN in it, the orientation is all zero: ROS' sign for one that nobody set.
    """
    message = PoseStamped()
    message.header.stamp, message.header.frame_id = ns_to_stamp(stamp_ns), frame
    point = message.pose.position
    point.x, point.y, point.z = map(float, values[:3])
    told = len(values) == POSE_SIZE and math.isfinite(sum(values[3:]))
    turn = message.pose.orientation
    turn.x, turn.y, turn.z, turn.w = map(float, values[3:]) if told else UNSET
    return message


def array_stamp(data: Sequence[float]) -> int | None:
    """The stamp in front of an array's values [ns], or None if it is none."""
    sec, nanosec = data[0], data[1]
    if not (-MAX_SEC - 1 <= sec <= MAX_SEC and 0 <= nanosec < NS_PER_S):  # false for NaN as well
        return None
    if sec != int(sec) or nanosec != int(nanosec):
        return None
    return int(sec) * NS_PER_S + int(nanosec)


def _pick(
    name: str, stamp_ns: int, names: tuple[str, ...], data: Sequence[float], wanted: tuple[str, ...]
) -> Reading:
    by_name = dict(zip(names, data, strict=True))
    missing = [label for label in wanted if label not in by_name]
    if missing or len(by_name) != len(names):
        what = f"no value of {', '.join(missing)}" if missing else f"labels repeat: {', '.join(names)}"
        return _bad(name, stamp_ns, what, ", ".join(wanted))
    values = tuple(by_name[label] for label in wanted)
    for label, value in zip(wanted, values, strict=True):
        if not math.isfinite(value):
            return _bad(name, stamp_ns, f"{label} is {value}", "finite numbers")
    return Reading(stamp_ns, values, "")


def _optional(data: Sequence[float], places: Sequence[int], count: int) -> tuple[float, ...]:
    if len(data) != count:
        return ()
    values = tuple(data[place] for place in places)
    return values if all(map(math.isfinite, values)) else ()


def _bad(name: str, stamp_ns: int, problem: str, allowed: str) -> Reading:
    return Reading(stamp_ns, (), f"{name}: {problem}; allowed: {allowed}")


def _no_joints(stamp_ns: int, problem: str, allowed: str) -> Reading:
    return Reading(stamp_ns, JointValues(), f"joint state: {problem}; allowed: {allowed}")
