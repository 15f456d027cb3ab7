"""A stranger who talks on a command topic: full voltage, a joystick at rest, or a machine that stands.

python shouter.py TOPIC RATE_HZ    prints "shouting" and goes on until it is stopped
"""

import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT
from forest_description.types import AXES, ZERO
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import find, message_class
from forest_msgs_py.runtime.environment import prepare_environment

SHOUTED = 3.0, 3.0, 3.0  # [V]
STANDS = 0.0, 0.5, -1.8  # [rad]


def main(name: str, rate_hz: float) -> None:
    prepare_environment()
    # Python's own SIGINT, not rclpy's: that ends the context in the middle of a message.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, topic = Node("stranger", start_parameter_services=False), find(f"/{name}")
    publisher = node.create_publisher(message_class(topic), name, qos(topic))
    while not publisher.get_subscription_count():
        time.sleep(0.01)
    print("shouting", flush=True)
    begun, said = time.monotonic(), 0
    while True:
        now = node.get_clock().now().nanoseconds
        if topic == topics.JOY:
            message = message_class(topic)(axes=[0.0] * AXIS_COUNT, buttons=[0] * BUTTON_COUNT)
            message.header.stamp = messages.ns_to_stamp(now)
        elif topic == topics.JOINT_STATES:
            message = message_class(topic)(name=AXES, position=STANDS, velocity=ZERO)
            message.header.stamp = messages.ns_to_stamp(now)
        else:
            message = messages.float_array(topic, now, SHOUTED)
        publisher.publish(message)
        said += 1
        time.sleep(max(0.0, begun + said / rate_hz - time.monotonic()))


if __name__ == "__main__":
    try:
        main(sys.argv[1], float(sys.argv[2]))
    except KeyboardInterrupt:
        sys.exit(0)
