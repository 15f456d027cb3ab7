"""Requests of a page: whatever is sent, there is an answer with a sentence."""

import asyncio
import json
from types import SimpleNamespace

import pytest
from hypothesis import given
from properties import spoilt

from forest_station.server.requests import REQUESTS, Refused, Request, answered, read_request


def answer(text, table, driver="1"):
    station = SimpleNamespace(cab=SimpleNamespace(seat=SimpleNamespace(driver=driver)))
    return asyncio.run(answered(station, "1", read_request(text), table))


async def _yes(_station, _page, arguments):
    return f"Done: {arguments['what']}."


async def _no(_station, _page, _arguments):
    raise Refused("Not now.")


TABLE = {"yes": Request(_yes), "no": Request(_no), "drive": Request(_yes, drivers_only=True)}


def test_a_request_is_answered_under_its_number():
    assert answer('{"do": "yes", "number": 3, "what": "it"}', TABLE) == {
        "to": 3,
        "ok": True,
        "text": "Done: it.",
    }
    assert answer('{"do": "no", "number": 4}', TABLE) == {"to": 4, "ok": False, "text": "Not now."}


def test_what_only_the_driver_may_do_is_refused_to_others():
    told = answer('{"do": "drive", "number": 1, "what": "it"}', TABLE, driver="2")
    assert not told["ok"]
    assert "seat" in told["text"]
    assert answer('{"do": "drive", "number": 1, "what": "it"}', TABLE)["ok"]


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", '{"do": 3}', '{"do": "fly"}', '{"number": 1}', "[" * 100_000, '"\\ud800"']
)
def test_garbage_is_refused_and_the_allowed_requests_are_named(text):
    told = answer(text, TABLE)
    assert not told["ok"]
    assert "allowed: drive, no, yes" in told["text"]


@given(spoilt(b'{"do": "drive", "number": 3, "what": "it"}'))
def test_whatever_is_said_is_answered_and_moves_nothing_from_a_page_that_looks_on(data):
    told = answer(data.decode("utf-8", "surrogateescape"), TABLE, driver="2")
    assert json.loads(json.dumps(told)) == told
    assert told["ok"] is False
    assert told["text"].endswith((".", "drive, no, yes."))


def test_the_driver_alone_resets_and_sets():
    assert {name for name, one in REQUESTS.items() if one.drivers_only} == {
        "leave_seat",
        "reset_emergency_stop",
        "set_parameter",
        "grapple",
    }
