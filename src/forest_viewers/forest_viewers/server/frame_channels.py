"""/tf and /tf_static for clients where ROS cannot publish them: tf2_msgs is no wheel.

The frames are computed from the crane's description and all its joints, as `viewer_node` does where
tf2_msgs is installed.
"""

from collections.abc import Callable, Mapping
from typing import Any

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import stamp_to_ns
from forest_msgs_py.interfaces.topics import Topic
from forest_msgs_py.serialization.cdr import CdrError, cdr_type
from forest_msgs_py.serialization.transforms import pack_transforms
from forest_viewers.crane.frames import Joint, fixed_frames, moving_frames, urdf_joints

MADE_FROM = {
    topics.TF: (topics.ROBOT_DESCRIPTION, topics.VIEWER_JOINT_STATES),
    topics.TF_STATIC: (topics.ROBOT_DESCRIPTION,),
}


class FrameChannels:
    """The two topics of frames.

    Args:
        resolved: gives a topic's name in the node's namespace.
        needed: whether they are to be made; if not, nothing here does anything.
    """

    def __init__(self, resolved: Callable[[str], str], needed: bool) -> None:
        self._description = resolved(topics.ROBOT_DESCRIPTION.name)
        self._joint_states = resolved(topics.VIEWER_JOINT_STATES.name)
        self._sources = {
            made.name: tuple(resolved(topic.name) for topic in sources)
            for made, sources in MADE_FROM.items()
            if needed
        }
        self._joints: tuple[Joint, ...] = ()

    def offered(self, present: Mapping[str, str]) -> dict[str, str]:
        """Return types of the topics that can be made from those that are present, by name."""
        whole = (name for name, sources in self._sources.items() if present.keys() >= {*sources})
        return dict.fromkeys(whole, topics.TF.type)

    def sources(self, name: str) -> tuple[str, ...]:
        """Return the topics from which a topic is made; none for another topic."""
        return self._sources.get(name, ())

    def made_from(self, name: str) -> tuple[str, ...]:
        """Return the topics that are made from a topic."""
        return tuple(made for made, sources in self._sources.items() if name in sources)

    def answer(self, name: str, data: bytes) -> list[tuple[str, bytes]]:
        """Return names and bytes of the messages that a message of the graph gives rise to."""
        if not self._sources:
            return []
        try:
            if name == self._description:
                text = _decoded(topics.ROBOT_DESCRIPTION, data).data
                self._joints = urdf_joints(text)
                return [(topics.TF_STATIC.name, pack_transforms(0, fixed_frames(self._joints)))]
            if name == self._joint_states and self._joints:
                told = _decoded(topics.VIEWER_JOINT_STATES, data)
                positions = dict(zip(told.name, map(float, told.position), strict=False))
                stamp = stamp_to_ns(told.header.stamp)
                return [(topics.TF.name, pack_transforms(stamp, moving_frames(self._joints, positions)))]
        except (CdrError, ValueError):
            return []  # somebody else's message: the clients get it as it is
        return []


def _decoded(topic: Topic, data: bytes) -> Any:
    return cdr_type(topic.type).decode(data)
