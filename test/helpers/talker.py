"""A node for the tests of the frame: publishes joints at 200 Hz and has last words."""

import ctypes
import gc
import sys
from typing import Annotated, NamedTuple

from rclpy.duration import Duration
from rclpy.node import Node

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.runtime.node import Finished, NodeFailure, publisher, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import Parameter

FAULTS = {"bug": ZeroDivisionError("a bug"), "failure": NodeFailure("pump is gone"), "done": Finished()}


class TalkerParameters(NamedTuple):
    fault: Annotated[str, Parameter("what goes wrong", choices=("", *FAULTS))] = ""
    hangs: Annotated[bool, Parameter("the middleware never lets the node go")] = False
    loop: Annotated[str, Parameter("how a loop of its own ends", choices=("", "wait", "return", *FAULTS))] = (
        ""
    )


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        self.fault, self.hangs, loop = declare(self, TalkerParameters)
        if loop:
            self.run = lambda stopping: self.keep_time(loop, stopping)
        self.joints = publisher(self, topics.JOINT_STATES)
        self.voltages = publisher(self, topics.VALVE_VOLTAGES)
        self.matched = False
        self.create_timer(0.005, self.tick)
        print("up", flush=True)

    def tick(self):
        now = self.get_clock().now().nanoseconds
        self.joints.publish(messages.joint_state(topics.JOINTS, now, (0.1, 0.2, 0.3)))
        if not self.matched and self.voltages.get_subscription_count():
            self.matched = True
            print("matched", flush=True)
        if self.fault == "done":
            print("frozen:", gc.get_freeze_count(), "others:", len(gc.get_objects()), flush=True)
        if self.fault:
            raise FAULTS[self.fault]

    def keep_time(self, end, stopping):
        if end == "wait":
            stopping.wait()
        elif end != "return":
            raise FAULTS[end]
        print("loop ended", flush=True)

    def stop(self):
        self.voltages.publish(messages.float_array(topics.VALVE_VOLTAGES, 0, (0.0, 0.0, 0.0)))
        self.voltages.wait_for_all_acked(Duration(seconds=1))
        print("last words", flush=True)

    def destroy_node(self):
        while self.hangs:
            ctypes.PyDLL(None).pause()  # with the interpreter locked, as rclpy waits in a destructor
        super().destroy_node()


def main():
    sys.exit(run_node(Talker))


if __name__ == "__main__":
    main()
