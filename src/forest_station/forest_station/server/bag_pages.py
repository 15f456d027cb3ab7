"""Pages and requests of the bags: the list, a bag's frames, and the recorder."""

import asyncio
import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

from aiohttp import web

from forest_bag.storage.bag_files import BagError
from forest_station.server.requests import Refused, Request
from forest_station.server.server_state import Station

PERIOD = 1.0  # [s] between two words on how a recording is going
LONGEST_MARK = 200  # letters
BINARY = "application/octet-stream"


def routes(station: Station) -> list[web.RouteDef]:
    """Return the pages; a bag's name may have slashes in it."""

    async def bags(_request: web.Request) -> web.StreamResponse:
        entries = await asyncio.to_thread(station.recordings.bags.entries)
        return web.json_response([entry._asdict() for entry in entries])

    async def bag(request: web.Request) -> web.StreamResponse:
        with _as_answers():
            path = station.recordings.bags.existing(request.match_info["name"])
            return web.json_response(await station.recordings.replays.describe(path))

    async def frames(request: web.Request) -> web.StreamResponse:
        with _as_answers():
            path = station.recordings.bags.existing(request.match_info["name"])
            start, end, rate = (_number(request.query, key) for key in ("start", "end", "rate"))
            data = await station.recordings.replays.frames(path, start, end, rate)
            return web.Response(body=data, content_type=BINARY)

    return [
        web.get("/bags.json", bags),
        web.get("/bags/{name:.+}/frames", frames),
        web.get("/bags/{name:.+}.json", bag),
    ]


async def run(station: Station) -> None:
    """Tell how the recording is going; end it with the server."""
    try:
        while True:
            _tell(station)
            await asyncio.sleep(PERIOD)
    finally:
        await station.recordings.close()


@contextlib.contextmanager
def _as_answers() -> Iterator[None]:
    """Turn what is wrong with a bag into an answer of the server's."""
    try:
        yield
    except BagError as error:
        raise web.HTTPBadRequest(text=str(error)) from error


@contextlib.contextmanager
def _as_refusals() -> Iterator[None]:
    """Turn what is wrong with a request into a refusal."""
    try:
        yield
    except (BagError, OSError) as error:
        text = str(error)
        raise Refused(f"{text[:1].upper()}{text[1:]}.") from error


def _number(query: Mapping[str, str], key: str) -> float:
    try:
        return float(query[key])
    except (KeyError, ValueError):
        raise BagError(f"{key} is {query.get(key)!r}; allowed: a number") from None


def _tell(station: Station) -> None:
    state = station.recordings.recorder.state()
    station.tell("recording", {**state._asdict(), "hears": station.graph.events.heard()})


async def _start(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    name = arguments.get("name")
    if name is not None and not isinstance(name, str):
        raise Refused(f"Name is {name!r}; allowed: a text, or none.")
    with _as_refusals():
        text = await station.recordings.recorder.start(name)
    _tell(station)
    return text


async def _stop(station: Station, _page: str, _arguments: Mapping[str, Any]) -> str:
    with _as_refusals():
        text = await station.recordings.recorder.stop()
    _tell(station)
    return text


async def _mark(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    text = arguments.get("text")
    if not (isinstance(text, str) and 0 < len(text) <= LONGEST_MARK and text.isprintable()):
        raise Refused(f"Text is {str(text)[:LONGEST_MARK]!r}; allowed: 1 to {LONGEST_MARK} letters.")
    if not await station.graph.events.say(text):
        raise Refused("No recorder hears /events: start a recording first.")
    return f"Marked: {text}"


REQUESTS: Mapping[str, Request] = {
    "start_recording": Request(_start),
    "stop_recording": Request(_stop),
    "mark": Request(_mark),
}
