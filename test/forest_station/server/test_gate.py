"""Beyond loopback: TLS with a certificate of our own, and a token that is given once and then is a cookie."""

import asyncio
import socket
import ssl

import aiohttp
import pytest
from aiohttp import web

from forest_station.server.access import Access
from forest_station.server.certificate import self_made_certificate
from forest_station.server.gate import gate

TOKEN = "a-token-of-the-test"


@pytest.fixture
def ask(tmp_path):
    """Asks a server beyond loopback; gives status, headers and cookies of each answer."""

    async def page(_request):
        return web.Response(text="the page")

    async def asked(*requests):
        context, _ = self_made_certificate("127.0.0.1", tmp_path)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        app = web.Application(middlewares=[gate(Access(port, TOKEN))])
        app.router.add_get("/", page)
        runner = web.AppRunner(app)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", port, ssl_context=context).start()
        trusted = ssl.create_default_context(cafile=tmp_path / "127.0.0.1.pem")
        found = []
        try:
            jar = aiohttp.CookieJar(unsafe=True)
            async with aiohttp.ClientSession(cookie_jar=jar) as session:
                for path, headers in requests:
                    url = f"https://127.0.0.1:{port}{path}"
                    async with session.get(
                        url, headers=headers, ssl=trusted, allow_redirects=False
                    ) as answer:
                        found.append((answer.status, answer.headers, await answer.text()))
        finally:
            await runner.cleanup()
        return found

    return lambda *requests: asyncio.run(asked(*requests))


def test_without_the_token_nobody_comes_in(ask):
    for status, headers, text in ask(
        ("/", {}), ("/?token=wrong", {}), ("/", {"Cookie": "__Host-station=wrong"})
    ):
        assert status == 401
        assert "the page" not in text
        assert headers["Content-Security-Policy"]


def test_the_token_is_given_once_and_leaves_the_address(ask):
    (first, headers, _), (second, _, text) = ask((f"/?token={TOKEN}", {}), ("/", {}))
    assert (first, headers["Location"]) == (303, "/")
    cookie = headers["Set-Cookie"].lower()
    assert all(word in cookie for word in ("httponly", "secure", "samesite=strict", "path=/"))
    assert (second, text) == (200, "the page")


def test_the_token_does_not_help_another_sites_page(ask):
    (_, _, _), (status, _, _) = ask((f"/?token={TOKEN}", {}), ("/", {"Origin": "https://evil.example"}))
    assert status == 403
