"""Services of the graph, asked from the server's loop: the answer comes in the executor's thread."""

import asyncio
import time
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

PATIENCE = 3.0  # [s] for a service to be found, and to answer
AGAIN = 0.5  # [s] after which a question without an answer is put once more
POLL = 0.02  # [s]


class NoAnswer(Exception):
    """A service is not there, or does not answer; the text is one sentence."""


class ServiceCalls:
    """Calls services of one namespace.

    Args:
        node: that asks.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Any] = {}

    async def call(self, kind: Any, name: str, request: Any, once: bool = False) -> Any:
        """Return a service's answer.

        Args:
            kind: class of the service.
            name: of the service, in the node's namespace.
            request: what is asked.
            once: the question must not be put again where no answer comes, which may have been lost.

        Raises:
            NoAnswer: nobody offers the service, or it does not answer.
        """
        client = self._clients.get(name)
        if client is None:
            client = self._clients[name] = self._node.create_client(kind, name)
        end = time.monotonic() + PATIENCE
        while not client.service_is_ready():
            if time.monotonic() > end:
                raise NoAnswer(f"Nobody offers {name}.")
            await asyncio.sleep(POLL)
        answered: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        for _ in range(1 if once else round(PATIENCE / AGAIN)):
            _answer_to(client.call_async(request), answered)
            done, _ = await asyncio.wait([answered], timeout=PATIENCE if once else AGAIN)
            if done:
                return answered.result()
        raise NoAnswer(f"{name} did not answer within {PATIENCE:g} s.")

    async def trigger(self, name: str, once: bool = False) -> str:
        """Call a service that takes no arguments; return what it says, in a sentence.

        Args:
            name: of the service, in the node's namespace.
            once: as in `call`.

        Raises:
            NoAnswer: nobody offers the service, it does not answer, or it refuses.
        """
        answer = await self.call(Trigger, name, Trigger.Request(), once)
        if not answer.success:
            raise NoAnswer(f"{answer.message}.")
        return f"{answer.message}."


def _answer_to(asked: Any, answered: "asyncio.Future[Any]") -> None:
    """Hand an answer from the executor's thread to the loop; the first one counts."""
    loop = answered.get_loop()

    def settle(result: Any, error: BaseException | None) -> None:
        if answered.done():
            return
        if error is not None:
            answered.set_exception(error)
        else:
            answered.set_result(result)

    def done(future: Any) -> None:
        error = future.exception()
        loop.call_soon_threadsafe(settle, None if error else future.result(), error)

    asked.add_done_callback(done)
