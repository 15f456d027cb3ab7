"""Memory of the operator's page and of the station's server while the crane is driven from a browser.

`scripts/long.sh [MINUTES]`: the real graph, the real page in headless Chromium, keys that never rest.
The first fifth is left out: caches fill. From then on the medians of the first and the last third are
compared; growth above `ALLOWED` ends with exit code 1.
"""

import argparse
import statistics
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

from browser import DESKTOP, launched, new_page
from graph_processes import nodes_of
from playwright.sync_api import Page, sync_playwright
from running_graph import free_port, running, wait_for_text

PERIOD = 5.0  # [s] between two readings
ALLOWED = 5.0  # [MB] of growth over the run: what two readings of an idle Chromium may differ by
KEYS = ("s", "d", "ArrowUp", "w", "a", "ArrowDown")  # there and back again
DOMAIN = 77


class Reading(NamedTuple):
    """Memory [MB] at a time [s], and pictures drawn a second."""

    time: float
    server: float
    page: float
    rate: float


def main() -> int:
    """Run; return 1 if memory grows."""
    parser = argparse.ArgumentParser(prog="scripts/long.sh", description=__doc__.splitlines()[0])
    parser.add_argument("minutes", type=float, nargs="?", default=10.0, metavar="MINUTES")
    minutes = parser.parse_args().minutes
    log, port = Path("long.log"), free_port()
    with running("forest_station.station", log, DOMAIN, "--port", str(port), "--no-browser") as station:
        wait_for_text(station, log, "the page is at")
        with sync_playwright() as playwright, launched(playwright) as browser:
            page, errors = new_page(browser, DESKTOP)
            page.goto(f"http://127.0.0.1:{port}")
            page.wait_for_selector("#seat .driver:text('You drive')", state="attached")
            readings = drive(page, nodes_of(station)["station"], 60.0 * minutes)
    return report(readings, errors)


def drive(page: Page, server: int, seconds: float) -> list[Reading]:
    """Drive to and fro; return the readings."""
    client: Any = page.context.new_cdp_session(page)
    readings, begun, turn = [], time.monotonic(), 0
    page.keyboard.down("ShiftLeft")
    while (elapsed := time.monotonic() - begun) < seconds:
        key = KEYS[turn % len(KEYS)]
        page.keyboard.down(key)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0)
        page.keyboard.up(key)
        page.wait_for_timeout(1000.0 * PERIOD / 2.0)
        turn += 1
        readings.append(reading(page, client, server, elapsed))
    page.keyboard.up("ShiftLeft")
    return readings


def reading(page: Page, client: Any, server: int, elapsed: float) -> Reading:
    """Return the memory of the server's process and of the page's heap, garbage collected."""
    client.send("HeapProfiler.collectGarbage")
    heap = client.send("Runtime.getHeapUsage")["usedSize"] / 1e6
    pages = int(Path(f"/proc/{server}/statm").read_text().split()[1])
    rate = page.evaluate("Number(document.getElementById('scene').dataset.rate)")
    return Reading(elapsed, pages * 4096 / 1e6, heap, rate)


def report(readings: list[Reading], errors: list[str]) -> int:
    """Print readings and growth; return the exit code."""
    settled = readings[len(readings) // 5 :]
    third = max(1, len(settled) // 3)
    print("| | first third, MB | last third, MB | growth, MB |\n|---|---|---|---|")
    worst = 0.0
    for name in ("server", "page"):
        values = [getattr(one, name) for one in settled]
        first, last = statistics.median(values[:third]), statistics.median(values[-third:])
        worst = max(worst, last - first)
        print(f"| {name} | {first:.1f} | {last:.1f} | {last - first:+.1f} |")
    rate = statistics.median(one.rate for one in settled)
    print(f"\n{readings[-1].time:.0f} s, {rate:.0f} pictures a second, errors on the page: {len(errors)}")
    for error in errors:
        print(error, file=sys.stderr)
    return int(worst > ALLOWED or bool(errors))


if __name__ == "__main__":
    sys.exit(main())
