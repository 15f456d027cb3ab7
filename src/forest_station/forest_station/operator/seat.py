"""Who drives: one page; the others look on, and ask for the seat.

A page gets the seat when it is free, when the driver hands it over, or when the driver was not
heard for `ABANDONED`.
"""

from typing import NamedTuple

ABANDONED = 2.0  # [s] after which the seat of a silent driver is free for who asks


class Seat(NamedTuple):
    """Who drives, and who would like to."""

    driver: str | None = None  # id of a page
    heard: float = 0.0  # when the driver was last heard [s]
    asking: tuple[str, ...] = ()  # in the order in which they asked


def asked(seat: Seat, page: str, now: float) -> Seat:
    """Return the seat after a page asked for it at a time [s]."""
    if seat.driver == page:
        return seat
    if seat.driver is None or is_abandoned(seat, now):
        return _given(seat, page, now)
    return seat if page in seat.asking else seat._replace(asking=(*seat.asking, page))


def left(seat: Seat, page: str, heir: str | None, now: float) -> Seat:
    """Return the seat after its driver left it to another page, or to nobody (None)."""
    if seat.driver != page:
        return seat
    return seat._replace(driver=None) if heir is None else _given(seat, heir, now)


def gone(seat: Seat, page: str) -> Seat:
    """Return the seat after a page has gone."""
    asking = tuple(one for one in seat.asking if one != page)
    return seat._replace(driver=None if seat.driver == page else seat.driver, asking=asking)


def heard(seat: Seat, now: float) -> Seat:
    """Return the seat after its driver was heard at a time [s]."""
    return seat._replace(heard=now)


def is_abandoned(seat: Seat, now: float) -> bool:
    """Tell whether there is a driver who was not heard for long."""
    return seat.driver is not None and now - seat.heard > ABANDONED


def _given(seat: Seat, page: str, now: float) -> Seat:
    return Seat(page, now, tuple(one for one in seat.asking if one != page))
