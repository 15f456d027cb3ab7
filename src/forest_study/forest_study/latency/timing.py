"""`forest-study timing`: how late a live session's messages were, and what that costs the tip.

A live bag tells by its spools which voltages were in force, and by its stamps when joystick and machine
spoke. The same levers then go through the closed loop in simulated time, once on the dot and once as late as
they were: no quiet computer is needed to see what lateness does. `drawn` gives such times without a bag.

| symbol | name | unit |
|---|---|---|
| behind | of each period: states that the voltages in force had not answered yet | 1 |
| late | of each period: how long after its stamp the machine's state was there | s |
| said | when the joystick spoke, counted from the first state | s |
| x | spool; v its voltage, held for a period T: x' = v + exp(-T / lag) (x - v) | V |
"""

import argparse
from bisect import bisect_right
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from forest_bag.read.timeseries import Bag, NotInBag, read_bag
from forest_bringup.graph_lock import GraphError
from forest_control.config import controller_settings
from forest_control.config.controller_settings import operator_profile
from forest_control.operator.joystick_watch import NO_STAMP, Sample
from forest_control.operator.levers import Levers, levers_from_axes
from forest_control.operator.operator_profile import rate_mode_velocity, shaped
from forest_control.taught.tip_path import cross_track_distance
from forest_control.valve import valve_driver_parameters
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO, Floats, Vec3
from forest_msgs_py.interfaces import topics
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop.closed_loop import Joystick, Lateness, Operator, Trajectory
from forest_study.closed_loop.closed_loop import run as run_loop
from forest_study.latency import lever_delay
from forest_study.measures import deviation
from forest_study.results import new_directory, write_json

LATEST = 20  # periods: what answers older states was said at an end
STALLS, GOES_ON = 0.06, 0.45  # a driver is held up in so many periods; and for another one
UNEVEN, JOY_PERIOD = 0.003, 0.01  # [s]


class Timing(NamedTuple):
    """When joystick, machine and driver spoke."""

    behind: tuple[int, ...]
    late: tuple[float, ...]
    said: tuple[float, ...]


class Session(NamedTuple):
    """What was done in a session."""

    start: Vec3  # joint angles [rad]
    hand: Callable[[float], Levers]  # by time from the first state [s]
    armed: tuple[bool, ...]  # by period


def drawn(seconds: float, seed: int) -> Timing:
    """Return the times of a session on a busy computer: 6 % of periods begin a stall, states late by 2 ms."""
    rng, periods, behind = np.random.default_rng(seed), round(seconds / PERIOD), 0
    states = []
    for _ in range(periods):
        goes_on = rng.random() < (GOES_ON if behind else STALLS)
        behind = behind + 1 if goes_on else 0
        states.append(behind)
    late = rng.exponential(0.002, periods)
    ticks = JOY_PERIOD * np.arange(round(seconds / JOY_PERIOD))
    return Timing(tuple(states), tuple(late), tuple(np.sort(ticks + rng.exponential(UNEVEN, len(ticks)))))


def replayed(session: Session, timing: Timing, machine: Machine) -> Trajectory:
    """Run a session in simulated time with the levers as even, and the voltages as late, as said.

    Without times of the joystick the levers are those of the very moment.
    """
    heard = 0  # samples of the joystick

    def joystick(time: float) -> Joystick:
        nonlocal heard
        k = round(time / PERIOD)
        if not timing.said:
            return Operator(session.hand(time), session.armed[k])
        sent = time + (timing.late[k] if k < len(timing.late) else 0.0)
        before, heard = heard, max(heard, bisect_right(timing.said, sent))
        return [_sample(session, timing.said[n], n, session.armed[k]) for n in range(before, heard)]

    settings, drive = controller_settings.Settings(), valve_driver_parameters.Settings()
    duration = len(session.armed) * PERIOD
    late = Lateness(timing.behind, timing.late if timing.said else ())
    return run_loop(machine, joystick, duration, session.start, settings, drive, late=late, fast=True)


def _sample(session: Session, said: float, number: int, held: bool) -> Sample:
    """Return what the joystick said at a time [s]."""
    return Sample(
        received=said,
        stamp=NO_STAMP,
        heartbeat=number + 1,
        same=False,
        good=True,
        levers=session.hand(said),
        held=held,
    )


def measured(bag: Bag, machine: Machine) -> tuple[Session, Timing]:
    """Return what was done in a live bag, and when.

    Raises:
        NotInBag: the bag lacks a topic that tells.
    """
    states, joy = bag.series(topics.JOINT_STATES), bag.series(topics.JOY)
    status, true = bag.series(topics.CONTROLLER_STATUS), bag.series(topics.GROUND_TRUTH_JOINT_STATES)
    begun = int(states.time_ns[0])
    said = (joy.time_ns - begun) * 1e-9
    levers = np.array([levers_from_axes(tuple(row)) for row in joy.values.tolist()])
    armed = set(status.time_ns[status.column("armed") > 0.0].tolist())

    def hand(time: float) -> Levers:
        swing, boom, stick = (float(np.interp(time, said, levers[:, i])) for i in range(3))
        return Levers(swing, boom, stick)

    first = true.values[0]
    start = float(first[0]), float(first[1]), float(first[2])
    late = np.maximum(0.0, states.log_time_ns - states.time_ns) * 1e-9
    session = Session(start, hand, tuple(stamp in armed for stamp in states.time_ns.tolist()))
    return session, Timing(_behind(bag, machine), tuple(late.tolist()), tuple(said.tolist()))


def _behind(bag: Bag, machine: Machine) -> tuple[int, ...]:
    """Return how many periods old the state is that the voltages in force answer, by period."""
    states, spools = bag.series(topics.JOINT_STATES), bag.series(topics.AUXILIARY)
    voltages = bag.series(topics.VALVE_VOLTAGES)
    drivers = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings()).axes
    left = np.array([np.exp(-PERIOD / axis.spool.lag) if axis.spool.lag > 0.0 else 0.0 for axis in drivers])
    place = dict(zip(spools.time_ns.tolist(), spools.values[:, :3], strict=True))
    said: dict[int, Floats] = dict(zip(voltages.time_ns.tolist(), voltages.values, strict=True))
    step = round(PERIOD * 1e9)
    found = []
    for stamp in states.time_ns.tolist():
        here, there = place.get(stamp), place.get(stamp + step)
        older = [said.get(stamp - n * step) for n in range(LATEST)]
        if here is None or there is None or older[0] is None:
            found.append(0)
            continue
        given = (there - left * here) / (1.0 - left)
        off = [np.inf if volts is None else float(np.abs(volts - given).max()) for volts in older]
        found.append(int(np.argmin(off)))
    return tuple(found)


def score(moved: Trajectory, session: Session) -> dict[str, dict[str, float]]:
    """Return the tip's distances from governed reference, drawn path and wish [mm] (`measures`)."""
    profile = operator_profile(controller_settings.Settings())
    asked = [
        rate_mode_velocity(shaped(session.hand(time), profile), ZERO, profile) if armed else ZERO
        for time, armed in zip(moved.time.tolist(), session.armed, strict=True)
    ]
    wish = moved.tip[0] + np.vstack([np.zeros(3), np.cumsum(asked[:-1], axis=0) * PERIOD])
    away = {
        "governed": np.linalg.norm(moved.tip_error(), axis=1),
        "cross_track": cross_track_distance(wish, moved.tip),
        "wish": np.linalg.norm(moved.tip - wish, axis=1),
    }
    found = {name: deviation(error) for name, error in away.items()}
    return {name: {"rms": round(one.rms_mm, 2), "max": round(one.max_mm, 2)} for name, one in found.items()}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("bag", type=Path, metavar="BAG", help="bag of a live session on the simulator")
    parser.add_argument("--machine", required=True, metavar="NAME|FILE", help="machine of the session")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        GraphError: there is no bag, or not what tells the times; the machine's spools do not tell them.
        MachineError: the machine's file cannot be read.
        StudyError: the directory is not empty.
    """
    new_directory(options.out)
    machine = load_machine(options.machine)
    _refuse_other_spools(machine)
    try:
        bag = read_bag(options.bag)
        session, timing = measured(bag, machine)
        felt = lever_delay.lever_to_valve_ms(bag)
    except (FileNotFoundError, NotInBag) as error:
        raise GraphError(f"timing: {error}") from error
    report = {"lever_to_valve_ms": felt, **compared(session, timing, machine)}
    write_json(options.out / "timing.json", report)
    print(table(report))
    print(f"  {options.out / 'timing.json'}")
    return 0


def _refuse_other_spools(machine: Machine) -> None:
    """Refuse a machine whose spools do more than follow by a lag: they do not tell the voltage in force.

    Raises:
        GraphError: it is one.
    """
    for valve in map(machine.valve_of, range(3)):
        if valve.hysteresis or valve.dead_time or valve.spool_slew_limit:
            raise GraphError(
                f"timing: the spools of {machine.name} have play, dead time or a slew limit, and do not tell "
                "the voltages in force; allowed: a session of a machine without, as c180_hoses"
            )


def compared(session: Session, timing: Timing, machine: Machine) -> dict[str, Any]:
    """Return what the session is on the dot, and with levers, voltages and both as late as they were."""
    counts = np.bincount(timing.behind).tolist()
    even, on_time = timing._replace(said=()), timing._replace(behind=())
    ways = {
        "on the dot": even._replace(behind=()),
        "levers uneven": on_time,
        "voltages late": even,
        "both": timing,
    }
    return {
        "periods_behind": counts,
        **{name: score(replayed(session, way, machine), session) for name, way in ways.items()},
    }


def table(report: dict[str, Any]) -> str:
    """Return a Markdown table."""
    counts: Sequence[int] = report["periods_behind"]
    lines = [
        f"voltages in force answer a state 0, 1, 2, ... periods old: {', '.join(map(str, counts))} times"
    ]
    lines += [f"{name}: {told}" for name, told in lever_delay.rows(report["lever_to_valve_ms"])]
    lines += ["| RMS / max, mm | governed | cross-track | wish |", "|---|---|---|---|"]
    for name, one in report.items():
        if name not in ("periods_behind", "lever_to_valve_ms"):
            cells = [f"{off['rms']:.1f} / {off['max']:.1f}" for off in one.values()]
            lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)
