"""However a page ends, the stop begins within 0.1 s of its last heartbeat and the valves shut 0.25 s later.

The real station, controller, valve driver and simulator; a program stands in for the page.
"""

import asyncio
import contextlib
import os
import random
import signal
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from relay import Relay
from stall import Stall
from stand_in_page import UP, StandInPage

BEGINS_S, SHUTS_S, WATCH_S = 0.1, 0.25, 0.15
PLAYED_S = 60.0
PAGE = Path(__file__).resolve().parents[2] / "helpers" / "stand_in_page.py"


def play(scenario):
    asyncio.run(asyncio.wait_for(scenario, PLAYED_S))


@contextlib.asynccontextmanager
async def driving(crane, address=None):
    """A page that drives the crane, and the task in which it does."""
    crane.ears.forget()
    host = f"127.0.0.1:{crane.port}"
    async with StandInPage(address or crane.address, host) as page:
        await page.take_seat()
        hands = asyncio.create_task(page.drive())
        try:
            await crane.ears.moving()
            yield page, hands
        finally:
            hands.cancel()


def assert_it_stopped(crane, stall):
    """The stop began and ended in time; what the host took away from the processes does not count."""
    stop, lost = crane.ears.stop(), stall.seconds()
    assert stop.released - stop.heartbeat < BEGINS_S + lost
    assert stop.shut - stop.released < SHUTS_S + lost


def watched(crane):
    return Stall(*crane.pids.values())


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
    await page.send(False, UP)


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
            await page.send(True, UP)


async def press_the_emergency_stop(_crane, page, _hands):
    assert (await page.ask("emergency_stop"))["ok"]


ENDS = (let_go, close_the_socket, hang, send_garbage, send_too_large, flood)


@pytest.mark.parametrize("end", ENDS, ids=lambda end: end.__name__)
def test_however_a_page_ends_the_crane_stops_in_time(crane, end):
    async def scenario():
        async with driving(crane) as (page, hands):
            stall = watched(crane)
            await end(crane, page, hands)
            await crane.ears.still()
            assert_it_stopped(crane, stall)

    play(scenario())


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_a_page_whose_process_dies_or_freezes_stops_the_crane_in_time(crane, number):
    async def scenario():
        crane.ears.forget()
        process = subprocess.Popen([sys.executable, str(PAGE), crane.address])
        try:
            await crane.ears.moving()
            stall = watched(crane)
            process.send_signal(number)
            await crane.ears.still()
            assert_it_stopped(crane, stall)
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
            stall = watched(crane)
            relay.dead = True
            await crane.ears.still()
            assert_it_stopped(crane, stall)
            crane.ears.forget()
            async with StandInPage(crane.address) as other:  # the seat is abandoned, and has to be asked for
                while not (await other.ask("take_seat"))["text"].startswith("You have"):
                    await asyncio.sleep(0.05)
            assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())


def test_a_network_that_turns_slow_and_delivers_bursts_stops_the_crane_in_time(crane):
    async def scenario():
        async with Relay(crane.port) as relay, driving(crane, f"http://127.0.0.1:{relay.port}"):
            stall = watched(crane)
            relay.open.clear()
            await asyncio.sleep(0.3)
            relay.open.set()  # a burst of all that waited
            relay.delay = 0.3
            await crane.ears.still()
            assert_it_stopped(crane, stall)
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
                await crane.ears.until(lambda: "slow" in page.seat["deadman"]["text"])
                hands.cancel()
            assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())


def test_a_second_page_looks_on_and_drives_only_when_it_is_handed_the_seat(crane):
    async def scenario():
        async with driving(crane) as (page, hands), StandInPage(crane.address) as other:
            assert "asked" in (await other.ask("take_seat"))["text"]
            crane.ears.forget()
            intruder = asyncio.create_task(other.hold())
            for _ in range(20):
                await other.send(False)
                await other.socket.send_bytes(b"garbage")
            assert not (await other.ask("reset_emergency_stop"))["ok"]
            assert not (await other.ask("set_parameter", node="controller", name="tip_speed", value=1.0))[
                "ok"
            ]
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert all(joy.held for joy in crane.ears.joy)
            stall = watched(crane)
            you = other.heard["welcome"]["you"]
            assert (await page.ask("leave_seat", to=you))["ok"]
            await crane.ears.still()
            assert_it_stopped(crane, stall)
            hands.cancel()
            crane.ears.forget()
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert not any(joy.held for joy in crane.ears.joy)  # it has held the deadman all the time
            intruder.cancel()
            await other.send(False)
            pressed = asyncio.create_task(other.drive())
            await crane.ears.moving()
            pressed.cancel()
            await crane.ears.still()

    play(scenario())


def test_a_flood_of_another_page_does_not_reach_joy(crane):
    async def scenario():
        async with driving(crane), StandInPage(crane.address) as other:
            crane.ears.forget()
            stall = watched(crane)
            await flood(crane, other, asyncio.create_task(asyncio.sleep(0)))
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            times = [joy.at for joy in crane.ears.joy]
            assert all(joy.held for joy in crane.ears.joy) or stall.seconds() > 0.05
            assert max(b - a for a, b in pairwise(times)) < BEGINS_S + stall.seconds()
            assert other.socket.closed or other.socket.close_code == 1008

    play(scenario())


def test_an_emergency_stop_of_any_page_shuts_the_valves_and_its_reset_needs_centred_levers(crane):
    async def scenario():
        async with driving(crane) as (page, hands), StandInPage(crane.address) as other:
            assert (await other.ask("emergency_stop"))["ok"]
            await crane.ears.still()
            await crane.ears.until(lambda: page.heard["emergency_stop"]["active"])
            refused = await page.ask("reset_emergency_stop")
            assert not refused["ok"]
            assert "centred" in refused["text"]
            assert not (await other.ask("reset_emergency_stop"))["ok"]
            hands.cancel()
            await page.send(False)
            await crane.ears.until(lambda: not any(crane.ears.joy[-1].axes))
            assert (await page.ask("reset_emergency_stop"))["ok"]
            await crane.ears.until(lambda: not page.heard["emergency_stop"]["active"])
            states = {one["name"]: one["state"] for one in page.heard["emergency_stop"]["sources"]}
            assert states == {"controller": "ready", "valve_driver": "ready"}

    play(scenario())


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL], ids=["frozen", "killed"])
def test_a_station_that_dies_or_freezes_stops_the_crane_by_the_controllers_watch(crane, number):
    """The last test of the module: the second time, the station is gone."""

    async def scenario():
        async with driving(crane):
            stall = Stall(*(pid for name, pid in crane.pids.items() if name != "station"))
            os.kill(crane.pids["station"], number)
            try:
                await crane.ears.still()
                stop, lost = crane.ears.stop(), stall.seconds()
                assert stop.shut - stop.heartbeat < WATCH_S + SHUTS_S + lost
            finally:
                crane.ears.forget()
                if number == signal.SIGSTOP:
                    os.kill(crane.pids["station"], signal.SIGCONT)
            if number == signal.SIGSTOP:
                await crane.ears.until(lambda: len(crane.ears.joy) > 50)
                assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())
