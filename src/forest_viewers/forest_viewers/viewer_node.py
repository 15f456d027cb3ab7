"""The crane for viewers: every joint on viewer/joint_states, /tf, and markers on viewer/markers.

The joints of cylinders and head are computed, since nobody measures them. With a simulator the head
sways and the links bend as they do there; without, the head hangs still and the links are rigid.
/tf and /tf_static are published where tf2_msgs is installed: from a ROS installation, not from
wheels. The walls are those that the controller keeps. Nothing here commands anything.
"""

import sys
from typing import Any

from rclpy.node import Node

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.limits.workspace import OPEN
from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.clock.node_clock import LiveClock, number_publisher
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.marker_messages import marker_array, removal
from forest_msgs_py.introspection.parameter_mirror import ParameterMirror
from forest_msgs_py.introspection.raw_publishers import is_installed
from forest_msgs_py.runtime.node import publisher, raw_publish, run_node, timer
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import MachineParameter
from forest_msgs_py.runtime.polled_subscription import polled_subscription
from forest_msgs_py.serialization.transforms import pack_transforms
from forest_viewers.crane.arrivals import decoded_arrivals
from forest_viewers.crane.frames import fixed_frames, moving_frames, urdf_joints
from forest_viewers.crane.shapes import scene_shapes, trail_shapes
from forest_viewers.crane.trail import Trail, with_command, with_tip
from forest_viewers.crane.whole_crane import WholeCrane

TURN, TRAIL, SCENE = 0.02, 0.1, 1.0  # [s] between two poses, two trails, two pictures of what stands still


class ViewerNode(Node):
    """Shell around `forest_viewers.crane`."""

    def __init__(self) -> None:
        super().__init__("viewer")
        self._machine = load_machine(declare(self, MachineParameter).machine)
        self._crane, self._workspace, self._trail = WholeCrane(self._machine), OPEN, Trail()
        self._frames = urdf_joints(robot_description(self._machine))
        self._joints = polled_subscription(self, topics.JOINT_STATES)
        self._head = polled_subscription(self, topics.GROUND_TRUTH_HEAD)
        self._deflections = polled_subscription(self, topics.GROUND_TRUTH_DEFLECTIONS)
        self._tip = polled_subscription(self, topics.TIP_POSE)
        self._command = polled_subscription(self, topics.TIP_TWIST_COMMAND)
        row = topics.VIEWER_JOINT_STATES._replace(labels=self._crane.names)
        self._all_joints = number_publisher(LiveClock(self), row)
        self._missing = (float("nan"),) * (2 * len(self._crane.names))  # speeds and efforts
        self._markers = publisher(self, topics.VIEWER_MARKERS)
        self._publish_frames = None
        if is_installed(topics.TF.type):
            self._publish_frames = raw_publish(publisher(self, topics.TF))
            self._static = publisher(self, topics.TF_STATIC)
            raw_publish(self._static)(pack_transforms(self._now(), fixed_frames(self._frames)))
        else:
            self.get_logger().info("tf2_msgs is not installed: no /tf; the Foxglove server makes its own")
        self._mirror = ParameterMirror(self, self._parameters_changed)
        timer(self, TURN, self._turn)
        timer(self, TRAIL, lambda: self._draw(trail_shapes(self._trail)))
        timer(self, SCENE, self._scene)

    def _turn(self) -> None:
        """Publish the newest pose; remember where the tip is and was told to be."""
        if (head := self._head.newest()) is not None:
            self._crane.hear_head(head.message)
        if (bent := self._deflections.newest()) is not None:
            self._crane.hear_deflections(bent.message)
        arrival = self._joints.newest()
        if arrival is not None and (pose := self._crane.pose(arrival.message)) is not None:
            self._all_joints.publish(pose.stamp_ns, (*pose.positions, *self._missing))
            if self._publish_frames is not None:
                positions = dict(zip(self._crane.names, pose.positions, strict=True))
                self._publish_frames(pack_transforms(pose.stamp_ns, moving_frames(self._frames, positions)))
        for time, pose in decoded_arrivals(self._tip, topics.TIP_POSE):
            place = pose.pose.position
            self._trail = with_tip(self._trail, time, (place.x, place.y, place.z))
        for time, twist in decoded_arrivals(self._command, topics.TIP_TWIST_COMMAND):
            v = twist.twist.linear
            self._trail = with_command(self._trail, time, (v.x, v.y, v.z))

    def _scene(self) -> None:
        self._mirror.look()
        self._draw(scene_shapes(self._machine, self._workspace))

    def _draw(self, shapes: list[Any]) -> None:
        if shapes:
            self._markers.publish(marker_array(self._now(), shapes))

    def _parameters_changed(self, values: dict[str, Any]) -> None:
        """Follow the controller's walls."""
        name = values.get(f"{self.get_namespace().rstrip('/')}/controller.workspace")
        if name is None:
            return
        try:
            self._workspace = load_workspace(name)
        except SettingFileError as error:
            self.get_logger().warning(f"the walls are not drawn: {error}")
            self._workspace = OPEN
        self._markers.publish(removal("walls"))

    def _now(self) -> int:
        return int(self.get_clock().now().nanoseconds)


def main(args: list[str] | None = None) -> int:
    """Entry point of the console script."""
    return run_node(ViewerNode, args)


if __name__ == "__main__":
    sys.exit(main())
