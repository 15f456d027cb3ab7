"""Pages and requests of taught work: the cycles in the node's folder, and what is asked of the node."""

import asyncio
import contextlib
import functools
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from aiohttp import web

from forest_control.config.setting_file import SettingFileError
from forest_control.taught.cycle import Cycle
from forest_control.taught.cycle_file import checked_name, file_of, load_cycle, names, save_cycle
from forest_control.taught.editing import changed, moved, without
from forest_control.taught.taught_work import TEACHES
from forest_station.graph.service_calls import NoAnswer
from forest_station.scene.drawn_cycle import DrawnCycle, drawn_cycle
from forest_station.server.requests import Refused, Request
from forest_station.server.server_state import Station

LONGEST = 60  # letters of a segment's name
DRAWN = 8  # cycles that are kept as they were drawn: to plan one takes a tenth of a second


def routes(station: Station) -> list[web.RouteDef]:
    """Return the pages."""

    @functools.lru_cache(maxsize=DRAWN)
    def drawn(taught: Cycle, walls: str) -> DrawnCycle:
        return drawn_cycle(taught, station.graph.machine, walls)

    def read(name: str, folder: Path) -> DrawnCycle:
        return drawn(load_cycle(name, folder), station.walls()[0])

    async def cycles(_request: web.Request) -> web.StreamResponse:
        with _as_answers():
            folder = await station.graph.cycles.folder()
            found = await asyncio.to_thread(names, folder)
            return web.json_response([{"name": one, "own": file_of(one, folder).exists()} for one in found])

    async def cycle(request: web.Request) -> web.StreamResponse:
        with _as_answers():
            folder = await station.graph.cycles.folder()
            return web.json_response(await asyncio.to_thread(read, request.match_info["name"], folder))

    return [web.get("/cycles.json", cycles), web.get("/cycles/{name}.json", cycle)]


@contextlib.contextmanager
def _as_answers() -> Iterator[None]:
    """Turn what is wrong with a cycle into an answer of the server's."""
    try:
        yield
    except (SettingFileError, NoAnswer) as error:
        raise web.HTTPBadRequest(text=str(error)) from error


async def _teach(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    what, label = arguments.get("what"), arguments.get("label", "")
    if not isinstance(what, str) or what not in TEACHES:
        raise Refused(f"What is {what!r}; allowed: {', '.join(TEACHES)}.")
    if not isinstance(label, str) or not label.isprintable() or len(label) > LONGEST:
        raise Refused(f"Label is {str(label)[:LONGEST]!r}; allowed: at most {LONGEST} letters.")
    return await station.graph.cycles.ask(TEACHES[what], cycle=_name(arguments), label=label.strip())


async def _play(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    walls, _ = station.walls()  # those that the controller keeps to
    return await station.graph.cycles.ask("play", cycle=_name(arguments), workspace=walls)


def _verb(service: str) -> Callable[[Station, str, Mapping[str, Any]], Any]:
    async def ask(station: Station, _page: str, _arguments: Mapping[str, Any]) -> str:
        return await station.graph.cycles.ask(service)

    return ask


async def _change(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    changes = arguments.get("changes")
    if not isinstance(changes, dict):
        raise Refused(f"Changes are {str(changes)[:LONGEST]!r}; allowed: values by their keys.")
    return await _edit(station, arguments, lambda taught, segment: changed(taught, segment, changes))


async def _move(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    by = arguments.get("by")
    if type(by) is not int:
        raise Refused(f"By is {str(by)[:LONGEST]!r}; allowed: a whole number of places.")
    return await _edit(station, arguments, lambda taught, segment: moved(taught, segment, by))


async def _delete(station: Station, _page: str, arguments: Mapping[str, Any]) -> str:
    return await _edit(station, arguments, without)


async def _edit(station: Station, arguments: Mapping[str, Any], edit: Callable[[Cycle, str], Cycle]) -> str:
    """Edit a cycle's file; of a shipped cycle, a copy in the user's folder."""
    name, folder = _name(arguments), await station.graph.cycles.folder()

    def work() -> Path:
        return save_cycle(edit(load_cycle(name, folder), str(arguments.get("segment"))), folder)

    with _as_refusals():
        return f"{name} is changed, in {await asyncio.to_thread(work)}."


def _name(arguments: Mapping[str, Any]) -> str:
    with _as_refusals():
        return checked_name(str(arguments.get("cycle", "")))


@contextlib.contextmanager
def _as_refusals() -> Iterator[None]:
    """Turn what is wrong with a request into a refusal."""
    try:
        yield
    except (SettingFileError, OSError) as error:
        text = str(error)
        raise Refused(f"{text[:1].upper()}{text[1:]}.") from error


REQUESTS: Mapping[str, Request] = {
    "teach": Request(_teach, drivers_only=True),
    "play_cycle": Request(_play, drivers_only=True),
    "resume_cycle": Request(_verb("resume"), drivers_only=True),
    "pause_cycle": Request(_verb("pause")),
    "stop_cycle": Request(_verb("stop")),
    "change_segment": Request(_change, drivers_only=True),
    "move_segment": Request(_move, drivers_only=True),
    "delete_segment": Request(_delete, drivers_only=True),
}
