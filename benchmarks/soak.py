"""Memory, rate and stops of the crane while it is driven from its page for long.

`scripts/long.sh [MINUTES]`: the real graph, the real page in headless Chromium, keys that never rest.
The first fifth is left out of memory and pictures: caches fill. From then on the medians of the first and
the last third are compared. Growth beyond what is allowed ends with exit code 1. So does a missed stop, a
rate that is not held, or a crane that mostly stood.
"""

import argparse
import math
import os
import statistics
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

import rclpy
from browser import DESKTOP, launched, new_page
from graph_processes import nodes_of
from live_crane import Ears
from playwright.sync_api import Browser, Page, sync_playwright
from running_graph import free_port, running, wait_for_text

PERIOD = 5.0  # [s] of a turn: to and fro
SLOPE = 1.0  # [MB/h] of growth of a process
SPREAD = {"browser": 20.0}  # [MB] of readings without growth; others:
STEADY = 3.0  # [MB]
STOPPED = 0.5  # [s] from the released keys to the last open valve: the stop takes 0.25 s
RATE, HELD = 200.0, 0.99  # [Hz] of the machine's state, and the share of it that must come
MOVED = 0.1  # [m] of the drawn tip in a turn that count as driven
DRIVEN = 0.5  # of all turns, at least: a busy computer drops some deadmen
KEYS = ("s", "d", "ArrowUp", "w", "a", "ArrowDown")  # there and back again
PRESSED = 200.0  # [ms] from the deadman to the key, and from the key on
TIP = "() => document.getElementById('scene').tipPosition?.() ?? [0, 0, 0]"
DOMAIN = 77


class Reading(NamedTuple):
    """What a turn showed."""

    time: float  # [s] from the beginning
    memory: dict[str, float]  # [MB] by owner
    pictures: float  # a second
    driven: bool
    stop: float  # [s] from the released keys to the last open valve; negative: it was shut before
    states: int  # of the machine
    gap: float  # [s] between two of them, at most


def main() -> int:
    """Run; return 1 if something fails."""
    parser = argparse.ArgumentParser(prog="scripts/long.sh", description=__doc__.splitlines()[0])
    parser.add_argument("minutes", type=float, nargs="?", default=10.0, metavar="MINUTES")
    minutes = parser.parse_args().minutes
    os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
    with tempfile.TemporaryDirectory() as folder:
        return soak(Path(folder), 60.0 * minutes)


def soak(folder: Path, seconds: float) -> int:
    """Start graph, recorder and page, drive them, and return the exit code."""
    log, port = folder / "station.log", free_port()
    options = "--port", str(port), "--no-browser", "--bags", str(folder)
    with running("forest_station.station", log, DOMAIN, *options) as station:
        wait_for_text(station, log, "the page is at")
        rclpy.init()
        ears = Ears(rclpy.create_node("ears", start_parameter_services=False, enable_rosout=False))
        with sync_playwright() as playwright, launched(playwright) as browser:
            page, errors = new_page(browser, DESKTOP)
            page.goto(f"http://127.0.0.1:{port}")
            page.wait_for_selector("#seat .driver:text('You drive')", state="attached")
            page.locator("#recording [aria-label='Name of the recording']").fill("soak")
            page.locator("#recording .record").click()
            page.wait_for_selector("#recording .state:text('soak: ')")
            nodes = nodes_of(station)
            nodes |= nodes_of(SimpleNamespace(pid=nodes["station"]))  # the recorder is the station's
            readings = drive(page, browser, ears, nodes, seconds)
    return report(readings, errors)


def drive(page: Page, browser: Browser, ears: Ears, nodes: dict[str, int], seconds: float) -> list[Reading]:
    """Drive to and fro, the deadman pressed anew for each key; return the readings."""
    client, whole = page.context.new_cdp_session(page), browser.new_browser_cdp_session()
    readings: list[Reading] = []
    begun = time.monotonic()
    forget(ears)
    while (elapsed := time.monotonic() - begun) < seconds:
        key, before = KEYS[len(readings) % len(KEYS)], page.evaluate(TIP)
        for press in ("ShiftLeft", key):
            page.keyboard.down(press)
            page.wait_for_timeout(PRESSED)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0)
        released = time.time()
        for press in (key, "ShiftLeft"):
            page.keyboard.up(press)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0 - 2.0 * PRESSED)
        driven = math.dist(before, page.evaluate(TIP)) > MOVED
        pictures = page.evaluate("Number(document.getElementById('scene').dataset.rate)")
        owners = memory(client, whole, nodes)
        readings.append(Reading(elapsed, owners, pictures, driven, *heard(ears, released)))
    return readings


def forget(ears: Ears) -> None:
    """Forget what the topics said, but for the newest state."""
    ears.read()
    ears.volts.clear()
    ears.told.clear()
    del ears.tips[:-1]


def heard(ears: Ears, released: float) -> tuple[float, int, float]:
    """Return a turn's stop, states and gap, and forget them."""
    ears.read()
    stop = max((at for at, volts in ears.volts if any(volts)), default=-math.inf) - released
    times = [at for at, _ in ears.tips]
    gap = max((later - at for at, later in pairwise(times)), default=math.inf)
    forget(ears)
    return stop, len(times) - 1, gap


def memory(page: Any, browser: Any, nodes: dict[str, int]) -> dict[str, float]:
    """Return memory by owner [MB]: processes without what they share, the page's heap without garbage."""
    page.send("HeapProfiler.collectGarbage")
    heap = page.send("Runtime.getHeapUsage")["usedSize"] / 1e6
    processes = [one["id"] for one in browser.send("SystemInfo.getProcessInfo")["processInfo"]]
    return {name: own(pid) for name, pid in nodes.items()} | {
        "page's heap": heap,
        "browser": sum(map(own, processes)),
    }


def own(pid: int) -> float:
    """Return the memory [MB] that a process shares with none."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("Private_")) * 1024e-6


def report(readings: list[Reading], errors: list[str]) -> int:
    """Print growth, rate and stops; return the exit code."""
    settled = readings[len(readings) // 5 :]
    third = max(1, len(settled) // 3)
    hours = (settled[-1].time - settled[0].time) / 3600.0 * 2.0 / 3.0  # between the thirds' middles
    print("| | first third, MB | last third, MB | growth, MB/h |\n|---|---|---|---|")
    failed = list(errors)
    for name in settled[0].memory:
        values = [one.memory[name] for one in settled]
        first, last = statistics.median(values[:third]), statistics.median(values[-third:])
        print(f"| {name} | {first:.1f} | {last:.1f} | {(last - first) / hours:+.1f} |")
        if last - first > SPREAD.get(name, STEADY) + SLOPE * hours:
            failed.append(f"{name} grows")
    stops = [one.stop for one in readings if one.stop > 0.0]
    driven = sum(one.driven for one in readings)
    worst = max(stops, default=math.inf)
    missed = sum(stop > STOPPED for stop in stops)
    rate = sum(one.states for one in readings[1:]) / (readings[-1].time - readings[0].time)
    pictures = statistics.median(one.pictures for one in settled)
    print(f"\n{readings[-1].time:.0f} s, driven in {driven} of {len(readings)} turns")
    print(f"{len(stops)} stops: median {statistics.median(stops or [math.inf]):.2f} s, worst {worst:.2f} s")
    print(f"state: {rate:.1f} a second, longest gap {max(one.gap for one in readings):.3f} s")
    print(f"{pictures:.0f} pictures a second, errors on the page: {len(errors)}")
    if worst > STOPPED:
        failed.append(f"{missed} stops took longer than {STOPPED} s")
    if rate < HELD * RATE:
        failed.append(f"{rate:.1f} states a second; wanted: {RATE:g}")
    if driven < DRIVEN * len(readings):
        failed.append("the crane mostly stood")
    for one in failed:
        print(one, file=sys.stderr)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
