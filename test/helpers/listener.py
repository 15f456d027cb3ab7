"""A plain ROS program that knows nothing of this project; prints ``heard N`` and ends with 0 if N > 0."""

import sys
import time

import rclpy
from sensor_msgs.msg import JointState

heard = []
rclpy.init()
node = rclpy.create_node("plain_listener")
node.create_subscription(JointState, "joint_states", heard.append, 10)
deadline = time.monotonic() + float(sys.argv[1])
while len(heard) < 5 and time.monotonic() < deadline:
    rclpy.spin_once(node, timeout_sec=0.1)
print("heard", len(heard))
node.destroy_node()
rclpy.shutdown()
sys.exit(not heard)
