"""What waits for a slow page is bounded: the newest of each kind."""

import asyncio
import contextlib
import json

from forest_station.server.outbox import Outbox

MOST_LINES = 100


def taken(outbox):
    """Everything that waits."""

    async def take():
        found = []
        with contextlib.suppress(asyncio.TimeoutError):
            while True:
                found.append(await asyncio.wait_for(outbox.take(), 0.01))
        return found

    return asyncio.run(take())


def test_a_page_that_does_not_read_finds_the_newest_of_each_kind():
    outbox = Outbox()
    for k in range(10_000):
        outbox.put_frame(b"%d" % k)
        outbox.put("seat", {"k": k})
        outbox.put("pong", {"number": k})
    found = taken(outbox)
    assert found[0] == b"9999"
    assert [json.loads(text) for text in found[1:]] == [
        {"kind": "seat", "k": 9999},
        {"kind": "pong", "number": 9999},
    ]


def test_answers_are_not_replaced_and_not_kept_without_end():
    outbox = Outbox()
    for k in range(MOST_LINES + 7):
        outbox.put_line("answer", {"to": k})
    assert [json.loads(text)["to"] for text in taken(outbox)] == list(range(7, MOST_LINES + 7))


def test_a_frame_of_other_signals_is_forgotten():
    outbox = Outbox()
    outbox.put_frame(b"old")
    outbox.forget_frame()
    assert taken(outbox) == []
