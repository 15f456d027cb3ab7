"""How the station is opened: where it listens, with which certificate and token, what is said."""

import ipaddress
import secrets
import socket
import ssl
from typing import NamedTuple

from forest_station.server.access import Access, is_loopback
from forest_station.server.certificate import kept_in, own_certificate, self_made_certificate
from forest_station.server.station_parameters import StationParameters

TOKEN_BYTES = 24
BEYOND = "the station can be opened from other computers: who has this address can drive the crane"


class Entrance(NamedTuple):
    """Of a station."""

    access: Access
    tls: ssl.SSLContext | None
    address: str  # of the page, with the token
    notes: tuple[str, ...] = ()  # for the person who started it


def entrance(p: StationParameters) -> Entrance:
    """Return the entrance that the parameters ask for; beyond loopback it has a token and TLS.

    Raises:
        ValueError: certificate and key cannot be used, or nobody has the host's name.
        OSError: a certificate cannot be kept.
    """
    _require_known(p.host)
    if is_loopback(p.host):
        if p.certificate or p.key:
            raise ValueError(
                f"{p.host} is served without TLS; allowed: certificate and key with another host"
            )
        access = Access(p.port)
        return Entrance(access, None, f"http://{_bracketed(p.host)}:{p.port}/")
    token = secrets.token_urlsafe(TOKEN_BYTES)
    own = socket.gethostname().lower()
    names = {"localhost", own, f"{own}.local", p.host.lower()}
    access = Access(p.port, token, frozenset(names))
    notes: tuple[str, ...] = (BEYOND,)
    if p.certificate or p.key:
        tls = own_certificate(p.certificate, p.key)
    else:
        tls, fingerprint = self_made_certificate(p.host, kept_in())
        notes += (f"the certificate is self-made; its SHA-256 fingerprint is {fingerprint}",)
    return Entrance(access, tls, f"https://{_bracketed(_name(p.host))}:{p.port}/?token={token}", notes)


def _require_known(host: str) -> None:
    try:
        socket.getaddrinfo(host, None)
    except OSError as error:
        raise ValueError(f"host {host!r}: {error.strerror}; allowed: an address of this computer") from error


def _name(host: str) -> str:
    """Return what another computer calls a host that listens."""
    try:
        everywhere = ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return host
    return socket.gethostname() if everywhere else host


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
