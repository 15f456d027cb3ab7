"""Lets in only whom `access` admits, and sends the headers that protect a page with every answer."""

from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import web

from forest_station.server import access
from forest_station.server.access import COOKIE, HEADERS, Access

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def gate(who: Access) -> Any:
    """Return the middleware that lets nobody in whom `access` refuses, and sends the headers with all."""

    @web.middleware
    async def admit(request: web.Request, handler: Handler) -> web.StreamResponse:
        try:
            response = await _admitted(who, request, handler)
        except web.HTTPException as error:
            error.headers.update(HEADERS)
            raise
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    return admit


async def _admitted(who: Access, request: web.Request, handler: Handler) -> web.StreamResponse:
    if problem := access.objection(who, request.headers):
        raise web.HTTPForbidden(text=problem)
    given = request.query.get("token")
    if given is not None and who.token and access.knows_token(who, given):
        answer = web.HTTPSeeOther(request.path)
        answer.set_cookie(COOKIE, given, path="/", secure=True, httponly=True, samesite="Strict")
        raise answer
    if not access.knows_token(who, request.cookies.get(COOKIE)):
        raise web.HTTPUnauthorized(text="The token is missing: open the address that the station printed.")
    return await handler(request)
