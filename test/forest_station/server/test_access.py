"""Who may open the station: pages of other sites, rebound names and strangers may not."""

import stat

import pytest

from forest_station.server.access import Access, is_loopback, knows_token, objection
from forest_station.server.certificate import CertificateError, own_certificate, self_made_certificate
from forest_station.server.entrance import entrance
from forest_station.server.station_parameters import StationParameters

LOCAL = Access(8080)
BEYOND = Access(8443, "secret", frozenset({"localhost", "cabin"}))


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "[::1]:8080", "127.0.0.9:8080"])
def test_this_computers_own_page_may_come_in(host):
    assert not objection(LOCAL, {"Host": host, "Origin": f"http://{host}"})
    assert not objection(LOCAL, {"Host": host})  # a program, not a page


@pytest.mark.parametrize(
    "host", ["evil.example:8080", "127.0.0.1", "127.0.0.1:80", "192.168.1.5:8080", "", "[::1", "localhost:x"]
)
def test_a_name_that_was_turned_to_this_computer_is_refused(host):
    assert "Host" in objection(LOCAL, {"Host": host})


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "https://127.0.0.1:8080", "http://localhost:8080", "http://127.0.0.1:81"],
)
def test_another_sites_page_is_refused(origin):
    assert "Origin" in objection(LOCAL, {"Host": "127.0.0.1:8080", "Origin": origin})


@pytest.mark.parametrize("host", ["192.168.1.5:8443", "cabin:8443", "[fe80::1]:8443", "localhost:8443"])
def test_beyond_loopback_addresses_and_own_names_are_known(host):
    assert not objection(BEYOND, {"Host": host, "Origin": f"https://{host}"})


@pytest.mark.parametrize("host", ["evil.example:8443", "cabin.evil.example:8443"])
def test_beyond_loopback_a_web_sites_name_is_refused(host):
    assert "Host" in objection(BEYOND, {"Host": host})


def test_the_token_counts_beyond_loopback_only():
    assert knows_token(LOCAL, None)
    assert knows_token(BEYOND, "secret")
    assert not any(knows_token(BEYOND, cookie) for cookie in (None, "", "secre", "secret ", "sécret"))


def test_only_loopback_is_opened_without_a_token(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr("socket.getaddrinfo", lambda *_: [])  # as where somebody is called cabin
    for host in ("127.0.0.1", "localhost", "::1"):
        way = entrance(StationParameters(host=host))
        assert (way.access.token, way.tls, way.notes) == ("", None, ())
    for host in ("0.0.0.0", "192.168.1.5", "::", "cabin"):
        assert not is_loopback(host)
        way = entrance(StationParameters(host=host))
        assert len(way.access.token) >= 32
        assert way.tls is not None
        assert way.address.startswith("https://")
        assert way.address.endswith(f"?token={way.access.token}")
        assert "other computers" in way.notes[0]
        assert "fingerprint" in way.notes[1]


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"host": "nobody.invalid"}, "host 'nobody.invalid': .*; allowed: an address of this computer"),
        (
            {"certificate": "c.pem"},
            "127.0.0.1 is served without TLS; allowed: certificate and key with another",
        ),
        ({"key": "k.pem"}, "127.0.0.1 is served without TLS"),
    ],
)
def test_what_cannot_be_served_is_refused_before_anything_is(given, why):
    with pytest.raises(ValueError, match=why):
        entrance(StationParameters(**given))


def test_a_self_made_certificate_is_kept_and_nobody_else_can_read_its_key(tmp_path):
    _, first = self_made_certificate("192.168.1.5", tmp_path / "kept")
    _, again = self_made_certificate("192.168.1.5", tmp_path / "kept")
    _, other = self_made_certificate("192.168.1.6", tmp_path / "kept")
    assert first == again != other
    modes = {stat.S_IMODE(path.stat().st_mode) for path in (tmp_path / "kept").iterdir()}
    assert modes == {0o600}


def test_a_certificate_of_the_user_needs_its_key(tmp_path):
    self_made_certificate("cabin", tmp_path)
    pair = str(tmp_path / "cabin.pem")
    assert own_certificate(pair, pair)
    for certificate, key in ((pair, ""), ("", pair), (pair, str(tmp_path / "none"))):
        with pytest.raises(CertificateError):
            own_certificate(certificate, key)
    (tmp_path / "garbage").write_text("no PEM")
    with pytest.raises(CertificateError, match="garbage"):
        own_certificate(str(tmp_path / "garbage"), pair)
