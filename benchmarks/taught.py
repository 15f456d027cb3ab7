"""How well taught work is repeated: a path is driven, taught, and played by the real controller, without ROS.

    python benchmarks/taught.py

Prints a table, a row for each circumstance. `taught` is the distance of what was driven from the path that
was kept of it; `played` that of the tip from that path, from its start to its end; both at the true tip, in
mm. Times are those of driving, of the plan, and of playing, which ends when the tip has stood at the end for
0.5 s.
"""

import dataclasses
import math
import sys
import tempfile
from pathlib import Path

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.levers import REST, Levers
from forest_control.taught.cycle_file import load_cycle
from forest_control.taught.plan import planned
from forest_control.taught.player import Phase
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_study.closed_loop.closed_loop import Operator
from forest_study.tracking.taught_loop import TaughtLoop, cross_track
from forest_study.tracking.tracking import noisy

START, SECONDS, SETTLE = (5.5, 0.0, 0.8), 9.0, 0.5
C180 = load_machine("c180_hoses")
HEAVY = dataclasses.replace(C180.manipulator, head_mass=2.0 * C180.manipulator.head_mass)
ROWS = {
    "exact sensors": {},
    "sensor noise": {"suite": noisy(C180, 1)},
    "twice the head's mass, unknown": {
        "plant": plant_parameters(dataclasses.replace(C180, manipulator=HEAVY))
    },
    "joint rates limited to a twentieth": {"settings": Settings(joint_rates=(0.02, 0.01, 0.01))},
}


def levers(time: float) -> Levers:
    """Return what the driver does at a time [s]."""
    return Levers(0.6 * math.sin(0.7 * time), 0.5 * math.sin(1.3 * time), 0.5 * math.cos(0.9 * time) - 0.2)


def row(name: str, circumstances: dict, folder: Path) -> str:
    """Return a circumstance's line of the table."""
    sensors = {key: value for key, value in circumstances.items() if key == "suite"}
    loop = TaughtLoop(C180, START, folder, **sensors)
    loop.work.cycle = name.split()[0]
    loop.drive(Operator(REST), SETTLE)
    loop.work.record()
    begun = len(loop.tips)
    for k in range(round(SECONDS / PERIOD)):
        loop.period(Operator(levers(k * PERIOD)))
    driven = loop.tips[begun:]
    loop.drive(Operator(REST), SETTLE)
    loop.work.stop()
    cycle = load_cycle(loop.work.cycle, folder)
    points = list(cycle.segments[0].points)
    (leg,) = planned(cycle, points[0], parameters(C180, Settings()))
    loop = TaughtLoop(C180, points[0], folder, **circumstances)
    loop.work.cycle = cycle.name
    loop.drive(Operator(REST), SETTLE)
    loop.work.play()
    begun = len(loop.tips)
    loop.until(Phase.FINISHED, 120.0)
    taught, played = cross_track(points, driven), cross_track(points, loop.tips[begun:])
    cells = [f"{x.rms_mm:.2f} / {x.max_mm:.1f}" for x in (taught, played)]
    times = [f"{x:.1f}" for x in (SECONDS, leg.duration, (len(loop.tips) - begun) * PERIOD)]
    return f"| {name} | {len(points)} | {' | '.join(cells)} | {' | '.join(times)} |"


def main() -> None:
    """Print the table."""
    heads = ("circumstance", "points", "taught, RMS / max", "played, RMS / max", "driven, s", "planned, s")
    print(f"| {' | '.join(heads)} | played, s |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name, circumstances in ROWS.items():
            print(row(name, circumstances, Path(folder)), flush=True)


if __name__ == "__main__":
    sys.exit(main())
