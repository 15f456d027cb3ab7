"""The server: its pages, who may open them, and what runs while it does."""

import asyncio
import functools
import importlib.resources
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from aiohttp import web

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import NOTHING_TOLD, load_workspace, told
from forest_control.limits.workspace import OPEN
from forest_station.graph.crane_graph import CraneGraph
from forest_station.scene.scene_description import scene_of
from forest_station.scene.scene_elements import Scene
from forest_station.server.access import Access
from forest_station.server.additions import ADDITIONS
from forest_station.server.entrance import Entrance
from forest_station.server.gate import gate
from forest_station.server.page_socket import PageSocket
from forest_station.server.requests import REQUESTS
from forest_station.server.server_state import Station

WEB = Path(str(importlib.resources.files("forest_station") / "web"))
FRAME_PERIOD = 1.0 / 30.0  # [s]
LATENCY_PERIOD = 1.0  # [s]
SETTINGS_PERIOD = 2.0  # [s] in which a parameter that somebody else set is seen
ENDS = 1.0  # [s] for which pages may take leave


async def serve(station: Station, way: Entrance, ended: Callable[[], Awaitable[None]]) -> None:
    """Serve pages until what `ended` returns is done.

    Raises:
        OSError: the port cannot be had.
    """
    requests = dict(REQUESTS)
    for addition in ADDITIONS:
        requests |= addition.requests
    sockets = PageSocket(station, requests)
    runner = web.AppRunner(_app(station, way.access, sockets), access_log=None, shutdown_timeout=ENDS)
    await runner.setup()
    jobs = [station.driving.run(), _frames(station), _latency(station), _settings(station)]
    jobs += [addition.run(station) for addition in ADDITIONS if addition.run is not None]
    tasks = [asyncio.ensure_future(job) for job in jobs]
    try:
        await web.TCPSite(runner, station.options.host, way.access.port, ssl_context=way.tls).start()
        for line in (*way.notes, f"the page is at {way.address}"):
            print(line, flush=True)  # not logged: a token belongs neither on /rosout nor into bags
        await _first_done(asyncio.ensure_future(ended()), *tasks)
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await sockets.close()
        await runner.cleanup()


async def _first_done(*tasks: "asyncio.Future[None]") -> None:
    """Wait for one of them; a job that fails is no station."""
    done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in done:
        task.result()


def _app(station: Station, who: Access, sockets: PageSocket) -> web.Application:
    app = web.Application(middlewares=[gate(who)])
    scene = functools.lru_cache(maxsize=1)(functools.partial(_scene, station.graph))

    async def page(_request: web.Request) -> web.StreamResponse:
        return web.FileResponse(WEB / "index.html")

    async def panels(_request: web.Request) -> web.StreamResponse:
        return web.json_response(_panels())

    async def scene_page(_request: web.Request) -> web.StreamResponse:
        return web.json_response(await asyncio.to_thread(scene, *station.walls()))

    app.router.add_get("/", page)
    app.router.add_get("/panels.json", panels)
    app.router.add_get("/scene.json", scene_page)
    app.router.add_get("/socket", sockets.serve)
    for addition in ADDITIONS:
        app.router.add_routes(addition.routes(station))
    app.router.add_static("/web", WEB)
    return app


def _scene(graph: CraneGraph, walls: str, tip_speed: float) -> Scene:
    """Return the scene with the walls of a name; without them where the file cannot be read here."""
    try:
        workspace, names = load_workspace(walls), told(walls)
    except SettingFileError as error:
        graph.node.get_logger().warning(f"the page shows no walls: {error}")
        workspace, names = OPEN, NOTHING_TOLD
    return scene_of(graph.machine, workspace, tip_speed, names)


def _panels() -> dict[str, list[str]]:
    folder = WEB / "panels"
    return {
        "modules": sorted(path.stem for path in folder.glob("*.js")),
        "styles": sorted(path.stem for path in folder.glob("*.css")),
    }


async def _frames(station: Station) -> None:
    due = time.monotonic()
    while True:
        station.send_frame()
        due = max(due + FRAME_PERIOD, time.monotonic())  # frames that were missed are not made up for
        await asyncio.sleep(due - time.monotonic())


async def _latency(station: Station) -> None:
    while True:
        await asyncio.sleep(LATENCY_PERIOD)
        took = station.graph.latency.told()
        if took is not None and station.cab.seat.driver is not None:
            station.tell("latency", {"server_ms": took})


async def _settings(station: Station) -> None:
    while True:
        await station.tell_settings()
        await asyncio.sleep(SETTINGS_PERIOD)
