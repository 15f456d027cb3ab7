"""`scripts/bags.sh`: makes the reference bags anew, short runs in lockstep, the same to the last bit.

| bag | run |
|---|---|
| coordinated | a hand on the levers, the shipped controller and driver |
| valves | the driver without compensation, each valve slowly through its overlap, both ways |
| fault | the thesis' input; the joystick is lost in mid-motion and comes back |
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from forest_bringup import graph, lockstep_run
from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import NodeSpec
from forest_control.operator.joystick_sources import LEAD_IN, LEAD_OUT
from forest_msgs_py.runtime import command_line
from forest_msgs_py.types import PERIOD
from forest_study.demo import synthetic_operator

MACHINE, SCHEME = "c180", "coordinated"
SEED, HAND_TIME = 7, 4.5  # [s]
PEAK, RISE = 2.5, 0.6  # [V], [s]
FAULT, FAULT_TIME = "lost from 2 s until 2.6 s", 3.5  # [s]
LOG = "/rosout"  # names the files that log
NOT_OF_VALVES = ["ground_truth/.+"]  # the sensors have no errors in these runs
NOT_OF_COORDINATED = ["ground_truth/(head|deflections|pump|tank_line)"]  # its replay has no simulator
LEFT_OUT = {"coordinated": NOT_OF_COORDINATED, "valves": NOT_OF_VALVES, "fault": []}
NAMES = tuple(LEFT_OUT)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the bags; return the exit code."""
    parser = argparse.ArgumentParser(prog="scripts/bags.sh", description="Make the reference bags anew.")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("bags"),
        metavar="DIR",
        help="directory of the bags (default: %(default)s)",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"bags: {', '.join(NAMES)} (default: all)")
    parser.set_defaults(command=_make)
    return command_line.run("bags", parser.parse_args(arguments), (GraphError,))


def _make(options: argparse.Namespace) -> int:
    unknown = sorted(set(options.names) - set(NAMES))
    if unknown:
        raise GraphError(f"no reference bag {', '.join(unknown)}; there are {', '.join(NAMES)}")
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or NAMES:
        print(f"making {options.out / name}", flush=True)
        # Beside the old bag, and relative: a bag tells its parameters, and shall name no directory of ours.
        new = options.out / f".{name}" / name
        shutil.rmtree(new.parent, ignore_errors=True)
        new.parent.mkdir()
        try:
            nodes, seconds = _session(name, options.out)
            exclude = graph.parameter("exclude", [LOG, *LEFT_OUT[name]])
            output = graph.parameter("output", str(new))
            nodes.append(NodeSpec("recorder", "forest_bag.recorder_node", (*output, *exclude)))
            with tempfile.TemporaryDirectory() as logs:
                lockstep_run.run(nodes, round(seconds / PERIOD), Path(logs))
            shutil.rmtree(options.out / name, ignore_errors=True)
            new.rename(options.out / name)
        finally:
            shutil.rmtree(new.parent, ignore_errors=True)
    return 0


def _session(name: str, out: Path) -> tuple[list[NodeSpec], float]:
    """Return the nodes of a run, and how long it is [s]."""
    if name == "valves":
        return _valves(out / "valves.csv")
    source, duration, faults = "thesis", FAULT_TIME, FAULT
    if name == "coordinated":
        path = out / "levers.csv"
        synthetic_operator.write_csv(
            path, synthetic_operator.HEADER, *synthetic_operator.hand_levers(SEED, HAND_TIME)
        )
        source, duration, faults = str(path), HAND_TIME, ""
    nodes = [
        graph.joystick(source, duration, 0, faults, interpolate=False),
        *graph.control(MACHINE, SCHEME, False, False, {"profile": "exact"}),
        graph.simulator(MACHINE),
    ]
    return nodes, LEAD_IN + duration + LEAD_OUT


def _valves(path: Path) -> tuple[list[NodeSpec], float]:
    times, commands = synthetic_operator.valve_ramps(PEAK, RISE)
    synthetic_operator.write_csv(path, "time,swing,boom,stick", times, commands)
    _, driver = graph.control(MACHINE, SCHEME, shadow=False, describe=False)
    off = graph.parameter("compensate", False)
    nodes = [
        NodeSpec("commander", "forest_sim.commander_node", graph.parameter("input", str(path))),
        driver._replace(arguments=(*driver.arguments, *off)),
        graph.simulator(MACHINE),
    ]
    return nodes, float(times[-1])


if __name__ == "__main__":
    sys.exit(main())
