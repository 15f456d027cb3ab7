"""Lockstep: each node waits for the messages of step k, makes its step, and publishes what others need.

The nodes are those of a live run. The simulator publishes /clock and its sensors of step k, and waits for
the voltages of step k. A recorder waits for all that it records of step k. So no message is early or late,
however busy the computer is, and a run repeats to the last bit.

============  ========================================================================================
symbol        meaning
============  ========================================================================================
k             number of the step, from 1
stamp         k·dt [ns], of every message of step k
announcement  each node's outputs, published before its first step: a recorder waits for all of them
no output     a topic on which a node publishes nothing in step k, as of a dropped sensor sample; a
              message says so, or its subscribers would wait
idle          the same of topics that no node waits for, and of many steps at once
batch         all that a node published in many steps, for the recorder; see `clock.step_batch`
============  ========================================================================================

No message is lost: publishers keep 1000 steps for late subscribers, and no node runs ahead of the others. A
node waits for a message as long as the guard allows [s, wall clock]; then it ends and names the message. In
the first step it waits for 20 s at least: the others may be starting.
"""

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from forest_msgs_py.clock.step_batch import StepBatch
from forest_msgs_py.clock.step_guard import extra_time, timeout_failure
from forest_msgs_py.clock.step_order import TRANSIENT_LOCAL
from forest_msgs_py.clock.step_topics import (
    DEPTH,
    LATE,
    IdleReport,
    StepPublisher,
    StepSubscription,
    is_awaited,
    lockstep_qos,
    no_output,
    no_output_subscription,
    steps_without_output,
)
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.stamps import STAMPED
from forest_msgs_py.interfaces.topics import Topic, message_class
from forest_msgs_py.runtime.node import NodeFailure, publisher
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.packing import pack_clock
from forest_msgs_py.types import NS_PER_S, PERIOD_NS

AHEAD = 400  # steps by which the simulator may be ahead of the recorder
END = "end"  # told instead of topics when the step was the last
START = 20.0  # [s, wall clock] in which a graph starts, on a busy computer, too
LOOK = 0.1  # [s] between looks at whether the node was told to stop


class LockstepClock:
    """The clock of a graph in which each node waits for the others.

    Args:
        node: whose clock it is.
        guard: how long it waits for a message [s, wall clock].
        leads: begin each step, and wait for the answers to the one before.
        steps: after which a leader is done; 0: no end.
        recorded: a leader waits for the recorder, too.
        quiet: steps of which it tells at once what no node waits for; see `IdleReport`, `StepBatch`.
    """

    lockstep = True

    def __init__(
        self,
        node: Node,
        guard: float,
        leads: bool = False,
        steps: int = 0,
        recorded: bool = False,
        quiet: int = 1,
    ) -> None:
        self._node, self._guard, self._leads, self._steps = node, guard, leads, steps
        self._inputs: list[StepSubscription] = []
        self._callbacks: list[tuple[StepSubscription, Callable[[bytes, float], None]]] = []
        self._timers: list[tuple[int, Callable[[], None]]] = []
        self._publishers: list[StepPublisher] = []
        self._transient_local: list[str] = []
        self._step = self._publishing = 0
        self._ended = False
        self._wait_set: Any = None  # made once: that takes longer than waiting
        self._no_output_subscriptions = [no_output_subscription(node, topics.NO_OUTPUT)]
        kind = message_class(topics.NO_OUTPUT)
        self._no_output = node.create_publisher(kind, topics.NO_OUTPUT.name, lockstep_qos())
        self._batch_steps, self._idle, self._batch = quiet, IdleReport(node), StepBatch(node, DEPTH // quiet)
        self._announcements = publisher(node, topics.ANNOUNCEMENT)
        self._clock = self.publisher(topics.CLOCK) if leads else None
        self._recorded = StepSubscription(node, topics.RECORDED) if recorded else None

    def now(self) -> float:
        """The time of the step [s]."""
        return self.stamp() / NS_PER_S

    def stamp(self) -> int:
        """The stamp of the step [ns]."""
        return self._step * PERIOD_NS

    def publisher(self, topic: Topic) -> Any:
        """A publisher that speaks once a step.

        Of a transient-local topic: once, before the first step. Of a type without stamp: whenever it likes.
        """
        if topic.transient_local or topic.type not in STAMPED:
            made = publisher(self._node, topic)
            if topic.transient_local:
                self._transient_local.append(f"{made.topic_name} {topic.type}{TRANSIENT_LOCAL}")
            return made
        note = partial(self._batch.note, len(self._publishers))
        stepping = StepPublisher(self._node, topic, lambda: self._publishing, note)
        self._publishers.append(stepping)
        return stepping

    def polled_subscription(self, topic: Topic, answered: bool = False) -> StepSubscription:
        """Messages of a topic, one of each step.

        Args:
            topic: row of the table.
            answered: what is said in answer to this node; it counts in the next step.
        """
        made = StepSubscription(self._node, topic, LATE if topic.late and answered else int(answered))
        self._inputs.append(made)
        if not is_awaited(topic) and len(self._no_output_subscriptions) == 1:
            self._no_output_subscriptions.append(no_output_subscription(self._node, topics.IDLE))
        return made

    def on(self, topic: Topic, callback: Callable[[bytes, float], None]) -> StepSubscription:
        """Call with the message of each step in which one is said, and the step's time [s]."""
        made = self.polled_subscription(topic)
        self._callbacks.append((made, callback))
        self._inputs.insert(0, self._inputs.pop())  # the last to come: waited for first, most often alone
        return made

    def every(self, period: float, callback: Callable[[], None]) -> None:
        """Call once in a period [s], after the step's message; in each step if the period is shorter."""
        self._timers.append((max(1, round(period * NS_PER_S / PERIOD_NS)), callback))

    def run(self, stopping: threading.Event) -> None:
        """Make step after step until the node stops.

        Raises:
            NodeFailure: a message was waited for longer than the guard allows.
        """
        if not self._inputs:
            self.polled_subscription(topics.CLOCK)
        self._announce()
        try:
            self._step_on(stopping)
        finally:
            self._tell(self._step)  # or what was said in these steps would be missing in the bag

    def _step_on(self, stopping: threading.Event) -> None:
        step, begun = 0, 0.0
        while not (self._steps and step == self._steps):
            if self._clock is not None and step > 0 and not self._gather(step, stopping):
                return
            step += 1
            if self._clock is None and not self._gather(step, stopping):
                return
            self._make(step)
            begun = begun or time.monotonic()
        if self._gather(step, stopping):
            self._tell(step)
            self._no_output.publish(no_output(END, step))
            self._log_speed(step - 1, time.monotonic() - begun)
            stopping.wait()

    def _log_speed(self, steps: int, took: float) -> None:
        """How fast the run was, from the end of its first step [s, wall clock]."""
        factor = steps * PERIOD_NS / NS_PER_S / max(took, 1e-9)
        self._node.get_logger().info(f"{steps} steps in {took:.3g} s: {factor:.2f} times as fast as live")

    def _announce(self) -> None:
        plain = "plain_arrays"
        if self._node.has_parameter(plain) and self._node.get_parameter(plain).value:
            raise NodeFailure(
                f"parameter '{plain}' is true; allowed in lockstep: false, for the stamps' sake"
            )
        outputs = [f"{made.name} {made.type}" for made in self._publishers]
        text = "\n".join([self._node.get_name(), *outputs, *self._transient_local])
        self._announcements.publish(message_class(topics.ANNOUNCEMENT)(data=text))

    def _make(self, step: int) -> None:
        """Make one step, and tell on which topics nothing was said."""
        self._step = self._publishing = step
        if self._clock is not None:
            self._clock.publish(pack_clock(self.stamp()))
        for polled, callback in self._callbacks:
            if arrival := polled.newest():
                callback(*arrival)
        for steps, tick in self._timers:
            if step % steps == 0:
                tick()
        self._publishing = 0
        without_output = [made for made in self._publishers if made.published_step != step]
        if missed := [made.name for made in without_output if made.awaited]:
            self._no_output.publish(no_output(" ".join(missed), step))
        self._idle.note(step, [made.name for made in without_output if not made.awaited])
        for place, made in enumerate(self._publishers):
            if (
                step + place
            ) % self._batch_steps == 0:  # one topic after the other: no step takes much longer
                made.tell()
        if step % self._batch_steps == 0:
            self._idle.tell(step)
            self._batch.tell(step)

    def _tell(self, step: int) -> None:
        """Tell all that nobody waits for, and that nothing was said."""
        for made in self._publishers:
            made.tell()
        self._idle.tell(step)
        self._batch.tell(step)

    def _gather(self, step: int, stopping: threading.Event) -> bool:
        """Wait for all that the node reads of a step; False if it was told to stop meanwhile."""
        stamp, begun = step * PERIOD_NS, time.monotonic()
        for polled in self._inputs:
            if polled is not self._inputs[0]:  # which comes last: the others are there when it is
                polled.collect(stamp)
            while not polled.has(stamp):
                if not self._wait(polled, step, begun, stopping):
                    return False
        for polled in self._inputs:
            polled.turn_to(stamp)
        return self._wait_for_recorder(step, stopping)

    def _wait_for_recorder(self, step: int, stopping: threading.Event) -> bool:
        polled, begun, stamp = self._recorded, time.monotonic(), (step - AHEAD) * PERIOD_NS
        while polled is not None and stamp > 0 and not polled.reached(stamp):
            if not self._wait(polled, step, begun, stopping):
                return False
        return True

    def _wait(self, polled: StepSubscription, step: int, begun: float, stopping: threading.Event) -> bool:
        """Wait until something arrives, and take it; False if the node is told to stop."""
        if self._ended:
            self._tell(self._step)
            stopping.wait()
        if stopping.is_set():
            return False
        waited, guard = time.monotonic() - begun, self._guard if step > 1 else max(self._guard, START)
        if waited > guard and waited > guard + extra_time(polled, self._inputs, step, self._leads):
            raise timeout_failure(polled, self._inputs, step, guard)
        heard = [polled.subscription, *(told.subscription for told in self._no_output_subscriptions)]
        if self._wait_set is None:
            self._wait_set = rclpy_implementation.WaitSet(
                len(heard), 0, 0, 0, 0, 0, self._node.context.handle
            )
        waits = self._wait_set
        waits.clear_entities()
        for subscription in heard:
            waits.add_subscription(subscription.handle)
        waits.wait(int(LOOK * NS_PER_S))  # what came before, and was not taken, ends it at once
        if waits.is_ready("subscription", 0):
            polled.collect(step * PERIOD_NS)
        for place, told in enumerate(self._no_output_subscriptions, start=1):
            if waits.is_ready("subscription", place):
                self._take_no_output(told)
        return True

    def _take_no_output(self, no_output_subscription: PolledSubscription) -> None:
        """Take on which topics nothing was published, and whether the run has ended."""
        for header, _info in no_output_subscription.take():
            self._ended = self._ended or header.frame_id == END
            for name, stamp in steps_without_output(header):
                for polled in self._inputs:
                    if polled.name == name:
                        polled.without_output(stamp)
