"""What one run of a sweep is: keys that a study may set, and the figures that come of them.

A kind of trial is a table of keys and a function. Beside its keys a case may have numbers of the machine:
`machine.KEY` for what is simulated and what is believed, `plant.KEY` for what is simulated alone. Where the
kind allows it, `control.NAME` and `drive.NAME` are settings of controller and valve driver.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple

from forest_control.config import controller_settings
from forest_control.servo.schemes import LABELS, scheme_named
from forest_control.valve import valve_driver_parameters
from forest_description.machine import Machine, load_machine
from forest_msgs_py.runtime.parameter_table import Parameter
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import model_mismatch
from forest_study.closed_loop.loop_core import SUBSTEPS
from forest_study.diagnosis.detection_figures import diagnosed
from forest_study.diagnosis.faults import CASES, HEALTH
from forest_study.latency import placing
from forest_study.log_work import crane, person, site, trial, trial_measures
from forest_study.results import StudyError
from forest_study.sweep.changes import changed_machine, changed_settings
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import Course, follow, noisy, prepare

Case = Mapping[str, Any]  # values by key; machines' numbers in SI
Figures = dict[str, float]
ROUNDING = 1e-9  # [s] of a period that is told as so many steps
TIP_SCHEMES = tuple(label for label in LABELS if label != "joint")


class TrackKeys(NamedTuple):
    """A path of the tip in closed loop: `forest-study track`."""

    machine: Annotated[str, Parameter("simulated machine: shipped, unknown:SEED, or a file")] = "c180"
    model: Annotated[str, Parameter("machine file of controller and driver; empty: the simulated one")] = ""
    path: Annotated[str, Parameter("sweep, radial, vertical, circle_h, circle_v, or a CSV file")] = "sweep"
    speed: Annotated[float, Parameter("wished", "m/s", 0.01, 3.0)] = 0.5
    scheme: Annotated[str, Parameter("of control", choices=TIP_SCHEMES)] = "coordinated"
    laps: Annotated[int, Parameter("of the path; all are judged", low=1, high=1000)] = 1
    noise: Annotated[bool, Parameter("simulate the sensors' noise")] = True
    mismatch: Annotated[str, Parameter("ranges from which a seed's machine is drawn; empty: none")] = ""
    step: Annotated[float, Parameter("of the simulated machine", "s", 2.5e-4, PERIOD)] = PERIOD / SUBSTEPS


class PlacingKeys(NamedTuple):
    """A target that a simulated operator reaches: `forest-study placing`."""

    machine: Annotated[str, Parameter("shipped machine, unknown:SEED, or a file")] = "c180"
    trip: Annotated[float, Parameter("of the link, there and back", "s", 0.0, 1.0)] = 0.0


class DiagnosisKeys(NamedTuple):
    """Everyday work with the monitor beside it, and a fault in its second half."""

    machine: Annotated[str, Parameter("believed: shipped machine, unknown:SEED, or a file")] = "c180_hoses"
    case: Annotated[str, Parameter("what goes wrong, and how much", choices=CASES)] = HEALTH
    minutes: Annotated[float, Parameter("of work", "min", 2.0, 600.0)] = 10.0


class LogsKeys(NamedTuple):
    """Logs from the ground to the bunk and back: `forest-study logs`."""

    machine: Annotated[str, Parameter("shipped machine, unknown:SEED, or a file")] = "forwarder"
    mode: Annotated[str, Parameter("what the levers move", choices=crane.MODES)] = "tip"
    against: Annotated[
        str, Parameter("mode in which the same person does it, too; none: no", choices=("none", *crane.MODES))
    ] = "none"
    operator: Annotated[str, Parameter("novice, expert, or a file")] = "expert"
    trip: Annotated[float, Parameter("of the link, there and back", "s", 0.0, 1.0)] = 0.0


class Kind(NamedTuple):
    """A kind of trial."""

    keys: Any  # a table of parameters
    figures: Callable[[Case, int], Figures]
    prefixes: tuple[str, ...]  # of the dotted keys that it takes
    require_possible: Callable[[Case], None]  # raises what is wrong with a case
    batch: int = 25  # [1] runs that a worker takes at once: some two seconds of a core


def tracked(case: Case, seed: int) -> Figures:
    """Return how well a path is tracked: `scores.Score` of all laps.

    Raises:
        PathError: the path leaves the reach, or its end is not reached.
        MachineError: a machine cannot be.
    """
    keys = TrackKeys(**_own(case))
    crane = _machine(keys.machine, case, ("machine", "plant"))
    changes = (tuple(_under(case, prefix).items()) for prefix in ("machine", "control", "drive"))
    course = _course(*changes, keys)
    suite = noisy(crane, seed) if keys.noise else None
    drawn = model_mismatch.draw(seed, model_mismatch.ranges_from(keys.mismatch)) if keys.mismatch else None
    plant = None if drawn is None else model_mismatch.applied(crane, drawn)
    return dict(follow(course, crane, suite, course.drive.adapt, plant).total._asdict())


@functools.lru_cache(maxsize=64)
def _course(
    machine: tuple[tuple[str, float], ...],
    control: tuple[tuple[str, Any], ...],
    drive: tuple[tuple[str, Any], ...],
    keys: TrackKeys,
) -> Course:
    """Return what runs that differ in seed and plant alone have in common."""
    model = changed_machine(load_machine(keys.model or keys.machine), dict(machine))
    course = prepare(path_named(keys.path), keys.speed, scheme_named(keys.scheme), model, keys.laps)
    return course._replace(
        substeps=_substeps(keys.step),
        settings=changed_settings(course.settings, dict(control)),
        drive=changed_settings(course.drive, dict(drive)),
    )


def _substeps(step: float) -> int:
    """Return how many steps [s] a period has.

    Raises:
        StudyError: not a whole number.
    """
    count = round(PERIOD / step)
    if abs(count * step - PERIOD) > ROUNDING:
        raise StudyError(f"step is {step:g} s; allowed: {PERIOD:g} s over a whole number, as 0.001, 0.0025")
    return count


def placed(case: Case, seed: int) -> Figures:
    """Return how a seed's target is reached: `placing.Placed`.

    Raises:
        StudyError: it is not.
        MachineError: the machine cannot be.
    """
    keys = PlacingKeys(**_own(case))
    found = placing.placed(_machine(keys.machine, case, ("machine",)), keys.trip, seed)
    return {name: float(value) for name, value in found._asdict().items()}


def watched(case: Case, seed: int) -> Figures:
    """Return what the monitor found: `diagnosis.detection_figures`.

    Raises:
        MachineError: the machine cannot be.
    """
    keys = DiagnosisKeys(**_own(case))
    return diagnosed(_machine(keys.machine, case, ("machine",)), keys.case, seed, 60.0 * keys.minutes)


def _own(case: Case) -> dict[str, Any]:
    return {key: value for key, value in case.items() if "." not in key}


def _under(case: Case, prefix: str) -> dict[str, Any]:
    """Return what a case says under a prefix, without it."""
    return {key[len(prefix) + 1 :]: x for key, x in case.items() if key.startswith(f"{prefix}.")}


def _machine(name: str, case: Case, prefixes: tuple[str, ...]) -> Machine:
    numbers: dict[str, float] = {}
    for prefix in prefixes:
        numbers |= _under(case, prefix)
    return changed_machine(load_machine(name), numbers)


def logged(case: Case, seed: int) -> Figures:
    """Return how a seed's person does the task: `trial_measures.figures`.

    With `against`, `saved`, `saved_loading` and `saved_unloading` are shares of that mode's time.

    Raises:
        StudyError: the task is not done, or the machine does not reach it.
        MachineError: the machine cannot be.
    """
    keys = LogsKeys(**_own(case))
    machine = _machine(keys.machine, case, ("machine",))
    operator = person.drawn(person.read_person(keys.operator, _under(case, "operator")), seed)
    told = trial_measures.figures(trial.work(machine, keys.mode, operator, keys.trip, seed))
    if keys.against == "none":
        return told
    other = trial_measures.figures(trial.work(machine, keys.against, operator, keys.trip, seed))
    names = {"time": "saved", "loading": "saved_loading", "unloading": "saved_unloading"}
    return told | {saved: 1.0 - told[name] / other[name] for name, saved in names.items()}


def require_track(case: Case) -> None:
    """Raise unless machines, settings and path can be what a case says.

    Raises:
        MachineError: a machine cannot be.
        ParameterError: a setting is unknown or out of range.
        PathError: the path cannot be read.
        StudyError: a period is not a whole number of steps.
    """
    keys = TrackKeys(**_own(case))
    _substeps(keys.step)
    _machine(keys.machine, case, ("machine", "plant"))
    changed_settings(controller_settings.Settings(), _under(case, "control"))
    changed_settings(valve_driver_parameters.Settings(), _under(case, "drive"))
    path_named(keys.path)
    changed_machine(load_machine(keys.model or keys.machine), _under(case, "machine"))


def require_placing(case: Case) -> None:
    """Raise unless the machine can be what a case says.

    Raises:
        MachineError: it cannot.
    """
    _machine(PlacingKeys(**_own(case)).machine, case, ("machine",))


def require_diagnosis(case: Case) -> None:
    """Raise unless the machine can be what a case says.

    Raises:
        MachineError: it cannot.
    """
    _machine(DiagnosisKeys(**_own(case)).machine, case, ("machine",))


def require_logs(case: Case) -> None:
    """Raise unless machine and operator can be what a case says.

    Raises:
        MachineError: the machine cannot be.
        StudyError: it does not reach the logs, or there is no such operator.
    """
    keys = LogsKeys(**_own(case))
    site.site_of(_machine(keys.machine, case, ("machine",)))
    person.read_person(keys.operator, _under(case, "operator"))


KINDS: dict[str, Kind] = {
    "track": Kind(TrackKeys, tracked, ("machine", "plant", "control", "drive"), require_track),
    "placing": Kind(PlacingKeys, placed, ("machine",), require_placing),
    "diagnosis": Kind(DiagnosisKeys, watched, ("machine",), require_diagnosis, batch=5),
    "logs": Kind(LogsKeys, logged, ("machine", "operator"), require_logs, batch=1),
}
