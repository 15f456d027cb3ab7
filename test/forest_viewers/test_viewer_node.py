"""The node that draws the crane: what it says of a machine that others tell of."""

import math

import pytest

pytest.importorskip("rclpy")

from rclpy.executors import SingleThreadedExecutor

from forest_description.derived.passive_joints import cylinder_joint_positions
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.runtime.node import publisher, subscription

# A reply to a node that has not met this one yet, on a busy computer; it asks again.
pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")

Q, BENT = (0.3, 0.5, -1.2), (0.01, -0.02, 0.005)
LOADER = load_machine("loader")


def test_all_joints_the_trails_and_the_controllers_walls_are_told(start_process, make_node, wait_until):
    node = make_node("controller")
    node.declare_parameter("workspace", "c180")
    joints, head = publisher(node, topics.JOINT_STATES), publisher(node, topics.GROUND_TRUTH_HEAD)
    bent = publisher(node, topics.GROUND_TRUTH_DEFLECTIONS)
    pose, command = publisher(node, topics.TIP_POSE), publisher(node, topics.TIP_TWIST_COMMAND)
    told, drawn = [], {}
    subscription(node, topics.VIEWER_JOINT_STATES, told.append)
    subscription(
        node, topics.VIEWER_MARKERS, lambda said: drawn.update({one.ns: one for one in said.markers})
    )
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    viewer = start_process(["-m", "forest_viewers.viewer_node", "--ros-args", "-p", "machine:=loader"])
    steps = iter(range(10**6))

    def swaying():
        k = next(steps)
        stamp = k * 10_000_000
        joints.publish(messages.joint_state(topics.JOINTS, stamp, Q))
        bent.publish(messages.float_array(topics.GROUND_TRUTH_DEFLECTIONS, stamp, BENT))
        head.publish(messages.joint_state(topics.HEAD_JOINTS, stamp, (0.1, -0.2)))
        pose.publish(messages.pose_stamped(stamp, "base_link", (0.01 * k, 0.0, 0.0)))
        command.publish(messages.twist_stamped(stamp, "base_link", (1.0, 0.0, 0.0)))
        seen = bool(told) and told[-1].position[-1] == -0.2 and told[-1].position[0] != Q[0]
        return seen and {"tip", "command", "work_area", "walls"} <= drawn.keys()

    wait_until(swaying, executor=executor)
    executor.shutdown()
    assert viewer.stop() == 0
    assert tuple(told[-1].name) == topics.VIEWER_JOINT_STATES.labels
    links = tuple(angle + by for angle, by in zip(Q, BENT, strict=True))
    assert tuple(told[-1].position) == (*links, *cylinder_joint_positions(Q, LOADER), 0.1, -0.2)
    assert drawn["tip"].header.frame_id == "base_link"
    assert drawn["tip"].lifetime.sec == 1
    assert all(math.isfinite(point.x) for point in drawn["command"].points)
    assert drawn["command"].points[0].y == ZERO[1]
