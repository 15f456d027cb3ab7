"""The closed loop from a notebook: a machine, a loop, a trace of a run, its picture.

    loop = closed_loop("c180_hoses", scheme="coordinated")
    trace = loop.follow("circle_h", speed=0.5, seed=3)
    trace["tip"]     # [N, 3] m
    trace.plot()

The loop is that of `forest-study track`: machine, sensors, guarded controller and valve driver, compiled.
The same arguments give the same numbers, to the last bit. Axes are swing, boom, stick; x lies ahead of the
crane, y to its left, z up.
"""

import dataclasses
import math
import numbers
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from forest_control.config.controller_settings import Settings
from forest_control.operator.operator_profile import Mode
from forest_control.servo.schemes import LABELS, scheme_named
from forest_control.taught.tip_path import TipPath, polyline
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, Floats, Vec3
from forest_msgs_py.interfaces.topics import PRESSURES
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_suite import Suite, sensor_suite
from forest_study.closed_loop import compiled_loop, model_mismatch
from forest_study.closed_loop.closed_loop import Trajectory
from forest_study.closed_loop.model_mismatch import Ranges
from forest_study.sweep.changes import changed_settings
from forest_study.tracking.paths import path_named
from forest_study.tracking.scores import Score
from forest_study.tracking.tracking import Session, follow, noisy, prepare

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TIP = ("x", "y", "z")
LEAST = 2  # rows of a drive: a reference needs two
MOST_LAPS = 1000  # [1] as of `forest-study track`
MOST_SEED = 2**31 - 1  # [1] as of a sweep
LONGEST = 86_400.0  # [s] of a drive: a day takes 0.6 GB for the levers alone


class Quantity(NamedTuple):
    """What an array of a trace holds."""

    unit: str
    columns: tuple[str, ...]  # none: one number a row
    meaning: str


QUANTITIES = {
    "time": Quantity("s", (), "since the start of the run"),
    "levers": Quantity("1", AXES, "deflections, -1..1"),
    "angles": Quantity("rad", AXES, "true joint angles"),
    "tip": Quantity("m", TIP, "true place of the tip"),
    "reference": Quantity("m", TIP, "the command behind every limit, integrated"),
    "reference_velocity": Quantity("m/s", TIP, "the command behind every limit"),
    "commands": Quantity("V", AXES, "commands to ideal valves"),
    "voltages": Quantity("V", AXES, "at the valves"),
    "pressures": Quantity("Pa", PRESSURES.labels, "as the sensors read them: axis, port, place"),
}


class Now(NamedTuple):
    """What an operator sees before a period: the crane as it was a period ago."""

    time: float  # [s] at which the levers act
    angles: Vec3  # [rad] true
    tip: Vec3  # [m] true


Operator = Callable[[Now], Sequence[float]]
"""Gives the levers of swing, boom, stick, -1..1, from what is seen."""


@dataclasses.dataclass(frozen=True)
class Trace:
    """A run, a row each 5 ms.

    `trace["tip"]` is an array; `QUANTITIES` names them all, with unit and columns.
    """

    moved: Trajectory
    levers: Floats  # [N, 3]
    session: Session | None = None  # of a run along a path

    @property
    def score(self) -> Score | None:
        """How far the tip was off a path, in mm, m/s and s; none of a run without a path."""
        return self.session.total if self.session else None

    def __getitem__(self, name: str) -> Floats:
        """Return an array of N rows.

        Raises:
            KeyError: there is none of this name.
        """
        if name not in QUANTITIES:
            raise KeyError(f"{name!r}; allowed: {', '.join(QUANTITIES)}")
        if name == "levers":
            return self.levers
        if name == "reference":
            return self.moved.tip - self.moved.tip_error()
        field = {"reference_velocity": "tip_wish"}.get(name, name)
        found: Floats = getattr(self.moved, field)
        return found

    def table(self) -> dict[str, Floats]:
        """Return every column [N] by its name and unit, as "tip_x [m]": a table for pandas or a file."""
        found: dict[str, Floats] = {}
        for name, (unit, columns, _) in QUANTITIES.items():
            values = self[name].reshape(len(self.levers), -1).T
            names = [f"{name}_{column}" for column in columns] or [name]
            found |= {f"{one} [{unit}]": column for one, column in zip(names, values, strict=True)}
        return found

    def plot(self, file: str | Path | None = None) -> "list[Axes]":
        """Draw the tip from above and from the side, its errors and the valves' voltages.

        Args:
            file: where the picture is left, as PNG, SVG or PDF by its suffix; default: shown only.

        Returns:
            the four axes, to be changed.
        """
        from matplotlib import pyplot as plt  # half a second; its backend is the notebook's

        from forest_study.tracking.track_plot import SIZE, fill

        figure = plt.figure(figsize=SIZE, layout="constrained")
        fill(figure, self.moved, self.session)
        if file is not None:
            figure.savefig(file)
        return figure.axes

    def __repr__(self) -> str:
        rows = [f"{len(self.levers)} rows of {PERIOD:g} s"]
        for name, (unit, columns, meaning) in QUANTITIES.items():
            rows.append(f"  {name:18} {self[name].shape!s:11} [{unit}] {meaning}: {', '.join(columns)}")
        return "\n".join(row.rstrip(": ") for row in rows)


@dataclasses.dataclass(frozen=True)
class Loop:
    """A machine under control; `closed_loop` makes it."""

    machine: Machine  # what is simulated
    model: Machine  # what controller and driver believe
    settings: Settings  # of the controller
    driver: valve_driver_parameters.Settings  # of the valve driver
    mismatch: Ranges | None = None  # within which a seed draws the simulated machine

    def follow(
        self,
        path: str | Path | TipPath | ArrayLike,
        speed: float = 0.5,
        laps: int = 1,
        seed: int | None = None,
    ) -> Trace:
        """Lead the tip along a path; it starts at rest at the path's start.

        Args:
            path: sweep, radial, vertical, circle_h, circle_v; a CSV file of waypoints x,y,z [m]; or
                waypoints [K, 3] m.
            speed: wished speed of the tip [m/s].
            laps: how often; an open path is gone back and forth.
            seed: of the sensors' noise and of what `mismatch` draws; default: exact sensors.

        Raises:
            PathError: the path cannot be read, leaves the reach, or is not ended.
            ValueError: the scheme is joint, the mode position, waypoints are not [K, 3], or a number is none
                that is allowed.
        """
        if self.settings.scheme == scheme_named("joint"):
            raise ValueError("the scheme joint follows no path of the tip; allowed: the others, or drive()")
        if self.settings.mode != Mode.RATE:
            raise ValueError("the mode position follows no path of the tip; allowed: rate, or drive()")
        _require_whole("laps", laps, 1, MOST_LAPS)
        if not _is_number(speed):
            raise ValueError(f"speed {speed!r}; allowed: a number above 0 m/s")
        course = prepare(_path(path), speed, self.settings.scheme, self.model, laps)
        course = course._replace(settings=self.settings._replace(tip_speed=speed), drive=self.driver)
        session = follow(course, self.machine, self._suite(seed), self.driver.adapt, self._plant(seed))
        return Trace(session.moved, session.led.levers[:, :3], session)

    def drive(
        self,
        levers: Operator | ArrayLike,
        seconds: float | None = None,
        start: Sequence[float] | None = None,
        seed: int | None = None,
    ) -> Trace:
        """Drive by levers of your own, the deadman held.

        Args:
            levers: a function of what is seen (`Now`), asked in each period of 5 ms; or deflections
                [N, 3], a row a period. Deflections beyond 1 count as 1, as of a joystick.
            seconds: duration; needed with a function.
            start: where the tip is at rest [m]; default: the machine's own.
            seed: as of `follow`.

        Raises:
            ValueError: the levers are not three finite numbers a row, no duration above 0 is known, or the
                start is out of reach.
        """
        operator, rows = _operator(levers, seconds)
        at = start_tip(self.machine) if start is None else _three(start, f"start {start!r}")
        held, pose = np.tile(np.array([0.0, 0.0, 0.0, 1.0]), (rows, 1)), pose_at(at, self.machine)
        given = self.machine, held, pose, self.settings, self.driver, self.model
        session = compiled_loop.Session(compiled_loop.prepared(*given, self._suite(seed), self._plant(seed)))
        seen = Now(0.0, pose, tip_position(pose, self.machine.manipulator.links))
        for row in range(rows):
            session.levers[row, :3] = _deflections(operator(seen), row)
            session.advance(row + 1)
            last = session.newest
            seen = Now((row + 1) * PERIOD, last.angles, last.tip)
        return Trace(session.moved, session.levers[:, :3])

    def _suite(self, seed: int | None) -> Suite:
        if seed is not None:
            _require_whole("seed", seed, 0, MOST_SEED)
        return sensor_suite(self.machine) if seed is None else noisy(self.machine, seed)

    def _plant(self, seed: int | None) -> Any:
        if self.mismatch is None:
            return None
        return model_mismatch.applied(self.machine, model_mismatch.draw(seed or 0, self.mismatch))


def machine(name: str | Path) -> Machine:
    """Return a machine: shipped under a name, or from a file.

    Raises:
        MachineError: there is none, or the file is not usable; one sentence says why.
    """
    return load_machine(name)


def closed_loop(
    machine: Machine | str | Path,
    scheme: str = "coordinated",
    model: Machine | str | Path | None = None,
    mismatch: Ranges | None = None,
    adapt: bool = True,
    **settings: Any,
) -> Loop:
    """Return a machine under control.

    Args:
        machine: what is simulated.
        scheme: control scheme: coordinated, joint, or one of the thesis' four.
        model: what controller and driver believe; default: the machine.
        mismatch: how far the simulated machine may be off, drawn by each run's seed; default: not.
        adapt: the valve driver learns its valves' deadbands and gains.
        settings: of the controller, by name: the node's parameters, as `feedback_gain=(4.0, 6.0, 6.0)`.

    Raises:
        MachineError: a machine is not usable.
        ParameterError: a setting is unknown, or its value is not allowed.
        ValueError: the scheme is unknown, a range is out of its own, or `adapt` is neither True nor False.
    """
    if not isinstance(adapt, bool):
        raise ValueError(f"adapt {adapt!r}; allowed: True, False")
    if mismatch is not None:
        if not isinstance(mismatch, Ranges) or not all(x is None or _is_number(x) for x in mismatch):
            raise ValueError(f"mismatch {mismatch!r}; allowed: Ranges of numbers, as Ranges(head_mass=2.0)")
        model_mismatch.require_ranges(mismatch)
    if scheme not in LABELS:
        raise ValueError(f"scheme {scheme!r}; allowed: {', '.join(LABELS)}")
    simulated = machine if isinstance(machine, Machine) else load_machine(machine)
    believed = model if isinstance(model, Machine) else load_machine(model) if model else simulated
    chosen = changed_settings(Settings(scheme=scheme_named(scheme)), settings)
    return Loop(simulated, believed, chosen, valve_driver_parameters.Settings(adapt=adapt), mismatch)


def _path(path: str | Path | TipPath | ArrayLike) -> TipPath:
    if isinstance(path, TipPath):
        return path
    if isinstance(path, (str, Path)):
        return path_named(str(path))
    points = _array(path)
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ValueError(f"waypoints {_shape(points)}; allowed: rows of three finite x, y, z [m]")
    return polyline("waypoints", [(x, y, z) for x, y, z in points.tolist()])


def _operator(levers: Operator | ArrayLike, seconds: float | None) -> tuple[Operator, int]:
    """Return who says the levers, and for how many periods."""
    if seconds is not None and not (_is_number(seconds) and 0.0 < seconds <= LONGEST):
        raise ValueError(f"seconds {seconds!r}; allowed: above 0, at most {LONGEST:g}")
    if callable(levers):
        if seconds is None:
            raise ValueError("a function of levers needs seconds, how long it drives")
        return levers, max(LEAST, round(seconds / PERIOD))
    table = _array(levers)
    if table.ndim != 2 or table.shape[1] != 3 or len(table) < LEAST:
        raise ValueError(f"levers {_shape(table)}; allowed: [N, 3], a row of 5 ms, two at the least")
    rows = len(table) if seconds is None else min(len(table), max(LEAST, round(seconds / PERIOD)))
    return (lambda seen: table[round(seen.time / PERIOD)]), rows


def _deflections(said: Sequence[float], row: int) -> Floats:
    """Return three deflections as a joystick has them."""
    three = _three(said, f"at {row * PERIOD:g} s the levers are {said!r}")
    return np.array(three).clip(-1.0, 1.0)


def _three(said: ArrayLike, what: str) -> Vec3:
    """Return three finite numbers, or raise ValueError."""
    found = _array(said)
    if found.shape != (3,) or not np.isfinite(found).all():
        raise ValueError(f"{what}; allowed: three finite numbers")
    return float(found[0]), float(found[1]), float(found[2])


def _array(said: ArrayLike) -> Floats:
    """Return what was given as an array of numbers; a single NaN where it is none."""
    try:
        found = np.asarray(said)
    except ValueError:  # rows of several lengths
        return np.array(math.nan)
    return found.astype(np.float64) if found.dtype.kind in "biuf" else np.array(math.nan)


def _shape(found: Floats) -> str:
    """Return what is told of an array that cannot be."""
    return f"have shape {found.shape}" if found.ndim else "are no table of numbers"


def _is_number(value: object) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _require_whole(name: str, value: object, low: int, high: int) -> None:
    if not isinstance(value, numbers.Integral) or isinstance(value, bool) or not low <= int(value) <= high:
        raise ValueError(f"{name} {value!r}; allowed: a whole number, {low} .. {high}")
