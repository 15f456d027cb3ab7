"""How the tip stops when the deadman is let go at random moments of random motions.

A motion starts at rest anywhere between the limits, with sensor noise; one to three random wishes follow,
each for 0.15 to 1.5 s; then the deadman is let go, the levers stay where they are. Controller and driver
believe the machine as its file has it. Both machines, and every row, get the same motions by number.

| column | says (median / 95 % / worst) |
|---|---|
| s | until the tip is slower than 0.05 m/s |
| mm | its greatest way along the direction that it had, within 0.5 s |
| beside | its greatest way beside that line, within 0.5 s |
| rocks | of how many motions the tip was faster than 0.05 m/s at any time from 0.25 s to 1.5 s |
| over | motions over 0.25 s / over 70 mm |
| rock | its greatest distance from its mean place of 1 to 1.5 s, from 0.25 s on |
| peak | its greatest speed before the release, m/s |

Rows of the matrix draw another plant for every motion, as `forest-study matrix` does in its row "both".

Motions whose tip was slower than 0.05 m/s when the deadman was let go do not count.
"""

import argparse
import json
import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_control.config import controller_settings
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits
from forest_description.derived.temperature import at_temperature
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import PlantParameters, plant_parameters
from forest_sim.sensors.sensor_readings import true_joints
from forest_sim.solver.compiled_plant import compiled_advance
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator, Trajectory
from forest_study.closed_loop.loop_core import SUBSTEPS
from forest_study.closed_loop.model_mismatch import applied, draw
from forest_study.matrix.matrix_rows import matrix_rows
from forest_study.tracking.tracking import noisy

Floats = NDArray[np.float64]
MACHINES = ("c180_hoses", "loader")
STREAM = 77  # of a motion's draws; a sensor suite's are others
BEFORE, AFTER, JUDGED = 20, 300, 100  # periods at rest, recorded after the release, judged for the way
SLOW = 0.05  # [m/s] a tenth of 0.5 m/s
WITHIN, NO_FARTHER = 0.25, 0.07  # [s], [m] of a stop
CLEAR = math.radians(2.0)  # of the limits, where a motion starts


class Row(NamedTuple):
    """One row of the table: what is simulated, and how it is driven."""

    title: str
    changed: Callable[[Machine], Machine]
    speed: float = 0.5  # [m/s]
    scheme: Scheme = Scheme.COORDINATED
    emergency: bool = False  # zero voltage instead of the stop along the path
    drawn: bool = False  # every motion has another plant
    acceleration: float = -1.0  # [m/s^2] of the reference; negative: by the machine's rule


class Motion(NamedTuple):
    """What is done by number."""

    start: tuple[float, float, float]  # [rad]
    levers: Floats  # [N, 4] with the deadman
    released: int  # row


class Stop(NamedTuple):
    """How a motion ended."""

    speed: float  # [m/s] at the release
    time: float  # [s]
    way: float  # [m]
    beside: float  # [m]
    later: float  # [m/s] greatest speed after `WITHIN`
    rock: float  # [m] greatest distance from its place at rest after `WITHIN`
    margin: float  # [rad] least, of all joints
    peak: float  # [m/s] of the tip before the release
    shut: float  # [s] after the release, from when on no valve is open


def _arm(**named: float) -> Callable[[Machine], Machine]:
    return lambda m: replace(m, manipulator=replace(m.manipulator, **named))


def _heavy(m: Machine) -> Machine:
    return _arm(head_mass=2.0 * m.manipulator.head_mass)(m)


def _slow_pump(m: Machine) -> Machine:
    return replace(m, pump=replace(m.pump, shaft_speed=0.5 * m.pump.shaft_speed))


def _oil(celsius: float) -> Callable[[Machine], Machine]:
    return lambda m: at_temperature(m, 273.15 + celsius)


def _same(m: Machine) -> Machine:
    return m


ROWS = {
    "exact": Row("as the model", _same),
    "head": Row("twice the head's mass, unknown", _heavy),
    "tilt": Row("platform tilted by 10°, unknown", _arm(platform_tilt=math.radians(10.0))),
    "pump": Row("pump at half speed, unknown", _slow_pump),
    "cold": Row("oil of 0 °C, unknown", _oil(0.0)),
    "hot": Row("oil of 80 °C, unknown", _oil(80.0)),
    "fast": Row("1 m/s", _same, 1.0),
    "emergency": Row("emergency stop", _same, emergency=True),
    "matrix": Row("plants of the matrix", _same, drawn=True),
    "matrix-emergency": Row("plants of the matrix, emergency stop", _same, emergency=True, drawn=True),
    "quick": Row("`tip_acceleration` 4 m/s²", _same, acceleration=4.0),
    "joint": Row("`joint`, levers up to full", _same, 0.5, Scheme.JOINT),
}


def motion(machine: Machine, number: int, speed: float) -> Motion:
    """Return a motion of a machine with wishes of 0.4 to 1 times a speed [m/s], often that speed itself."""
    chance = np.random.default_rng([number, STREAM])
    low, high = np.array(joint_limits(machine)).T
    one, two, three = chance.uniform(low + CLEAR, high - CLEAR).tolist()
    rows = [[0.0, 0.0, 0.0, 1.0]] * BEFORE
    for _ in range(int(chance.integers(1, 4))):
        wish = chance.normal(size=3)
        wish *= speed * min(1.0, chance.uniform(0.4, 1.6)) / np.linalg.norm(wish)
        levers = levers_for_tip_velocity(tuple(wish.tolist()), speed)
        rows += [[*levers, 1.0]] * round(chance.uniform(0.15, 1.5) / PERIOD)
    released = len(rows)
    rows += [[*levers, 0.0]] * AFTER
    return Motion((one, two, three), np.array(rows), released)


def run(machine: Machine, model: Machine, number: int, row: Row) -> tuple[Trajectory, int]:
    """Return a motion's session, and the row in which the deadman is let go."""
    done, settings = motion(model, number, row.speed), _settings(row)
    plant = plant_parameters(machine)
    if row.drawn:
        plant = applied(machine, draw(number, matrix_rows()["both"].ranges))
    if row.emergency:
        return slammed(machine, done, settings, number, plant), done.released
    given = (
        machine,
        done.levers,
        done.start,
        settings,
        valve_driver_parameters.Settings(),
    )
    return compiled_loop.run(*given, model=model, suite=noisy(machine, number), plant=plant), done.released


def _settings(row: Row) -> controller_settings.Settings:
    return controller_settings.Settings(
        tip_speed=row.speed, scheme=row.scheme, tip_acceleration=row.acceleration
    )


def slammed(
    machine: Machine,
    done: Motion,
    settings: controller_settings.Settings,
    number: int,
    plant: PlantParameters,
) -> Trajectory:
    """Return a session whose valves get zero voltage when the deadman would be let go."""
    control = controller_settings.parameters(machine, settings)
    drive = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
    links, rows = machine.manipulator.links, []
    loop = ClosedLoop(plant, control, drive, done.start, noisy(machine, number), fast=True)
    for *levers, held in done.levers[: done.released].tolist():
        happened = loop.period(Operator(Levers(*levers), held > 0.0))
        rows.append(happened._replace(tip=tip_position(happened.angles, links)))
    simulation, advance = loop.simulation, compiled_advance()
    for _ in range(AFTER):
        angles = true_joints(simulation, plant).position
        rows.append(
            happened._replace(angles=angles, tip=tip_position(angles, links), command=ZERO, voltages=ZERO)
        )
        simulation = advance(simulation, ZERO, PERIOD / SUBSTEPS, SUBSTEPS, plant)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    return Trajectory(PERIOD * np.arange(len(rows), dtype=np.float64), *columns)


def stop_of(moved: Trajectory, released: int, machine: Machine) -> Stop:
    """Return how a session ended."""
    velocity = np.gradient(moved.tip, PERIOD, axis=0)
    before = velocity[released - 2 : released + 1].mean(axis=0)
    speeds, late = np.linalg.norm(velocity[released:], axis=1), round(WITHIN / PERIOD)
    way = (moved.tip[released:] - moved.tip[released])[: JUDGED + 1]
    along = before / max(1e-9, np.linalg.norm(before))
    forward = way @ along
    low, high = np.array(joint_limits(machine)).T
    open_valves = np.flatnonzero(moved.voltages[released:].any(axis=1))
    return Stop(
        speed=float(np.linalg.norm(before)),
        time=PERIOD * float(np.argmax(speeds < SLOW)) if (speeds < SLOW).any() else PERIOD * AFTER,
        way=float(forward.max()),
        beside=float(np.linalg.norm(way - np.outer(forward, along), axis=1).max()),
        later=float(speeds[late:].max()),
        rock=float(
            np.linalg.norm(moved.tip[released + late :] - moved.tip[-JUDGED:].mean(axis=0), axis=1).max()
        ),
        peak=float(np.linalg.norm(velocity[:released], axis=1).max()),
        margin=float(np.minimum(moved.angles - low, high - moved.angles).min()),
        shut=PERIOD * float(open_valves[-1] + 1) if len(open_valves) else 0.0,
    )


def stops(name: str, row: Row, motions: int) -> list[Stop]:
    """Return how so many motions of a machine ended, without those that hardly moved."""
    model = load_machine(name)
    machine = row.changed(model)
    ended = [stop_of(*run(machine, model, number, row), machine) for number in range(motions)]
    return [stop for stop in ended if stop.speed > SLOW]


def cells(ended: list[Stop]) -> list[str]:
    """Return a machine's columns."""

    def spread(values: Iterable[float], text: str) -> str:
        return " / ".join(format(x, text) for x in np.quantile(list(values), [0.5, 0.95, 1.0]))

    late, far = sum(stop.time > WITHIN for stop in ended), sum(stop.way > NO_FARTHER for stop in ended)
    rocks = sum(stop.later >= SLOW for stop in ended) / len(ended)
    return [
        spread((stop.time for stop in ended), ".2f"),
        spread((1e3 * stop.way for stop in ended), ".0f"),
        spread((1e3 * stop.beside for stop in ended), ".0f"),
        f"{late} / {far} of {len(ended)}",
        f"{rocks:.0%}".replace("%", " %"),
        spread((1e3 * stop.rock for stop in ended), ".0f"),
        spread((stop.peak for stop in ended), ".2f"),
    ]


def summary(ended: dict[str, list[Stop]]) -> dict[str, Any]:
    """Return what holds of all rows of a machine together."""
    every = [stop for each in ended.values() for stop in each]
    return {
        "margin_deg": math.degrees(min(stop.margin for stop in every)),
        "shut_s": max(stop.shut for stop in every),
        "fastest_m_s": {name: max(stop.speed for stop in each) for name, each in ended.items()},
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    told = [key for key, row in ROWS.items() if not row.drawn]  # not every machine has a play to be drawn
    parser.add_argument("--rows", nargs="+", choices=list(ROWS), default=told)
    parser.add_argument(
        "--machines", nargs="+", default=MACHINES, metavar="NAME", help="default: %(default)s"
    )
    parser.add_argument("--motions", type=int, default=400, help="a row and machine (default: %(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="every motion's figures")
    options = parser.parse_args()
    ended: dict[str, dict[str, list[Stop]]] = {name: {} for name in options.machines}
    print(
        "| | "
        + " | ".join(
            f"{name}, s | mm | beside, mm | over | rocks | rock, mm | peak, m/s" for name in options.machines
        )
        + " |"
    )
    print("|---|" + "---|" * 7 * len(options.machines))
    for key in options.rows:
        line = [ROWS[key].title]
        for name in options.machines:
            ended[name][key] = stops(name, ROWS[key], options.motions)
            line += cells(ended[name][key])
        print("| " + " | ".join(line) + " |", flush=True)
    for name in options.machines:
        told = summary(ended[name])
        print(
            f"\n{name}: joints at least {told['margin_deg']:.2f}° from their limits, all valves shut "
            f"{told['shut_s']:.3f} s after the release; fastest tip when let go, m/s: "
            + ", ".join(f"{key} {speed:.2f}" for key, speed in told["fastest_m_s"].items())
        )
    if options.json:
        every = {n: {k: [s._asdict() for s in e] for k, e in rows.items()} for n, rows in ended.items()}
        options.json.write_text(json.dumps(every, indent=1) + "\n")


if __name__ == "__main__":
    main()
