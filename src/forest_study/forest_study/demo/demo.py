"""`scripts/demo.sh`: one session on the simulated crane, from joystick to bag, summary and pictures."""

import argparse
import contextlib
import math
import os
import shutil
import signal
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from forest_bringup import graph
from forest_bringup.graph_lock import AlreadyRunning, GraphError
from forest_bringup.lockstep_run import GUARD, RECORDER, in_lockstep
from forest_bringup.profile_choice import profile_for, recorded_profile
from forest_bringup.supervisor import STOP_SIGNALS, Stopped, Supervisor
from forest_control.operator.joystick_bag import is_bag, read_joy_record
from forest_control.operator.joystick_fault_injection import parse_joystick_faults
from forest_control.operator.joystick_sources import (
    LEAD_IN,
    LEAD_OUT,
    THESIS_DURATION,
    LeverError,
    read_levers,
)
from forest_description.config.parameter import MachineError
from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_msgs_py.runtime.command_line import StatusLine, number
from forest_msgs_py.runtime.stop_signals import heeded
from forest_msgs_py.types import PERIOD
from forest_sim.simulation.load_schedule import parse_loads
from forest_study.results import write_json

BAG = "bag"  # of a session, in the directory for results
LISTENERS = 2  # controller and recorder: the bag holds the session from its first joystick sample
END_LIMIT = 10.0  # [s] for it to end
START_LIMIT = 20.0  # [s] for the session to begin


class Progress:
    """A line that says how far the session is; on a terminal it overwrites itself."""

    def __init__(self, duration: float, log: Path) -> None:
        self._duration, self._log = duration, log
        self._created, self._begun, self._shown = time.monotonic(), math.nan, -1
        self._line = StatusLine(sys.stdout)

    def __call__(self) -> None:
        """Show progress once a second; fail when the session does not begin."""
        now = time.monotonic()
        if math.isnan(self._begun):
            if self._log.exists() and b"playing" in self._log.read_bytes():
                self._begun = now
            elif now - self._created > START_LIMIT:
                raise GraphError(
                    f"the session did not begin within {START_LIMIT:g} s; see the logs in {self._log.parent}"
                )
            return
        if now - self._begun > self._duration + END_LIMIT:
            raise GraphError(f"the joystick source did not end {END_LIMIT:g} s after the session should have")
        second = int(now - self._begun - LEAD_IN)
        if second > self._shown and second <= self._duration:
            self._shown = second
            if self._line.terminal or second % 5 == 0:
                self._line.show(f"  driving {second:4d} / {self._duration:g} s")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo; return 0 when every node ended well, 1 after a failure, 130 when the user stopped it."""
    options = _parse(arguments)
    for sign in heeded(
        STOP_SIGNALS
    ):  # before and after the graph; while it runs, its supervisor stops it in order
        signal.signal(sign, _leave)
    try:
        with contextlib.suppress(BrokenPipeError):
            return _demo(options)
    except Stopped:
        kept = f"; what was recorded is in {options.out}" if (options.out / BAG).exists() else ""
        print(f"\ndemo: stopped before the session's end{kept}", file=sys.stderr)
        return 130
    except OSError as error:
        print(f"demo: {error.filename or options.out}: {error.strerror or error}", file=sys.stderr)
    except (GraphError, LeverError, MachineError) as error:
        print(f"demo: {error}", file=sys.stderr)
    return 1


def _leave(number: int, _frame: object) -> None:
    """End at once, from whatever library code the signal met: nothing runs, and the bag is closed."""
    os.write(2, b"\ndemo: stopped; the bag is kept if there was a session\n")
    os._exit(128 + number)


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/demo.sh", description="Drive a session on the simulated crane."
    )
    graph.add_graph_options(parser)
    parser.add_argument(
        "--duration",
        type=number(0.5, 86400.0, "s"),
        metavar="S",
        help="length of the session (default: 10, or the CSV's)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("bags/demo"),
        metavar="DIR",
        help="directory to be made (default: %(default)s)",
    )
    parser.add_argument(
        "--lockstep",
        action="store_true",
        help="all nodes wait for each other in every step: the same bag every time, at the computer's speed",
    )
    parser.add_argument(
        "--guard",
        type=number(0.1, 3600.0, "s"),
        default=GUARD,
        metavar="S",
        help="in lockstep: end a run when a message is missing for this time (default: %(default)g)",
    )
    _add_session(parser)
    return parser.parse_args(arguments)


def _add_session(parser: argparse.ArgumentParser) -> None:
    """Add the flags of what happens in the session."""
    parser.add_argument(
        "--joystick",
        type=graph.source_path,
        default="thesis",
        metavar="thesis|FILE.csv|BAG",
        help="motion of the levers: the thesis' input, a CSV or a bag (default: %(default)s)",
    )
    parser.add_argument(
        "--joystick-faults",
        type=partial(_parsed, parse_joystick_faults),
        default="",
        metavar="TEXT",
        help="faults of its link, such as 'lost from 3 s until 4 s'",
    )
    parser.add_argument(
        "--loads",
        type=partial(_parsed, parse_loads),
        default="",
        metavar="TEXT",
        help="logs in the head, such as '500 kg from 2 s; 0 kg from 6 s'",
    )


def _parsed(parse: Callable[[str], object], text: str) -> str:
    """Return a text that a node will understand."""
    try:
        parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _demo(options: argparse.Namespace) -> int:
    machine = load_machine(options.machine)
    duration = options.duration or _length(options.joystick)
    if options.out.exists():
        raise GraphError(f"{options.out} exists already; choose another --out or remove it")
    bag = options.out / BAG
    profile = profile_for(options.joystick, options.profile)
    nodes = [
        graph.joystick(options.joystick, duration, LISTENERS, options.joystick_faults),
        *graph.control(options.machine, options.scheme, False, False, profile),
        graph.simulator(options.machine, options.loads),
        graph.recorder(bag),
    ]
    logs = options.out / "log"
    if options.lockstep:
        nodes = in_lockstep(nodes, _steps(options.joystick, duration), options.guard)
    print(f"starting {', '.join(node.name for node in nodes)}", flush=True)
    try:
        with Supervisor(nodes, options.namespace, logs) as running:
            if options.lockstep:
                running.run(until=RECORDER)
            else:
                running.run(until="joystick", progress=Progress(duration, logs / "joystick.log"))
    except AlreadyRunning:
        if not bag.exists():  # nothing has begun: the same command shall work once the other graph is gone
            shutil.rmtree(options.out, ignore_errors=True)
        raise
    print("\nreading the bag, drawing the pictures", flush=True)
    summary = {
        "duration_s": duration,
        "scheme": options.scheme,
        "machine": machine.name,
        "joystick": options.joystick,
        "exit_codes": running.exit_codes,
        "peak_memory_mb": running.peak_memory_mb,
        "bag": str(bag),
    }
    return _finish(options, summary, bag, dict(zip(AXES, joint_limits(machine), strict=True)))


def _length(joystick: str) -> float:
    """Return how long a joystick source is [s]."""
    if joystick == "thesis":
        return THESIS_DURATION
    if is_bag(Path(joystick)):
        return max(PERIOD, read_joy_record(Path(joystick)).length)
    return max(0.5, read_levers(Path(joystick)).times[-1])


def _steps(joystick: str, duration: float) -> int:
    """Return how many steps a run in lockstep takes; a bag's run has its rests at both ends already."""
    around = PERIOD if is_bag(Path(joystick)) else LEAD_IN + LEAD_OUT
    return round((duration + around) / PERIOD)


def _finish(
    options: argparse.Namespace, summary: dict[str, Any], bag: Path, limits: dict[str, tuple[float, float]]
) -> int:
    """Write summary and pictures, print the table; return the exit code."""
    # Read here, not at the top: matplotlib takes half a second that the graph's start does not have.
    from forest_bag.plots.standard_plots import draw_all
    from forest_bag.read.timeseries import read_bag
    from forest_study.demo.hand_measures import profile_of, wished
    from forest_study.demo.session_summary import bag_summary, table

    recorded, profile = read_bag(bag), profile_of(recorded_profile(bag))
    summary |= bag_summary(recorded, options.scheme, profile)
    write_json(options.out / "summary.json", summary)
    wish = None if options.scheme == "joint" else wished(recorded, profile)
    pictures = draw_all(recorded, options.out, limits, wish=wish)
    print(table(summary))
    print("\n".join(f"  {path}" for path in (bag, options.out / "summary.json", *pictures)))
    failed = {name: code for name, code in summary["exit_codes"].items() if code != 0}
    if failed:
        raise GraphError(
            f"ended badly: {', '.join(f'{name} (exit code {code})' for name, code in failed.items())}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
