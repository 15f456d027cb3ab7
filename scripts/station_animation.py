#!/usr/bin/env python3
"""Film 10 s of the operator's page as docs/pictures/station.webp.

scripts/setup.sh test
scripts/demo.sh --lockstep --loads "500 kg from 0.5 s; 0 kg from 9 s"
.venv/bin/python scripts/station_animation.py bags/demo/bag

The page replays the bag, step by step, so that a slow computer films the same as a fast one.
"""

from __future__ import annotations

import contextlib
import io
import math
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from forest_bag.read.timeseries import read_bag
from forest_msgs_py.interfaces import topics

OUTPUT = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "station.webp"
SECONDS, RATE, STRIDE = 10.0, 30, 3  # of the bag; frames a second of a replay, and how many make one picture
WINDOW = {"width": 800, "height": 720}  # narrow: the scene has the whole width
OPTIONS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
BEFORE = "localStorage.setItem('forest.camera', JSON.stringify({ view: 'free', free: null }));"
SETTLED = 0.03  # [m] between the drawn tip and the recorded one
DRAWN = """([wanted, settled]) => {
  const tip = document.getElementById("scene").tipPosition?.() ?? [NaN];
  return Math.hypot(...tip.map((x, i) => x - wanted[i])) < settled;
}"""


@contextlib.contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve the page with the bags of a folder; give its address."""
    command = [
        sys.executable,
        "-m",
        "forest_station.station",
        "--join",
        "--no-browser",
        "--bags",
        str(folder),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as station:
        assert station.stdout is not None
        try:
            yield next(line.split()[-1] for line in station.stdout if line.startswith("the page is at"))
        finally:
            station.send_signal(signal.SIGINT)
            station.communicate()


def filmed(page: Page, tips: np.ndarray) -> Iterator[Image.Image]:
    """Step through the replay; give the pictures of the scene.

    Args:
        page: shows the replay's first frame.
        tips: recorded tip of each frame [m], shape (frames, 3).
    """
    scene = page.locator("#scene")
    for frame, tip in enumerate(tips):
        if frame:
            page.keyboard.press(".")
        page.wait_for_function(DRAWN, arg=[tip.tolist(), SETTLED])
        if frame % STRIDE == 0:
            yield Image.open(io.BytesIO(scene.screenshot(scale="css"))).convert("RGB")


def main() -> None:
    """Film the bag that the command line names."""
    bag = Path(sys.argv[1]).resolve()
    series = read_bag(bag).series(topics.TIP_POSE)
    first = math.ceil(series.log_time_ns[0] * 1e-9 * RATE)  # frame in which the tip is known
    frames = (first + np.arange(round(SECONDS * RATE))) / RATE
    newest = np.searchsorted(series.log_time_ns, frames * 1e9, side="right") - 1
    with served(bag.parent) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        page = browser.new_page(viewport=WINDOW, device_scale_factor=2)  # fine pixels, though few are drawn
        page.set_default_timeout(60_000)
        page.add_init_script(BEFORE)
        page.goto(f"{address}#bag={bag.name}&t={first / RATE}")
        page.wait_for_selector("#replay_banner .name")
        page.eval_on_selector(".rate", "(figure) => figure.style.visibility = 'hidden'")  # of this computer
        begin, *others = filmed(page, series.values[newest, :3])
        browser.close()
    begin.save(OUTPUT, save_all=True, append_images=others, duration=1000 * STRIDE // RATE, loop=0, method=6)
    print(f"{OUTPUT}: {1 + len(others)} pictures, {OUTPUT.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
