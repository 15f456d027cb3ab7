"""The graph as the station sees it: one object for the server's loop.

What nodes say arrives in the executor's thread. It is handed to `tell`, which must be safe to call
from there.
"""

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from forest_description.machine import Machine
from forest_station.graph import cycle_client, stop_button
from forest_station.graph.cycle_client import CycleClient
from forest_station.graph.events import Events
from forest_station.graph.joystick_output import JoystickOutput
from forest_station.graph.latency import Latency
from forest_station.graph.node_settings import NodeSettings
from forest_station.graph.notices import STALE, Notices, PartStatus
from forest_station.graph.service_calls import ServiceCalls
from forest_station.graph.signals import Signals
from forest_station.graph.stop_button import StopButton

STATES = {True: "stopped", False: "ready"}
Tell = Callable[[str, dict[str, Any]], None]  # kind and content of a message of the protocol


class CraneGraph:
    """Signals, joystick, emergency stop, settings and notices of one crane.

    Args:
        node: of the station.
        machine: of the crane.
    """

    def __init__(self, node: Node, machine: Machine) -> None:
        self.node, self.machine = node, machine
        self.calls = ServiceCalls(node)
        self.signals, self.latency = Signals(node, machine), Latency(node)
        self.joystick, self.settings = JoystickOutput(node), NodeSettings(self.calls)
        self.events = Events(node)
        self.stop_button = StopButton(node, self.calls, self._tell_stop)
        self.cycles = CycleClient(self.calls)
        self._notices = Notices(node, self._hear_part, self._hear_log)
        self._prefix = node.get_namespace().strip("/")
        self.tell: Tell = lambda _kind, _content: None

    def now(self) -> float:
        """Return the time of the graph's clock [s]."""
        return float(self.node.get_clock().now().nanoseconds) * 1e-9

    def row(self) -> tuple[bool, list[float]]:
        """Return whether there are new signals, and the value of each; NaN where nothing fresh is known."""
        new = self.signals.read()
        self.latency.read()
        now = time.monotonic()
        self._notices.look(now)
        return new, self.signals.values(now)

    def _hear_part(self, part: PartStatus) -> None:
        node, _, what = part.name.removeprefix(f"{self._prefix}/").partition(": ")
        if part.name.startswith(self._prefix):
            if what == stop_button.PART:
                self._hear_stop(node, part)
            elif (node, what) == (cycle_client.NODE, cycle_client.PART) and self.cycles.hear(part):
                self.tell("taught_work", self.cycles.told)
        self.tell("diagnostics", {"parts": [one._asdict() for one in self._notices.parts.values()]})

    def _hear_stop(self, node: str, part: PartStatus) -> None:
        if part.level == STALE:
            self.stop_button.forget(node)
        else:
            self.stop_button.hear(node, part.values)

    def _hear_log(self, node: str, level: str, text: str) -> None:
        self.tell("log", {"node": node, "level": level, "text": text})

    def _tell_stop(self) -> None:
        sources = [
            {"name": name, "state": STATES[pressed]} for name, pressed in self.stop_button.sources.items()
        ]
        self.tell("emergency_stop", {"active": self.stop_button.active, "sources": sources})
