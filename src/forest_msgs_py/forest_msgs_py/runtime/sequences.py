"""Lost messages, counted from the publication sequence numbers of one topic.

The middleware says a message's number but not whose it is. Publishers count up on their own from 1, so one
"last number heard" per publisher suffices: a message that follows on one of them belongs there.
"""

from collections.abc import Callable


class SequenceGaps:
    """Counts what one subscription missed.

    What was published before the subscription was matched is not lost: a publisher's first number heard
    starts its count.
    """

    def __init__(self) -> None:
        self.lost = 0
        self._last: list[int] = []

    def observe(self, number: int, publishers: Callable[[], int] = lambda: 1) -> int:
        """Take in one message's number.

        Args:
            number: publication sequence number; 0 means that the middleware gives none.
            publishers: how many publishers the topic has had so far; asked only when the number follows on
                none.

        Returns:
            Messages missed just before this one.
        """
        if number <= 0:
            return 0
        if number - 1 in self._last:
            self._last[self._last.index(number - 1)] = number
            return 0
        before = max((last for last in self._last if last < number), default=None)
        if before is None or len(self._last) < publishers():
            self._last.append(number)
            return 0
        self._last[self._last.index(before)] = number
        self.lost += number - before - 1
        return number - before - 1
