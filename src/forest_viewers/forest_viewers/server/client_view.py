"""The server and what it offers: a channel for each topic, a service for each service, parameters.

A client that does not read fast enough loses its oldest messages: the server keeps `BACKLOG` of
them for each client, and nobody else waits.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import foxglove
from foxglove import Channel, Context, MessageSchema, Schema, Service, ServiceSchema, StatusLevel
from foxglove.websocket import Capability

from forest_msgs_py.interfaces.definitions import message_definition, service_definitions
from forest_viewers.server.client_requests import ClientRequests, told
from forest_viewers.server.relay import LOOPBACK, Relay

BACKLOG = 4096  # messages to each client: about a second of a whole graph
CDR, ROS2MSG = "cdr", "ros2msg"


class ServerError(Exception):
    """The server cannot start; the text is one sentence."""


class ClientView:
    """What clients see.

    Args:
        requests: takes what they ask for.
        read_only: they may ask for topics and parameters' values only.
    """

    def __init__(self, requests: ClientRequests, read_only: bool) -> None:
        self._requests, self._read_only = requests, read_only
        self._context = Context()
        self._channels: dict[str, Channel] = {}
        self._services: set[str] = set()
        self._wanted: Counter[str] = Counter()
        more = [] if read_only else [Capability.Services, Capability.ClientPublish]
        self._server = foxglove.start_server(
            name="forest crane",
            host=LOOPBACK,
            port=0,
            capabilities=[Capability.Parameters, *more],
            server_listener=requests,
            supported_encodings=[CDR],
            context=self._context,
            message_backlog_size=BACKLOG,
        )

    def open(self, port: int) -> None:
        """Let clients in.

        Args:
            port: on the loopback address; 0: a free one.

        Raises:
            ServerError: the port cannot be had.
        """
        try:
            self._relay = Relay(port, self._server.port)
        except OSError as error:
            raise ServerError(
                f"parameter 'port' is {port}: {error.strerror}; allowed: a free port"
            ) from error

    @property
    def port(self) -> int:
        """The port on which clients are let in."""
        return self._relay.port

    def offer(self, topics: Mapping[str, str]) -> list[str]:
        """Offer these topics and no others.

        Args:
            topics: types by resolved name, like ``sensor_msgs/msg/JointState``.

        Returns:
            Names of the topics whose definition is not installed; clients do not see them.
        """
        for name in self._channels.keys() - topics.keys():
            self._channels.pop(name).close()
        unknown = []
        for name, kind in topics.items():
            if name not in self._channels:
                try:
                    schema = _schema(kind, message_definition(kind))
                except FileNotFoundError:
                    unknown.append(name)
                    continue
                self._channels[name] = Channel(
                    name, schema=schema, message_encoding=CDR, context=self._context
                )
        return unknown

    def offer_services(self, services: Mapping[str, str]) -> None:
        """Offer these services and no others; types by resolved name, like ``std_srvs/srv/Trigger``."""
        if self._read_only:
            return
        if gone := self._services - services.keys():
            self._server.remove_services(sorted(gone))
        new = services.keys() - self._services
        self._server.add_services([self._service(name, services[name]) for name in sorted(new)])
        self._services = set(services)

    def say(self, topic: str, data: bytes, time_ns: int) -> None:
        """Send a message's bytes to the clients that want its topic; `time_ns`: when it was received."""
        channel = self._channels.get(topic)
        if channel is not None:
            channel.log(data, log_time=time_ns)

    def want(self, topic: str) -> None:
        """Count a client that wants a topic."""
        self._wanted[topic] += 1

    def leave(self, topic: str) -> None:
        """Count it no longer."""
        self._wanted[topic] -= 1

    def wanted(self, topic: str) -> bool:
        """Whether a client wants a topic."""
        return self._wanted[topic] > 0

    def tell_parameters(self, values: Mapping[str, Any]) -> None:
        """Tell the clients that want to know them the values of parameters, by `/NODE.NAME`."""
        self._server.publish_parameter_values(told(dict(values), []))

    def warn(self, sentence: str) -> None:
        """Show a sentence to every client; one that is said again takes its own place."""
        self._server.publish_status(sentence, StatusLevel.Warning, sentence)

    def close(self) -> None:
        """Stop serving."""
        self._relay.close()
        self._server.stop()

    def _service(self, name: str, kind: str) -> Service:
        request, response = (
            MessageSchema(encoding=CDR, schema=_schema(f"{kind}_{part}", text))
            for part, text in zip(("Request", "Response"), service_definitions(kind), strict=True)
        )
        schema = ServiceSchema(name=kind, request=request, response=response)
        return Service(name, schema=schema, handler=self._requests.call)


def _schema(name: str, text: str) -> Schema:
    return Schema(name=name, encoding=ROS2MSG, data=text.encode())
