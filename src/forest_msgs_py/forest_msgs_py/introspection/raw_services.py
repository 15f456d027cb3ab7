"""Services of a graph, called with requests as bytes, whoever offers them and whatever their type."""

import importlib
from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.serialization import deserialize_message, serialize_message

from forest_msgs_py.serialization.cdr import ENCAPSULATION

OF_EVERY_NODE = ("rcl_interfaces/", "type_description_interfaces/")
"""Packages of the services by which each node tells its parameters and types."""


class RawServices:
    """Finds and calls services; all in the thread of the node's executor.

    Args:
        node: that calls.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, tuple[Any, Any]] = {}  # client, and the class of the service

    def look(self) -> dict[str, str]:
        """Return names and types of the services that can be called; those of every node are left out."""
        found = {}
        for name, types in self._node.get_service_names_and_types():
            hidden = any(part.startswith("_") for part in name.split("/"))
            if hidden or len(types) != 1 or types[0].startswith(OF_EVERY_NODE):
                continue
            if name in self._clients or self._connect(name, types[0]):
                found[name] = types[0]
        for name in self._clients.keys() - found.keys():
            self._node.destroy_client(self._clients.pop(name)[0])
        return found

    def call(
        self, name: str, request: bytes, answered: Callable[[bytes], object], failed: Callable[[str], object]
    ) -> None:
        """Call a service that was found.

        Args:
            name: of the service.
            request: its bytes.
            answered: called with the answer's bytes.
            failed: called with one sentence instead.
        """
        client, kind = self._clients.get(name, (None, None))
        if client is None or not client.service_is_ready():
            failed(f"nobody offers {name}")
            return
        if len(request) == len(ENCAPSULATION):
            request += b"\0"  # ROS puts a byte into a request without fields
        try:
            message = deserialize_message(request, kind.Request)
        except Exception:  # noqa: BLE001  rclpy says so with whatever its middleware raises
            failed(f"{name}: bytes that are no request of {kind.__name__}")
            return
        client.call_async(message).add_done_callback(
            lambda future: answered(serialize_message(future.result()))
        )

    def _connect(self, name: str, type_name: str) -> bool:
        package, _, service = type_name.split("/")
        try:
            kind = getattr(importlib.import_module(f"{package}.srv"), service)
        except (ImportError, AttributeError):
            return False
        self._clients[name] = self._node.create_client(kind, name), kind
        return True
