"""Who drives, and who may stop: the real nodes and sockets."""

import asyncio
import contextlib
import math
import time

import aiohttp
import pytest
from stand_in_page import CENTRED, FRAME_HEAD, StandInPage, driving, opposite, play

from forest_control.limits.velocity_scaling import Limit
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import publisher

ASIDE = (0.75, 0.0, 0.0, 0.0, 0.0, 0.0)


def is_undisturbed(page):
    """Whether nothing but the host's own stalls can have ended a page's driving."""
    deadman = page.seat["deadman"]
    return deadman["state"] == "held" or "too late" in deadman["text"]


def test_a_second_page_looks_on_and_its_hands_count_for_nothing(crane):
    async def scenario():
        async with driving(crane) as (page, _), StandInPage(crane.address) as other:
            assert "asked" in (await other.ask("take_seat"))["text"]
            crane.ears.forget()
            for _ in range(20):
                await other.send(False)
                await other.send(True, ASIDE)
                await other.socket.send_bytes(b"garbage")
            assert not (await other.ask("reset_emergency_stop"))["ok"]
            assert not (await other.ask("set_parameter", node="controller", name="tip_speed", value=1.0))[
                "ok"
            ]
            assert not (await other.ask("leave_seat"))["ok"]
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert is_undisturbed(page)
            assert {joy.axes for joy in crane.ears.joy} <= {page.stick, opposite(page.stick), CENTRED}

    play(scenario())


def test_handed_the_seat_a_page_drives_only_after_it_has_pressed_anew(crane):
    async def scenario():
        async with driving(crane) as (page, _), StandInPage(crane.address) as other:
            pressing = asyncio.create_task(other.hold())
            await crane.ears.until(lambda: "welcome" in other.heard)
            stall = crane.stall()
            assert (await page.ask("leave_seat", to=other.heard["welcome"]["you"]))["ok"]
            await crane.ears.still()
            crane.assert_it_stopped(stall)
            crane.ears.forget()
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert not any(joy.held for joy in crane.ears.joy)  # it has held the deadman all the time
            pressing.cancel()
            pressed = asyncio.create_task(other.drive())
            await crane.ears.moving()
            pressed.cancel()
            await crane.ears.still()

    play(scenario())


def test_a_flood_of_another_page_ends_its_socket_and_does_not_reach_joy(crane):
    async def scenario():
        async with driving(crane) as (page, _), StandInPage(crane.address) as other:
            crane.ears.forget()
            with contextlib.suppress(ConnectionError):
                for _ in range(5000):
                    await other.send(True, ASIDE)
            await crane.ears.until(lambda: other.socket.closed)
            assert other.socket.close_code == 1008
            await crane.ears.until(lambda: len(crane.ears.joy) > 50)
            assert is_undisturbed(page)
            assert {joy.axes for joy in crane.ears.joy} <= {page.stick, opposite(page.stick), CENTRED}

    play(scenario())


def test_an_emergency_stop_of_any_page_shuts_the_valves_and_its_reset_needs_centred_levers(crane):
    async def scenario():
        async with driving(crane) as (page, hands), StandInPage(crane.address) as other:
            assert (await other.ask("emergency_stop"))["ok"]
            await crane.ears.still()
            hands.cancel()
            hands = asyncio.create_task(page.hold())
            crane.ears.forget()
            await crane.ears.until(lambda: crane.ears.joy and crane.ears.joy[-1].axes == page.stick)
            await crane.ears.until(lambda: page.heard["emergency_stop"]["active"])
            refused = await page.ask("reset_emergency_stop")
            assert not refused["ok"]
            assert "centred" in refused["text"]
            assert not (await other.ask("reset_emergency_stop"))["ok"]
            hands.cancel()
            await page.send(False)
            crane.ears.forget()
            await crane.ears.until(lambda: crane.ears.joy and not any(crane.ears.joy[-1].axes))
            assert (await page.ask("reset_emergency_stop"))["ok"]
            await crane.ears.until(lambda: not page.heard["emergency_stop"]["active"])
            states = {one["name"]: one["state"] for one in page.heard["emergency_stop"]["sources"]}
            assert states == dict.fromkeys(("controller", "valve_driver", "simulator"), "ready")

    play(scenario())


def test_the_seat_is_refused_and_ends_while_another_node_publishes_joy(crane):
    async def scenario():
        async with StandInPage(crane.address) as page:
            await page.take_seat()
            rival = publisher(crane.node, topics.JOY)
            try:
                named = "Another node publishes /joy: ears."  # its name may come after the refusal
                await crane.ears.until(lambda: page.seat["driver"] is None and page.seat["why_not"] == named)
                refused = await page.ask("take_seat")
                assert (refused["ok"], refused["text"][:33]) == (False, "Another node publishes /joy: ears")
            finally:
                crane.node.destroy_publisher(rival)
            await page.take_seat()

    play(scenario())


def test_parameters_are_told_set_and_refused_with_the_nodes_own_words(crane):
    async def scenario():
        async with StandInPage(crane.address) as page:
            await page.take_seat()
            await crane.ears.until(lambda: len(page.heard.get("parameters", {"nodes": ()})["nodes"]) == 3)
            told = page.heard["parameters"]["nodes"]["controller"]["scheme"]
            assert (told["value"], told["live"], told["type"]) == ("coordinated", True, "str")
            assert "ik_velocity" in told["choices"]
            refused = await page.ask("set_parameter", node="controller", name="tip_speed", value=99)
            assert "99" in refused["text"]
            assert "3.0" in refused["text"]
            assert not (await page.ask("set_parameter", node="controller", name="tip_speed", value="x"))["ok"]
            assert not (await page.ask("set_parameter", node="controller", name="no", value=1))["ok"]
            assert not (await page.ask("set_parameter", node="sun", name="no", value=1))["ok"]
            assert (await page.ask("set_parameter", node="controller", name="workspace", value="c180"))["ok"]
            async with (
                aiohttp.ClientSession() as session,
                session.get(f"{crane.address}/scene.json") as answer,
            ):
                assert (await answer.json())["walls"]
            assert (await page.ask("set_parameter", node="controller", name="workspace", value=""))["ok"]

    play(scenario())


async def set_controller(page, **values):
    """Set parameters of the controller as the page does."""
    for name, value in values.items():
        told = await page.ask("set_parameter", node="controller", name=name, value=value)
        assert told["ok"], told


@contextlib.asynccontextmanager
async def steered(crane, page):
    """A page that has the seat holds the crane, at rest to begin with; then it lets go."""
    page.stick = CENTRED
    hands = asyncio.create_task(page.steer())
    try:
        await crane.ears.until(lambda: page.seat["deadman"]["state"] == "held")
        yield
    finally:
        hands.cancel()
        await crane.ears.still()


def test_walls_that_the_page_sets_hold_the_driven_tip(crane):
    floor = -2.2 + 0.15  # [m] of c180: its ground and margin

    async def scenario():
        async with StandInPage(crane.address) as page:
            await page.take_seat()
            await set_controller(page, workspace="c180", tip_speed=1.5)
            async with steered(crane, page):
                page.stick = (0.0, 0.0, 0.0, -1.0, 0.0, 0.0)
                limit, speed = "controller/status/limit", "tip/twist/z"
                await crane.ears.until(lambda: page.value(limit) == Limit.WALL and page.value(speed) > -0.05)
                assert floor - 0.01 < page.value("tip/pose/z") < floor + 0.05
                page.stick = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
                await crane.ears.until(lambda: page.value("tip/pose/z") > floor + 0.5)
            await set_controller(page, workspace="", tip_speed=0.5)

    play(scenario())


async def play_until(crane, page, condition):
    """Go on with a cycle until a condition holds: a busy computer may pause it, as any doubt does."""

    def told():
        return condition() or page.heard["taught_work"]["phase"] == "paused"

    while not condition():
        await page.ask("resume_cycle")
        await crane.ears.until(told)


def test_what_is_taught_by_driving_is_played_paused_by_a_stick_and_resumed(crane):
    async def scenario():
        async with StandInPage(crane.address) as page, StandInPage(crane.address) as other:
            await page.take_seat()

            def tip():
                return [page.value(f"tip/pose/{axis}") for axis in "xyz"]

            def has(phase):
                return lambda: page.heard.get("taught_work", {}).get("phase") == phase

            await crane.ears.until(has("idle"))
            home = tip()
            assert (await page.ask("teach", cycle="home", what="pose", label="back"))["ok"]
            assert "take the seat" in (await other.ask("play_cycle", cycle="home"))["text"]
            async with steered(crane, page):
                page.stick = ASIDE
                await crane.ears.until(lambda: math.dist(tip(), home) > 0.5)
                page.stick = CENTRED
                assert (await page.ask("play_cycle", cycle="home"))["ok"]
                await play_until(crane, page, lambda: math.dist(tip(), home) < 0.45)
                page.stick = ASIDE
                await crane.ears.until(has("paused"))
                why = page.heard["taught_work"]["text"]
                assert why == "home: paused: a stick moved." or "held" in why or "released" in why
                page.stick = CENTRED
                await play_until(crane, page, has("finished"))
                assert math.dist(tip(), home) < 0.01

    play(scenario())


def test_frames_hold_every_signal_30_times_a_second(crane):
    async def scenario():
        async with StandInPage(crane.address) as page:
            await crane.ears.until(lambda: page.frames > 5)
            names = [name for name, _ in page.heard["welcome"]["signals"]]
            assert {"joint_states/boom.position", "crane/boom_cylinder_rod.position", "tip/pose/x"} <= {
                *names
            }
            assert page.value("hydraulics/supply/pressure") > 1e5
            assert len(page.frame) == FRAME_HEAD + 4 * len(names)
            begun, frames = time.monotonic(), page.frames
            await crane.ears.until(lambda: page.frames > frames + 30)
            assert time.monotonic() - begun > 0.9

    play(scenario())


def test_the_driver_has_the_simulated_head_grasp_and_drop(crane):
    # Behind the tests that look where the tip rests: a dropped log leaves the crane rocking.
    async def scenario():
        async with driving(crane) as (page, _), StandInPage(crane.address) as other:
            await crane.ears.until(lambda: "welcome" in other.heard)
            assert not (await other.ask("grapple", act="grasp"))["ok"]
            assert "allowed: grasp or drop" in (await page.ask("grapple", act="throw"))["text"]
            grasped = await page.ask("grapple", act="grasp")
            assert (grasped["ok"], grasped["text"]) == (True, "Holds a log of 500 kg, 4 m long.")
            assert "already" in (await page.ask("grapple", act="grasp"))["text"]
            assert (await page.ask("grapple", act="drop"))["text"] == "Dropped a log of 500 kg."

    play(scenario())


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Origin": "http://evil.example"}, 403),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example:80", "Origin": "http://evil.example:80"}, 403),
    ],
)
@pytest.mark.parametrize("path", ["/", "/scene.json", "/web/main.js", "/socket"])
def test_only_our_own_page_opens_pages_and_the_socket(crane, headers, status, path):
    async def scenario():
        async with aiohttp.request("GET", f"{crane.address}{path}", headers=headers) as answer:
            assert answer.status == (400 if path == "/socket" and status == 200 else status)
            policy = answer.headers["Content-Security-Policy"]
            assert policy.startswith("default-src 'self'")
            assert "unsafe" not in policy
            assert answer.headers["X-Content-Type-Options"] == "nosniff"
            assert answer.headers["Referrer-Policy"] == "no-referrer"

    play(scenario())
