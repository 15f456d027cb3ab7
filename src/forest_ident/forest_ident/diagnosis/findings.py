"""What the monitor's sums and sensors mean: causes by name, each with what it may be confused with."""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from forest_description.types import AXES
from forest_ident.diagnosis import sensor_watch
from forest_ident.diagnosis.monitor import Parameters, State
from forest_ident.diagnosis.monitor_readings import CHANNELS
from forest_ident.diagnosis.residuals import NAMES
from forest_ident.diagnosis.sequential_test import Limits, score
from forest_ident.diagnosis.signatures import CAUSES, MACHINE_FILE, SENSOR_FROZEN, SENSOR_LOST, Cause

MACHINE, SENSORS = "machine", "sensors"
MOST = 4  # sensors that are named
# Residuals whose tolerance a machine file must keep.
OF_FILE = ("gain", "deadband", "follow", "agree", "drain", "meter")
SEVERAL = 2  # axes; one, where a flow meter and a length sensor contradict the file's area
METER = "meter"


class Finding(NamedTuple):
    """One thing that is wrong."""

    part: str  # an axis, `MACHINE` or `SENSORS`
    cause: str
    text: str
    alike: str
    advice: str
    score: float  # [1] of the alarm's threshold; 1 of a sensor that is frozen or missing

    def __str__(self) -> str:
        """Return it as a person is told."""
        alike = f" (or {self.alike})" if self.alike else ""
        return f"{self.text}{alike}: {self.advice}"


class Alarms(NamedTuple):
    """What has moved, and which sensors are out."""

    residuals: Mapping[str, float]  # scores with their signs, beyond 1 either way
    frozen: Sequence[str]
    missing: Sequence[str]
    at_start: Sequence[str] = ()  # residuals that were out of tolerance when they were learnt


def alarms(state: State, p: Parameters) -> Alarms:
    """Return what has moved beyond its threshold."""
    scores = {name: score(test, of) for name, test, of in zip(NAMES, state.tests, p.limits, strict=True)}
    watched = list(zip(CHANNELS, state.sensors, p.machine.fitted, strict=True))
    missing = [name for name, sensor, fitted in watched if sensor_watch.is_missing(sensor, fitted)]
    frozen = [name for name, sensor, _ in watched if sensor_watch.is_frozen(sensor) and name not in missing]
    out = out_from_the_start([test.mean for test in state.tests], p.limits)
    return Alarms({name: x for name, x in scores.items() if abs(x) >= 1.0}, frozen, missing, out)


def out_from_the_start(references: Sequence[float], limits: Sequence[Limits]) -> list[str]:
    """Return the residuals whose reference is beyond what a healthy machine may be off.

    Args:
        references: of the tests, in the order and units of `residuals.NAMES`.
        limits: of the same.
    """
    rows = zip(NAMES, references, limits, strict=True)
    return [name for name, mean, of in rows if of.tolerance > 0.0 and abs(mean) > of.tolerance]


def findings(told: Alarms) -> list[Finding]:
    """Return what is wrong, sensors first, then axis by axis."""
    found = [*_sensors(told.missing, "missing", SENSOR_LOST), *_sensors(told.frozen, "frozen", SENSOR_FROZEN)]
    blind = {_axis_of(name) for name in told.frozen}  # residuals of what is missing are silent by themselves
    off_file = _off_file(told, blind)
    moved = {name: x for name, x in told.residuals.items() if not (off_file and METER in name)}
    for part in (*AXES, MACHINE):
        if part not in blind:
            found += _causes(part, _of_part(part, moved))
    return _with_file(found, off_file)


def _sensors(names: Sequence[str], cause: str, words: tuple[str, str]) -> list[Finding]:
    """Return one finding for all sensors that are missing, or frozen."""
    if not names:
        return []
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return [Finding(SENSORS, cause, f"{', '.join(names[:MOST])}{more}: {words[0]}", "", words[1], 1.0)]


def _axis_of(sensor: str) -> str:
    """Return what a sensor's failure makes doubtful: its axis; of the supply's transducer, the machine."""
    return next((axis for axis in AXES if sensor.startswith(axis)), MACHINE)


def _of_part(part: str, residuals: Mapping[str, float]) -> dict[str, float]:
    """Return a part's alarms by what they are, as "lost_1-", and their size."""
    found = {}
    for name, x in residuals.items():
        own = next((axis for axis in AXES if name.startswith(f"{axis}_")), MACHINE)
        if own == part:
            what = name.removeprefix(f"{part}_")
            if what.endswith("_pair"):
                what = "pair_" + what.removeprefix("pressure_").removesuffix("_pair")
            found[what + ("+" if x > 0.0 else "-")] = abs(x)
    return found


def _causes(part: str, there: Mapping[str, float]) -> list[Finding]:
    """Return the causes of a part's alarms that no other of them hides."""
    found: list[tuple[Cause, float]] = []
    for cause in CAUSES:
        if cause.of_axis != (part != MACHINE):
            continue
        sizes = [
            min(there[x] for x in pattern) for pattern in cause.patterns if all(x in there for x in pattern)
        ]
        if sizes and not any(cause.name in other.hides for other, _ in found):
            found.append((cause, max(sizes)))
    hidden = {name for cause, _ in found for name in cause.hides}
    return [
        Finding(part, cause.name, cause.text.format(axis=part), cause.alike, cause.advice, size)
        for cause, size in found
        if cause.name not in hidden
    ]


def _off_file(told: Alarms, blind: Collection[str]) -> dict[str, float]:
    """Return what was out from the start, and its size, where that makes a machine file wrong; else nothing.

    A meter that differs from area times speed since the start is no leak that came: the file is first.
    """
    out = [name for name in told.at_start if name in told.residuals and any(part in name for part in OF_FILE)]
    sizes = {name: abs(told.residuals[name]) for name in out if _axis_of(name) not in blind}
    axes = {_axis_of(name) for name in sizes} - {MACHINE}
    return sizes if len(axes) >= SEVERAL or any(METER in name for name in sizes) else {}


def _with_file(found: list[Finding], off_file: Mapping[str, float]) -> list[Finding]:
    """Return findings, those of a wrong machine file put together and first."""
    if not off_file:
        return found
    cause, size = MACHINE_FILE, max(off_file.values())
    rest = [one for one in found if one.cause not in cause.hides]
    return [Finding(MACHINE, cause.name, cause.text, cause.alike, cause.advice, size), *rest]
