"""A bag written again, with every joint of the crane and its frames.

Foxglove and Lichtblick move a robot by /tf alone, and a recorder without tf2_msgs has none. What is
added follows from the bag: its URDF, its joint states, and sway and bending if they are in there.
"""

import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from forest_bag.convert.rewrite import offer, prepare
from forest_bag.read.merged_bags import MergedBags
from forest_bag.read.recorded_machine import recorded_machine
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import RawMessage
from forest_bag.write.bag_writer import BagWriter
from forest_description.config.parameter import MachineError
from forest_description.machine import Machine, load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.serialization.cdr import cdr_type
from forest_msgs_py.serialization.packing import Packer
from forest_msgs_py.serialization.transforms import pack_transforms
from forest_viewers.crane.frames import fixed_frames, moving_frames, urdf_joints
from forest_viewers.crane.whole_crane import WholeCrane

ADDED = (topics.TF_STATIC, topics.TF, topics.VIEWER_JOINT_STATES)
PERIOD_NS = 20_000_000  # between two poses
DESCRIPTION = f"/{topics.ROBOT_DESCRIPTION.name}"


def with_frames(bag: Path, output: Path, machine: str = "") -> int:
    """Write a bag again with frames; return how many poses were added.

    Args:
        bag: Directory or file.
        output: Directory to be made.
        machine: Shipped machine or file; "": the one of the bag's URDF, whose file it holds or names.

    Raises:
        BagError: it is no bag, has no URDF, or has frames.
        MachineError: the machine is not known here.
        OSError: the output exists, or its disk is full.
    """
    with MergedBags([bag]) as source:
        offers = [offer(name, channels) for name, channels in source.channels.items()]
        if present := [topic.name for topic in ADDED if _name(topic) in source.channels]:
            raise BagError(f"{bag} has {present[0]}; allowed: a bag without")
        urdf = _urdf(source)
        crane = _Crane(urdf, _machine(source, urdf, machine))
        writer = BagWriter(output)
        try:
            with closing(writer):
                prepare(writer, source, offers)
                for topic in ADDED:
                    writer.add_topic(_name(topic), topic.type, [offered_qos(topic)], "")
                for message in source.messages():
                    _write(writer, message.channel.topic, message, message.data)
                    for topic, data in crane.after(message):
                        _write(writer, _name(topic), message, data)
        except BaseException:  # half a bag would look like a whole one
            shutil.rmtree(output, ignore_errors=True)
            raise
        return writer.counts[_name(topics.TF)]


class _Crane:
    """What follows from the bag's messages, one after the other."""

    def __init__(self, urdf: str, machine: Machine) -> None:
        self._joints, self._crane = urdf_joints(urdf), WholeCrane(machine)
        self._packer = Packer(topics.VIEWER_JOINT_STATES._replace(labels=self._crane.names))
        self._missing = (float("nan"),) * (2 * len(self._crane.names))  # speeds and efforts
        self._next_ns, self._begun = 0, False

    def after(self, message: RawMessage) -> Iterator[tuple[Topic, bytes]]:
        """Give what is to stand behind a message."""
        if not self._begun:
            self._begun = True
            yield topics.TF_STATIC, pack_transforms(message.log_ns, fixed_frames(self._joints))
        row = topics.find(message.channel.topic)
        if row == topics.GROUND_TRUTH_HEAD:
            self._crane.hear_head(message.data)
        elif row == topics.GROUND_TRUTH_DEFLECTIONS:
            self._crane.hear_deflections(message.data)
        if row != topics.JOINT_STATES or message.log_ns < self._next_ns:
            return
        pose = self._crane.pose(message.data)
        if pose is None:
            return
        self._next_ns = message.log_ns + PERIOD_NS
        data = self._packer.pack(pose.stamp_ns, (*pose.positions, *self._missing))
        if data is not None:
            yield topics.VIEWER_JOINT_STATES, data
        frames = moving_frames(self._joints, dict(zip(self._crane.names, pose.positions, strict=True)))
        yield topics.TF, pack_transforms(pose.stamp_ns, frames)


def _write(writer: BagWriter, topic: str, beside: RawMessage, data: bytes) -> None:
    writer.write(topic, data, beside.log_ns, beside.publish_ns, beside.sequence)


def _urdf(source: MergedBags) -> str:
    for message in source.messages([name for name in source.channels if name.endswith(DESCRIPTION)]):
        return str(cdr_type(topics.ROBOT_DESCRIPTION.type).decode(message.data).data)
    raise BagError(f"{source.path} has no {DESCRIPTION}; allowed: a bag that tells the crane's URDF")


def _machine(source: MergedBags, urdf: str, given: str) -> Machine:
    if not given and (recorded := recorded_machine(source.readers, urdf)):
        return recorded
    name = given or urdf.partition('<robot name="')[2].partition('"')[0]
    try:
        return load_machine(name)
    except MachineError as error:
        raise error if given else MachineError(f"{error}; --machine names the bag's machine") from error


def _name(topic: Topic) -> str:
    return f"/{topic.name.lstrip('/')}"
