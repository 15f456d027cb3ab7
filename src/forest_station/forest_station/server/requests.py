"""Requests of a page: the table of what can be asked, and who may ask it.

A room that answers more of them adds its own table, see `additions`.
"""

import json
from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from forest_station.graph.node_settings import NODES
from forest_station.graph.service_calls import NoAnswer
from forest_station.server.driving import STOPPED

if TYPE_CHECKING:
    from forest_station.server.server_state import Station


GRAPPLE = ("grasp", "drop")
"""What the simulated head may be told to do."""


class Refused(Exception):
    """A request is refused; the text is a sentence for the person who asked."""


class Request(NamedTuple):
    """How a request is answered."""

    act: Callable[["Station", str, Mapping[str, Any]], Awaitable[str]]
    """Takes the server, the page's id and the arguments; returns a sentence, or raises `Refused`."""
    drivers_only: bool = False


class Question(NamedTuple):
    """A request as a page puts it."""

    what: str
    number: int | None
    arguments: Mapping[str, Any]


def read_request(text: str) -> Question:
    """Return a request; one that cannot be read asks for nothing that there is."""
    try:
        told = json.loads(text)
    except (ValueError, RecursionError):
        told = None
    if not isinstance(told, dict):
        return Question("", None, {})
    what, number = told.get("do"), told.get("number")
    return Question(what if isinstance(what, str) else "", number if type(number) is int else None, told)


async def answered(
    station: "Station", page: str, question: Question, table: Mapping[str, Request]
) -> dict[str, Any]:
    """Return the answer to a request: `to`, `ok`, `text`."""
    request = table.get(question.what)
    ok, text = False, f"Request is {question.what[:40]!r}; allowed: {', '.join(sorted(table))}."
    if request is not None and request.drivers_only and station.cab.seat.driver != page:
        text = "Only the driver may do this: take the seat first."
    elif request is not None:
        try:
            ok, text = True, await request.act(station, page, question.arguments)
        except (Refused, NoAnswer) as error:
            ok, text = False, str(error)
    return {"to": question.number, "ok": ok, "text": text}


async def _take_seat(station: "Station", page: str, _arguments: Mapping[str, Any]) -> str:
    rivals = station.graph.joystick.rivals()
    if rivals:
        raise Refused(f"Another node publishes /joy: {', '.join(rivals)}. Stop it first.")
    if station.driving.take(page):
        return "You have the seat."
    return "The driver is asked."


async def _leave_seat(station: "Station", page: str, arguments: Mapping[str, Any]) -> str:
    heir = arguments.get("to")
    if heir is not None and heir not in station.pages:
        raise Refused(f"Page is {heir!r}; allowed: the id of a page that is open.")
    station.driving.leave(page, heir)
    return "The seat is free." if heir is None else f"Page {heir} has the seat."


async def _emergency_stop(station: "Station", _page: str, _arguments: Mapping[str, Any]) -> str:
    station.driving.stop(STOPPED)
    return station.graph.stop_button.press()


async def _reset_emergency_stop(station: "Station", _page: str, _arguments: Mapping[str, Any]) -> str:
    return await station.graph.stop_button.reset()


async def _set_parameter(station: "Station", _page: str, arguments: Mapping[str, Any]) -> str:
    node, name = arguments.get("node"), arguments.get("name")
    if node not in NODES or not isinstance(name, str):
        raise Refused(f"Parameter is {name!r} of {node!r}; allowed: a name, of {', '.join(NODES)}.")
    text = await station.graph.settings.set(node, name, arguments.get("value"))
    await station.tell_settings(node)
    return text


async def _grapple(station: "Station", _page: str, arguments: Mapping[str, Any]) -> str:
    act = arguments.get("act")
    if act not in GRAPPLE:
        raise Refused(f"Act is {act!r}; allowed: {' or '.join(GRAPPLE)}.")
    said = await station.graph.calls.trigger(f"simulator/{act}", once=True)
    return said[0].upper() + said[1:]


REQUESTS: Mapping[str, Request] = {
    "take_seat": Request(_take_seat),
    "leave_seat": Request(_leave_seat, drivers_only=True),
    "emergency_stop": Request(_emergency_stop),
    "reset_emergency_stop": Request(_reset_emergency_stop, drivers_only=True),
    "set_parameter": Request(_set_parameter, drivers_only=True),
    "grapple": Request(_grapple, drivers_only=True),
}
