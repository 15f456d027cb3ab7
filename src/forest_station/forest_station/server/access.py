"""Who may open the station: this computer's own pages, and beyond it who has the token.

| attack | what stops it |
|---|---|
| another web site's page opens our socket or a page | its `Origin` is not ours |
| a name that is turned to point at this computer (DNS rebinding) | `Host` must be an address, or our name |
| somebody else in the network | the token, over TLS |
| a script that got into the page | Content-Security-Policy: only files of the package run |
"""

import hmac
import ipaddress
from collections.abc import Mapping
from typing import NamedTuple
from urllib.parse import urlsplit

COOKIE = "__Host-station"
HEADERS = {
    "Content-Security-Policy": "default-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'; object-src 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-cache",
}


class Access(NamedTuple):
    """How the station is reached."""

    port: int
    token: str = ""  # "": nobody beyond this computer can reach it
    names: frozenset[str] = frozenset({"localhost"})  # of this computer, besides addresses

    @property
    def scheme(self) -> str:
        """Return what the addresses of pages begin with."""
        return "https" if self.token else "http"


def is_loopback(host: str) -> bool:
    """Tell whether only this computer reaches a server that listens on a host."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def objection(access: Access, headers: Mapping[str, str]) -> str:
    """Return what is wrong with where a request goes and comes from, in a sentence; "" for nothing."""
    host = headers.get("Host", "")
    if not _is_ours(access, host):
        return f"Host is {host!r}; allowed: this computer's address or name."
    origin = headers.get("Origin")
    if origin is not None and origin != f"{access.scheme}://{host}":
        return f"Origin is {origin!r}; allowed: the station's own page."
    return ""


def knows_token(access: Access, cookie: str | None) -> bool:
    """Tell whether somebody who shows this may come in."""
    return not access.token or hmac.compare_digest((cookie or "").encode(), access.token.encode())


def _is_ours(access: Access, host: str) -> bool:
    """Tell whether a Host header names this computer: no web site's name can."""
    try:
        parts = urlsplit(f"//{host}")
        name, port = parts.hostname or "", parts.port or {"http": 80, "https": 443}[access.scheme]
    except ValueError:
        return False
    if port != access.port:
        return False
    if not access.token:
        return is_loopback(name)
    return name in access.names or _is_address(name)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
