"""A joystick without hands: the thesis' test input, a person's recorded levers, or a bag's joystick on /joy.

It waits until somebody listens, rests for a moment, plays with the deadman held, lets it go, and ends. A
bag's messages are said again as they are, under new stamps. `faults` go wrong at set times.
"""

import math
import sys
from pathlib import Path
from typing import NamedTuple

from rclpy.node import Node
from rclpy.serialization import deserialize_message

from forest_control.operator.joystick_bag import JoyRecord, is_bag, read_joy_record
from forest_control.operator.joystick_fault_injection import (
    BAD,
    FROZEN,
    LOST,
    RELEASED,
    JoystickFault,
    faults_at,
    parse_joystick_faults,
)
from forest_control.operator.joystick_sources import (
    LEAD_IN,
    LEAD_OUT,
    THESIS_DURATION,
    JoystickParameters,
    LeverRecord,
    read_levers,
    thesis_levers,
)
from forest_control.operator.joystick_watch import HEARTBEAT
from forest_control.operator.levers import BUTTON_COUNT, REST, Levers, axes_from_levers
from forest_msgs_py.clock.node_clock import node_clock, publishes_bytes
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topics import JOY_RATE_HZ, message_class
from forest_msgs_py.runtime.node import Finished, run_node
from forest_msgs_py.runtime.node_parameters import declare
from forest_msgs_py.runtime.parameter_table import ParameterError
from forest_msgs_py.serialization.packing import pack_joy
from forest_msgs_py.types import NS_PER_S


class Said(NamedTuple):
    """A message without its stamp."""

    frame: str
    joy: JoyValues


class JoystickNode(Node):
    """Shell around `sources`, `joystick_bag` and `joystick_faults`."""

    def __init__(self) -> None:
        super().__init__("joystick")
        self._node_clock = node_clock(self)
        self.run = self._node_clock.run
        p = declare(self, JoystickParameters)
        self._p = p
        self._faults = _faults(p.faults)
        self._record: LeverRecord | JoyRecord | None = (
            None if p.source == "thesis" else _record(Path(p.source), p.interpolate)
        )
        self._length = p.duration or _length(self._record)
        self._publisher = self._node_clock.publisher(topics.JOY)
        self._publish = publishes_bytes(self._publisher)
        self._begun: float | None = None
        self._count = 0
        self._last: Said | None = None
        self._place = -1  # in the bag, of the last message said
        # In lockstep it answers every step.
        self._node_clock.every(0.0 if self._node_clock.lockstep else 1.0 / JOY_RATE_HZ, self._on_timer)

    def _on_timer(self) -> None:
        if self._begun is None:
            if (
                not self._node_clock.lockstep
                and self._publisher.get_subscription_count() < self._p.wait_for_subscribers
            ):
                return
            # Before the beginning: a process' first line takes a tenth of a second on a busy computer.
            self.get_logger().info(f"playing for {self._length:g} s")
            self._begun = self._node_clock.now()
        elapsed = self._node_clock.now() - self._begun
        if isinstance(self._record, JoyRecord):
            message, over = self._replayed(self._record, elapsed), elapsed > self._length
        else:
            played = elapsed - LEAD_IN
            message = self._made(self._levers(played), played < self._length)
            over = played >= self._length + LEAD_OUT
        if over and not self._node_clock.lockstep:  # there, the machine knows when the run is over
            raise Finished
        self._say(message, faults_at(self._faults, elapsed))

    def _levers(self, played: float) -> Levers:
        if not 0.0 <= played < self._length:
            return REST
        if isinstance(self._record, LeverRecord):
            return self._record.at(played)
        return thesis_levers(played, self._p.tip_speed)

    def _made(self, levers: Levers, held: bool) -> Said:
        self._count += 1  # a script may hold still for ever: the controller sees by this that it lives
        buttons = tuple(int(held and place == self._p.deadman_button) for place in range(BUTTON_COUNT))
        return Said(f"{HEARTBEAT}{self._count}", JoyValues(axes_from_levers(levers), buttons))

    def _replayed(self, record: JoyRecord, elapsed: float) -> Said | None:
        """Return the bag's message of this time, or None if it has been said."""
        place = record.newest(round(elapsed * NS_PER_S))
        if place == self._place:
            return None
        self._place = place
        message = deserialize_message(record.messages[place], message_class(topics.JOY))
        return Said(message.header.frame_id, JoyValues(tuple(message.axes), tuple(message.buttons)))

    def _say(self, said: Said | None, faults: frozenset[str]) -> None:
        """Publish a message, or what a faulty joystick makes of it."""
        if FROZEN in faults and self._last is not None:
            said = self._last
        if said is None or LOST in faults:
            return
        axes, buttons = said.joy
        if RELEASED in faults:
            buttons = tuple(
                0 if place == self._p.deadman_button else down for place, down in enumerate(buttons)
            )
        if BAD in faults:
            axes = (math.nan,) * len(axes)
        self._last = Said(said.frame, JoyValues(axes, buttons))
        self._publish(pack_joy(self._node_clock.stamp(), *self._last))

    def stop(self) -> None:
        """Last words: deadman released."""
        self._say(self._made(REST, False), frozenset())


def _faults(text: str) -> tuple[JoystickFault, ...]:
    try:
        return parse_joystick_faults(text)
    except ValueError as error:
        raise ParameterError(f"parameter 'faults': {error}") from error


def _record(path: Path, interpolate: bool) -> LeverRecord | JoyRecord:
    """Read a CSV of levers, or a bag."""
    return read_joy_record(path) if is_bag(path) else read_levers(path)._replace(interpolated=interpolate)


def _length(record: LeverRecord | JoyRecord | None) -> float:
    """Return how long a source is [s]."""
    if record is None:
        return THESIS_DURATION
    return record.length if isinstance(record, JoyRecord) else record.times[-1]


def main() -> None:
    """Run the node until it has played, or is told to stop."""
    sys.exit(run_node(JoystickNode))


if __name__ == "__main__":
    main()
