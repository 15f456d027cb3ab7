"""What the server's parts share: the graph, the driver's place, the open pages, what they were told."""

import asyncio
import struct
from pathlib import Path
from typing import Any

from forest_station.graph.crane_graph import CraneGraph
from forest_station.graph.node_settings import NODES
from forest_station.graph.service_calls import NoAnswer
from forest_station.operator.cab import Cab
from forest_station.recordings.recordings import Recordings
from forest_station.scene.scene_description import TIP_SPEED
from forest_station.server.driving import Driving
from forest_station.server.outbox import Outbox
from forest_station.server.station_parameters import StationParameters

FRAME_KIND = 2
FRAME_HEAD = struct.Struct("<B3xId")
LINES = ("log", "answer")  # kinds of which the newest does not stand for those before


class Station:
    """The server's state.

    Args:
        graph: of the crane.
        options: of the node.
    """

    def __init__(self, graph: CraneGraph, options: StationParameters) -> None:
        self.graph, self.options = graph, options
        self.recordings = Recordings(Path(options.bags), graph.node.get_namespace(), graph.machine)
        self.pages: dict[str, Outbox] = {}  # of each open page, by its id
        self.cab = Cab(options.deadman_button)
        self.driving = Driving(graph, self.cab, self.tell)
        self._told: dict[str, dict[str, Any]] = {}  # the newest message of each kind
        self._opened = self._frames = 0
        loop = asyncio.get_running_loop()
        graph.tell = lambda kind, content: _ignore(loop.call_soon_threadsafe(self.tell, kind, content))

    def tell(self, kind: str, content: dict[str, Any]) -> None:
        """Send a message to every page; who comes later gets the newest of its kind."""
        if kind in LINES:
            for outbox in self.pages.values():
                outbox.put_line(kind, content)
            return
        self._told[kind] = content
        for page, outbox in self.pages.items():
            outbox.put(kind, _for_page(page, kind, content))

    def open(self) -> str:
        """Take in a page that has come; return its id, by which people call its operator, too."""
        self._opened += 1
        page, outbox = f"operator {self._opened}", Outbox()
        self.pages[page] = outbox
        self._welcome(page)
        for kind, content in self._told.items():
            outbox.put(kind, _for_page(page, kind, content))
        return page

    def close(self, page: str) -> None:
        """Let a page go."""
        del self.pages[page]
        self.driving.gone(page)

    def send_frame(self) -> None:
        """Send what the graph's numbers are to every page."""
        new, values = self.graph.row()
        if new:
            for page in self.pages:
                self._welcome(page)
        self._frames += 1
        head = FRAME_HEAD.pack(FRAME_KIND, self._frames & 0xFFFFFFFF, self.graph.now())
        frame = head + struct.pack(f"<{len(values)}f", *values)
        for outbox in self.pages.values():
            outbox.put_frame(frame)

    def setting(self, node: str, name: str) -> Any:
        """Return a parameter as last told to the pages; None if nobody knows it."""
        told = self._told.get("parameters", {}).get("nodes", {})
        return told.get(node, {}).get(name, {}).get("value")

    async def tell_settings(self, *nodes: str) -> None:
        """Tell every page the parameters of some nodes; without arguments: of all."""
        found = {node: await self._settings_of(node) for node in nodes or NODES}
        known = self._told.get("parameters", {}).get("nodes", {}) | found
        known = {node: told for node, told in known.items() if told}
        if known != self._told.get("parameters", {}).get("nodes"):
            self.tell("parameters", {"nodes": known})

    def walls(self) -> tuple[str, float]:
        """Return which workspace the controller keeps to, and its greatest tip speed [m/s]."""
        told = self._told.get("parameters", {}).get("nodes", {}).get("controller", {})
        values = {name: one["value"] for name, one in told.items()}
        return values.get("workspace", ""), values.get("tip_speed", TIP_SPEED)

    async def _settings_of(self, node: str) -> dict[str, dict[str, Any]]:
        """Return a node's parameters; {} if it is not there."""
        try:
            return await self.graph.settings.read(node)
        except NoAnswer:
            self.graph.settings.forget(node)
            return {}

    def _welcome(self, page: str) -> None:
        outbox = self.pages[page]
        outbox.forget_frame()
        outbox.put("welcome", {"you": page, "signals": list(self.graph.signals.told)})


def _for_page(page: str, kind: str, content: dict[str, Any]) -> dict[str, Any]:
    """Return a message as one page gets it."""
    return content | {"you_drive": content["driver"] == page} if kind == "seat" else content


def _ignore(_handle: Any) -> None:
    """Drop what a call returns that nobody waits for."""
