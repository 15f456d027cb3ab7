"""Whether more than one publisher talks on a topic, by the numbers that the middleware gives to messages.

Each publisher counts its own messages. Numbers that rise are one publisher's, whatever was lost between them.
A number that continues an earlier one, after another publisher's came between, proves that two talk: no
discovery has to be waited for, and one that is there and silent counts for nothing.

| what comes | numbers | two talk |
|---|---|---|
| one publisher, messages lost | 7 8 12 13 | no |
| a node that was started anew | 7 8 1 2 | no |
| two by turns | 7 1 8 2 | from 8 on |
| one hands over to another, and gets it back after `TOGETHER` | 7 8 1 2 … 9 | no |

Of a middleware that does not count messages nothing is found.
"""

import math
import time
from typing import NamedTuple

TOGETHER = 0.5  # [s] of silence after which a publisher has left the topic to others; chosen
MOST = 4  # publishers that are told apart


class Talker(NamedTuple):
    """A publisher."""

    number: int  # of its newest message
    time: float  # when that was heard [s]


class Talkers(NamedTuple):
    """Who talks, by what was heard so far."""

    heard: tuple[Talker, ...] = ()  # the one heard last stands last
    together: float = -math.inf  # when two were last found to talk by turns [s]


NOBODY = Talkers()


def heard(before: Talkers, number: int | None, now: float) -> Talkers:
    """Take in a message.

    Args:
        before: what was known.
        number: that its publisher gave it; None: the middleware does not count.
        now: when it is heard [s].
    """
    if number is None:
        return before
    there = tuple(talker for talker in before.heard if now - talker.time < TOGETHER)
    below = [talker for talker in reversed(there) if talker.number < number]  # of equals the newest
    same = max(below, key=lambda talker: talker.number, default=None)
    others = tuple(talker for talker in there if talker is not same)
    by_turns = same is not None and same is not there[-1]
    together = now if by_turns else before.together
    return Talkers((*others, Talker(number, now))[-MOST:], together)


def are_several(talkers: Talkers, now: float) -> bool:
    """Tell whether two have talked by turns lately, at a time [s]."""
    return now - talkers.together < TOGETHER


class Publishers:
    """Who publishes a topic, as its messages come."""

    def __init__(self) -> None:
        self._talkers = NOBODY

    def hear(self, info: dict[str, int]) -> None:
        """Take in the middleware's info about a message that came now."""
        self._talkers = heard(self._talkers, info.get("publication_sequence_number"), time.monotonic())

    def are_several(self) -> bool:
        """Tell whether two have published by turns lately."""
        return are_several(self._talkers, time.monotonic())
