"""However a page ends, the stop begins within 0.1 s of its last heartbeat and the valves shut 0.25 s later.

The real station, controller, valve driver and simulator; a program stands in for the page.
"""

import asyncio
import contextlib
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from relay import Relay
from stand_in_page import StandInPage, driving, play

PAGE = Path(__file__).resolve().parents[2] / "helpers" / "stand_in_page.py"


async def assert_nothing_moves_until_pressed_anew(crane):
    """A page that comes with the deadman held and a stick away from the centre moves nothing."""
    async with StandInPage(crane.address) as page:
        await page.take_seat()
        crane.ears.forget()
        hands = asyncio.create_task(page.hold())
        await crane.ears.until(lambda: len(crane.ears.joy) > 50)
        hands.cancel()
        assert not any(joy.held for joy in crane.ears.joy)
        assert not any(any(values) for _, values in crane.ears.voltages)


async def let_go(_crane, page, hands):
    hands.cancel()
    await page.send(False, page.stick)


async def close_the_socket(_crane, page, hands):
    hands.cancel()
    await page.socket.close()


async def hang(_crane, _page, hands):
    hands.cancel()


async def send_garbage(_crane, page, hands):
    hands.cancel()
    rng = random.Random(5)
    for size in (0, 1, 47, 48, 49, 5000):
        await page.socket.send_bytes(rng.randbytes(size))
        await page.socket.send_str(rng.randbytes(size).decode("latin-1"))


async def send_too_large(_crane, page, hands):
    hands.cancel()
    await page.socket.send_bytes(bytes(100_000))


async def flood(_crane, page, hands):
    hands.cancel()
    with contextlib.suppress(ConnectionError):
        for _ in range(5000):
            await page.send(True, page.stick)


ENDS = (let_go, close_the_socket, hang, send_garbage, send_too_large, flood)


@pytest.mark.parametrize("end", ENDS, ids=lambda end: end.__name__)
def test_however_a_page_ends_the_crane_stops_in_time(crane, end):
    async def scenario():
        async with driving(crane) as (page, hands):
            stall = crane.stall()
            await end(crane, page, hands)
            await crane.ears.still()
            crane.assert_it_stopped(stall)

    play(scenario())


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_a_page_whose_process_dies_or_freezes_stops_the_crane_in_time(crane, number):
    async def scenario():
        crane.ears.forget()
        process = subprocess.Popen([sys.executable, str(PAGE), crane.address])
        try:
            await crane.ears.moving()
            stall = crane.stall()
            process.send_signal(number)
            await crane.ears.still()
            crane.assert_it_stopped(stall)
            if number == signal.SIGSTOP:
                crane.ears.forget()
                process.send_signal(signal.SIGCONT)  # what it goes on to send moves nothing
                await crane.ears.until(lambda: len(crane.ears.joy) > 50)
                assert not any(joy.held for joy in crane.ears.joy)
        finally:
            process.kill()
            process.wait()
        await crane.ears.until(lambda: True)
        await assert_nothing_moves_until_pressed_anew(crane)

    play(scenario())


def test_a_silently_dead_network_stops_the_crane_in_time(crane):
    async def scenario():
        async with Relay(crane.port) as relay, driving(crane, f"http://127.0.0.1:{relay.port}"):
            stall = crane.stall()
            relay.dead = True
            await crane.ears.still()
            crane.assert_it_stopped(stall)
            crane.ears.forget()
            async with StandInPage(crane.address) as other:  # the seat is abandoned, and has to be asked for
                while not (await other.ask("take_seat"))["text"].startswith("You have"):
                    await asyncio.sleep(0.05)
            assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())


def test_a_network_that_turns_slow_and_delivers_bursts_stops_the_crane_in_time(crane):
    async def scenario():
        async with Relay(crane.port) as relay, driving(crane, f"http://127.0.0.1:{relay.port}"):
            stall = crane.stall()
            relay.open.clear()
            await asyncio.sleep(0.3)
            relay.open.set()  # a burst of all that waited
            relay.delay = 0.3
            await crane.ears.still()
            crane.assert_it_stopped(stall)
            crane.ears.forget()
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())


def test_behind_a_network_that_is_always_slow_nothing_moves(crane):
    async def scenario():
        async with Relay(crane.port) as relay:
            relay.delay = 0.3
            crane.ears.forget()
            host = f"127.0.0.1:{crane.port}"
            async with StandInPage(f"http://127.0.0.1:{relay.port}", host) as page:
                await page.take_seat()
                hands = asyncio.create_task(page.drive())
                await crane.ears.until(lambda: "too late" in page.seat["deadman"]["text"])
                hands.cancel()
            assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())
