"""Memory of the station, the graph's nodes and the browser while the crane is driven from its page.

`scripts/long.sh [MINUTES]`: the real graph, the real page in headless Chromium, keys that never rest.
The first fifth is left out: caches fill. From then on the medians of the first and the last third are
compared. Growth above what is allowed ends with exit code 1, as does a crane that mostly stood.
"""

import argparse
import math
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

from browser import DESKTOP, launched, new_page
from graph_processes import nodes_of
from playwright.sync_api import Browser, Page, sync_playwright
from running_graph import free_port, running, wait_for_text

PERIOD = 5.0  # [s] between two readings
ALLOWED = {"station": 5.0, "nodes": 5.0, "page's heap": 5.0, "browser": 20.0}  # [MB] of growth over the run
MOVED = 0.1  # [m] of the drawn tip in a turn that count as driven
DRIVEN = 0.5  # of all turns, at least: a busy computer drops some deadmen
KEYS = ("s", "d", "ArrowUp", "w", "a", "ArrowDown")  # there and back again
PRESSED = 200.0  # [ms] from the deadman to the key, and from the key on
TIP = "() => document.getElementById('scene').tipPosition?.() ?? [0, 0, 0]"
DOMAIN = 77


class Reading(NamedTuple):
    """Memory by owner [MB] at a time [s], pictures drawn a second, and whether the crane was driven."""

    time: float
    memory: dict[str, float]
    rate: float
    driven: bool


def main() -> int:
    """Run; return 1 if memory grows."""
    parser = argparse.ArgumentParser(prog="scripts/long.sh", description=__doc__.splitlines()[0])
    parser.add_argument("minutes", type=float, nargs="?", default=10.0, metavar="MINUTES")
    minutes = parser.parse_args().minutes
    log, port = Path(tempfile.mkdtemp()) / "station.log", free_port()
    with running("forest_station.station", log, DOMAIN, "--port", str(port), "--no-browser") as station:
        wait_for_text(station, log, "the page is at")
        with sync_playwright() as playwright, launched(playwright) as browser:
            page, errors = new_page(browser, DESKTOP)
            page.goto(f"http://127.0.0.1:{port}")
            page.wait_for_selector("#seat .driver:text('You drive')", state="attached")
            readings = drive(page, browser, nodes_of(station), 60.0 * minutes)
    return report(readings, errors)


def drive(page: Page, browser: Browser, nodes: dict[str, int], seconds: float) -> list[Reading]:
    """Drive to and fro, the deadman pressed anew for each key; return the readings."""
    client, whole = page.context.new_cdp_session(page), browser.new_browser_cdp_session()
    readings: list[Reading] = []
    begun = time.monotonic()
    while (elapsed := time.monotonic() - begun) < seconds:
        key, before = KEYS[len(readings) % len(KEYS)], page.evaluate(TIP)
        for press in ("ShiftLeft", key):
            page.keyboard.down(press)
            page.wait_for_timeout(PRESSED)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0)
        for press in (key, "ShiftLeft"):
            page.keyboard.up(press)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0 - 2.0 * PRESSED)
        driven = math.dist(before, page.evaluate(TIP)) > MOVED
        rate = page.evaluate("Number(document.getElementById('scene').dataset.rate)")
        readings.append(Reading(elapsed, memory(client, whole, nodes), rate, driven))
    return readings


def memory(page: Any, browser: Any, nodes: dict[str, int]) -> dict[str, float]:
    """Return memory by owner [MB]: processes without what they share, the page's heap without garbage."""
    page.send("HeapProfiler.collectGarbage")
    heap = page.send("Runtime.getHeapUsage")["usedSize"] / 1e6
    processes = [one["id"] for one in browser.send("SystemInfo.getProcessInfo")["processInfo"]]
    others = [pid for name, pid in nodes.items() if name != "station"]
    return {
        "station": own(nodes["station"]),
        "nodes": sum(map(own, others)),
        "page's heap": heap,
        "browser": sum(map(own, processes)),
    }


def own(pid: int) -> float:
    """Return the memory [MB] that a process shares with none."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return sum(int(line.split()[1]) for line in lines if line.startswith("Private_")) * 1024e-6


def report(readings: list[Reading], errors: list[str]) -> int:
    """Print readings and growth; return the exit code."""
    settled = readings[len(readings) // 5 :]
    third = max(1, len(settled) // 3)
    print("| | first third, MB | last third, MB | growth, MB |\n|---|---|---|---|")
    grows = False
    for name, allowed in ALLOWED.items():
        values = [one.memory[name] for one in settled]
        first, last = statistics.median(values[:third]), statistics.median(values[-third:])
        grows |= last - first > allowed
        print(f"| {name} | {first:.1f} | {last:.1f} | {last - first:+.1f} |")
    rate = statistics.median(one.rate for one in settled)
    driven = sum(one.driven for one in readings)
    print(f"\n{readings[-1].time:.0f} s, {rate:.0f} pictures a second, errors on the page: {len(errors)}")
    print(f"driven in {driven} of {len(readings)} turns")
    for error in errors:
        print(error, file=sys.stderr)
    return int(grows or bool(errors) or driven < DRIVEN * len(readings))


if __name__ == "__main__":
    sys.exit(main())
