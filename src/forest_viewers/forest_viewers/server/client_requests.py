"""What clients ask for, handed from the server's threads to the node's.

The server calls a `ClientRequests` in threads of its own, one of which serves all clients. So
nothing here waits, but for a service's answer, for which the server has a thread apart.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from queue import SimpleQueue
from typing import Any, NamedTuple

from foxglove import Parameter, ServiceRequest
from foxglove.websocket import ChannelView, Client, ClientChannel, ServerListener

PATIENCE = 10.0  # [s] for a service to answer


class Subscribed(NamedTuple):
    """A client wants a topic."""

    topic: str


class Unsubscribed(NamedTuple):
    """A client does not want a topic any more, or is gone."""

    topic: str


class Published(NamedTuple):
    """A client's message."""

    topic: str
    data: bytes


class ParametersSet(NamedTuple):
    """Parameters that a client sets, by `/NODE.NAME`."""

    values: dict[str, Any]


class ServiceCalled(NamedTuple):
    """A service call; the answer's bytes, or a sentence, go into the future."""

    name: str
    request: bytes
    answer: Future[bytes]

    def fail(self, sentence: str) -> None:
        """Tell the client why there is no answer."""
        self.answer.set_exception(CallFailed(sentence))


Request = Subscribed | Unsubscribed | Published | ParametersSet | ServiceCalled


class CallFailed(Exception):
    """A service call that came to nothing; the text is one sentence, which the client gets."""


class ClientRequests(ServerListener):
    """Queues requests; answers those for parameters' values itself.

    Args:
        values: gives all parameters as they are, by `/NODE.NAME`; called in the server's threads.
    """

    def __init__(self, values: Callable[[], dict[str, Any]]) -> None:
        self._values = values
        self._waiting: SimpleQueue[Request] = SimpleQueue()
        self._published: dict[tuple[int, int], ClientChannel] = {}

    def taken(self) -> list[Request]:
        """Return what was asked since the last time."""
        return [self._waiting.get_nowait() for _ in range(self._waiting.qsize())]

    def call(self, request: ServiceRequest) -> bytes:
        """Call a service and wait for its answer.

        Raises:
            CallFailed: it was refused, or nothing came.
        """
        answer: Future[bytes] = Future()
        self._waiting.put(ServiceCalled(request.service_name, request.payload, answer))
        try:
            return answer.result(PATIENCE)
        except FutureTimeoutError:
            raise CallFailed(f"{request.service_name} did not answer within {PATIENCE:g} s") from None

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        """Queue it."""
        self._waiting.put(Subscribed(channel.topic))

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        """Queue it."""
        self._waiting.put(Unsubscribed(channel.topic))

    def on_client_advertise(self, client: Client, channel: ClientChannel) -> None:
        """Remember what the client's messages on this channel are."""
        self._published[client.id, channel.id] = channel

    def on_client_unadvertise(self, client: Client, client_channel_id: int) -> None:
        """Forget the channel."""
        self._published.pop((client.id, client_channel_id), None)

    def on_message_data(self, client: Client, client_channel_id: int, data: bytes) -> None:
        """Queue it."""
        channel = self._published.get((client.id, client_channel_id))
        if channel is not None:
            self._waiting.put(Published(channel.topic, bytes(data)))

    def on_get_parameters(
        self,
        client: Client,  # noqa: ARG002
        param_names: list[str],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[Parameter]:
        """Return the parameters of these names; all of them if there are no names."""
        return told(self._values(), param_names)

    def on_set_parameters(
        self,
        client: Client,  # noqa: ARG002
        parameters: list[Parameter],
        request_id: str | None = None,  # noqa: ARG002
    ) -> list[Parameter]:
        """Queue it; return the values as they are. Those that are set are told when the node has set them."""
        given = {one.name: one.get_value() for one in parameters}
        self._waiting.put(ParametersSet(given))
        return told(self._values(), list(given))


def told(values: dict[str, Any], names: list[str]) -> list[Parameter]:
    """Return parameters as clients get them.

    Args:
        values: by `/NODE.NAME`.
        names: which; none: all.
    """
    return [Parameter(name, value=values[name]) for name in names or values if name in values]
