"""Plays a bag in lockstep: publishes the messages of step k, and waits for the answers to them.

It stands for the nodes that are absent. Of a bag that was recorded in lockstep it publishes /clock and every
topic that the nodes under test do not publish; steps without a message stay so. The answers are those of the
recorded run, to the last bit, or the nodes are not the same. (`forest-bag play` plays in real time.)
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node

from forest_bag.play.player_parameters import StepPlayerParameters
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.clock.node_clock import node_clock
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.stamps import STAMPED
from forest_msgs_py.interfaces.topics import Topic, find
from forest_msgs_py.runtime.node import NodeFailure, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_msgs_py.types import PERIOD_NS

# /clock is this node's own; several nodes publish diagnostics, among them those under test.
NOT_PLAYED = (topics.CLOCK, topics.DIAGNOSTICS)


class StepPlayerNode(Node):
    """Shell around a bag's reader."""

    def __init__(self) -> None:
        super().__init__("step_player")
        self._node_clock = node_clock(self, leads=True)
        if not self._node_clock.lockstep:
            raise ParameterError("parameter 'lockstep' is false; allowed: true; `forest-bag play` plays live")
        self.run = self._node_clock.run
        path, answers = declare(self, StepPlayerParameters)
        try:
            self._bag = BagReader(Path(path))
        except (BagError, OSError) as error:
            raise ParameterError(f"parameter 'bag': {error}") from error
        rows = {name: find(name) for name in self._bag.channels}
        self._publishers_by_topic = {
            name: self._node_clock.publisher(row)
            for name, row in rows.items()
            if row is not None and _is_played(row, answers)
        }
        unknown = sorted(set(answers) - {row.name for row in rows.values() if row is not None} - {""})
        if unknown:
            raise ParameterError(
                f"parameter 'answers': {', '.join(unknown)} not in the bag; there are {', '.join(rows)}"
            )
        for row in rows.values():
            if row is not None and row.name in answers:
                self._node_clock.polled_subscription(row)
        self._messages: Iterator[RawMessage] = self._bag.messages(list(self._publishers_by_topic))
        self._next: RawMessage | None = next(self._messages, None)
        self._publish_until(0)
        self._node_clock.every(0.0, lambda: self._publish_until(self._node_clock.stamp()))

    def _publish_until(self, stamp: int) -> None:
        """Publish what the bag holds up to a stamp [ns]."""
        while self._next is not None and self._next.log_ns <= stamp:
            if self._next.log_ns % PERIOD_NS:
                raise NodeFailure(
                    f"{self._bag.path} holds a message at {self._next.log_ns} ns; allowed: a bag that was "
                    f"recorded in lockstep, with log times that are multiples of {PERIOD_NS} ns"
                )
            self._publishers_by_topic[self._next.channel.topic].publish(self._next.data)
            self._next = next(self._messages, None)

    def destroy_node(self) -> Any:
        """Let go of the bag, too."""
        self._bag.close()
        return super().destroy_node()


def _is_played(row: Topic, answers: Sequence[str]) -> bool:
    said = row.type in STAMPED or row == topics.ROBOT_DESCRIPTION
    return said and row.name not in answers and row not in NOT_PLAYED


def main() -> None:
    """Run the node until it is told to stop."""
    sys.exit(run_node(StepPlayerNode))


if __name__ == "__main__":
    main()
