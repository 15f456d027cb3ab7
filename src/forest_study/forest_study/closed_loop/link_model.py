"""Transport between nodes: links that delay, jitter and lose messages, repeatably; reports in lockstep.

| symbol | name | unit |
|---|---|---|
| delay | of every message | s |
| jitter | greatest extra delay; each message's is drawn evenly from 0 .. jitter | s |
| loss | probability that a message is lost | 1 |

A message that was overtaken arrives late all the same, as on a network: order is the reader's business.
"""

import heapq
import math
from typing import Annotated, Generic, NamedTuple, TypeVar

import numpy as np

from forest_control.valve.tracking_limit import FULL, STATUS_EVERY, OpeningRatio
from forest_msgs_py.runtime.parameter_table import Parameter, table_rows

T = TypeVar("T")
LONGEST = 60.0  # [s]


class LinkError(ValueError):
    """A link's quality is not allowed; the message says what is."""


class DelayParameters(NamedTuple):
    """Of `delay_node`, beside the link's quality."""

    topic_in: Annotated[str, Parameter("topic to subscribe to")] = "joy"
    topic_out: Annotated[str, Parameter("topic to publish")] = "joy_late"
    seed: Annotated[int, Parameter("seed of jitter and losses", low=0)] = 0


class Quality(NamedTuple):
    """How bad a link is."""

    delay: Annotated[float, Parameter("delay of every message", "s", 0.0, LONGEST)] = 0.0
    jitter: Annotated[float, Parameter("largest extra delay, uniformly drawn", "s", 0.0, LONGEST)] = 0.0
    loss: Annotated[float, Parameter("probability that a message is lost", "", 0.0, 1.0)] = 0.0

    def checked(self) -> "Quality":
        """Return itself.

        Raises:
            LinkError: a delay or jitter is negative or longer than a minute, or the loss is not 0..1.
        """
        for value, row in zip(self, table_rows(Quality), strict=True):
            assert row.high is not None
            if not (math.isfinite(value) and 0.0 <= value <= row.high):
                raise LinkError(f"{row.name} is {value!r}; allowed: 0 .. {row.high:g}")
        return self


class Link(Generic[T]):
    """Messages under way.

    Args:
        quality: of the link.
        seed: of its jitter and losses.

    Raises:
        LinkError: as `Quality.checked`.
    """

    def __init__(self, quality: Quality, seed: int = 0) -> None:
        self._quality, self._rng = quality.checked(), np.random.default_rng(seed)
        self._under_way: list[tuple[float, int, T]] = []
        self._sent = 0

    def send(self, now: float, message: T) -> None:
        """Put a message on its way at a time [s]."""
        lost, extra, q = False, 0.0, self._quality
        if q.loss > 0.0 or q.jitter > 0.0:  # a draw takes longer than all the rest
            lost, extra = self._rng.random() < q.loss, self._rng.random() * q.jitter
        self._sent += 1
        if not lost:
            heapq.heappush(self._under_way, (now + q.delay + extra, self._sent, message))

    def arrived(self, now: float) -> list[T]:
        """Return what has arrived by a time [s], in the order of arrival."""
        messages = []
        while self._under_way and self._under_way[0][0] <= now + 1e-9:
            messages.append(heapq.heappop(self._under_way)[2])
        return messages


class Reports(NamedTuple):
    """What the driver has said of its valves' openings, as a controller hears it in lockstep."""

    heard: OpeningRatio = FULL  # that the controller has
    older: OpeningRatio = FULL  # said, on the way
    newer: OpeningRatio = FULL
    step: int = 0  # of the driver


def reported(r: Reports, now: OpeningRatio) -> Reports:
    """Return the reports after another step of the driver, by which its valves open so far.

    It says it every `STATUS_EVERY` steps, and in lockstep two such spans later that is heard.
    """
    step = (r.step + 1) % STATUS_EVERY
    if step == 1:
        return Reports(r.heard, r.older, now, step)
    if step == 0:
        return Reports(r.older, r.newer, r.newer, step)
    return r._replace(step=step)
