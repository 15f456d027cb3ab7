"""What other rooms add to the server: pages, requests, and what runs beside it."""

from collections.abc import Callable, Coroutine, Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from aiohttp import web

from forest_station.server import bag_pages, cycle_pages
from forest_station.server.requests import Request
from forest_station.server.server_state import Station


class Addition(NamedTuple):
    """Of one room."""

    routes: Callable[[Station], Iterable[web.RouteDef]] = lambda _station: ()
    requests: Mapping[str, Request] = MappingProxyType({})
    run: Callable[[Station], Coroutine[None, None, None]] | None = None
    """Runs while the server does, and is cancelled at its end."""


ADDITIONS: tuple[Addition, ...] = (
    Addition(bag_pages.routes, bag_pages.REQUESTS, bag_pages.run),
    Addition(cycle_pages.routes, cycle_pages.REQUESTS),
)
