"""Whether a message is newer than those before it: what overtook it must not be undone.

When nothing in order has come for the reader's patience, the sender's time may begin anew with a stamp that
goes back: it was started again, or its clock was set. What rises from there on is in order.
"""

import math
from typing import NamedTuple

NO_STAMP = 0  # [ns]


class StampOrder(NamedTuple):
    """What is remembered of a topic's messages."""

    newest: int = NO_STAMP  # [ns] stamp of the newest
    accepted: float = -math.inf  # [s] local time at which it came; -inf: none has


FIRST = StampOrder()


def is_in_order(order: StampOrder, stamp_ns: int) -> bool:
    """Tell whether a message is in order: without stamp (`NO_STAMP`), the first, or newer than the newest."""
    return stamp_ns == NO_STAMP or order.accepted == -math.inf or stamp_ns > order.newest


def updated_order(order: StampOrder, stamp_ns: int, now: float, patience: float) -> StampOrder:
    """Return what is remembered after a message.

    Args:
        order: before it.
        stamp_ns: the message's.
        now: local monotonic time [s].
        patience: time [s] without a message in order after which stamps may begin anew.
    """
    if stamp_ns == NO_STAMP or stamp_ns == order.newest:
        return order
    begins_anew = now - order.accepted > patience
    return StampOrder(stamp_ns, now) if stamp_ns > order.newest or begins_anew else order


def disorder(order: StampOrder, name: str, stamp_ns: int) -> str:
    """Return what is wrong with the stamp of a topic's message, or ""."""
    if is_in_order(order, stamp_ns):
        return ""
    back = (order.newest - stamp_ns) * 1e-9
    went = f"goes back by {back:g} s" if back > 0.0 else "stands still"
    return f"{name}: the stamp {went}; allowed: rising stamps, or none"
