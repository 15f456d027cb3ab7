"""Every experiment once more, now through the simulator: which parameters it moves, by which channels.

What earlier experiments found goes along as prior, with its standard error, so that everything is refined
together without one huge problem: a crane's motion may still correct what the bench said of the valve, as far
as the bench's interval lets it.

Names of unknowns that are no parameters of the machine:

| name | what |
|---|---|
| rig.load | R_L of the bench's load |
| swing.angle, boom.angle, stick.angle | static errors of the resolvers, true minus read |
| oil.offset | static error of the thermocouples' mean |
| tilt | of the platform, as far as the inclinometer may be off |
| start.CHANNEL.RECORD | pressure that a record of the crane began with, true minus read |
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from forest_description.components.pump import LoadSensingPump, PressureCompensatedPump
from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.experiments import experiments, test_rig
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import value_of, with_directions, with_values
from forest_ident.measurements.session import Session
from forest_ident.output_error import noise_model
from forest_ident.output_error.gaussian_estimate import Belief, widened
from forest_ident.output_error.output_error import Fit, Model, Unknown, fit
from forest_ident.output_error.prediction import Offsets, predict, redrawn
from forest_ident.refinement import apply_calibration

UNKNOWN = 0.4  # of what no experiment has found yet: relative, or volts
SETTLED = 0.25  # [s] after a change of voltage
BEGUN = "start."
BEGUN_NOISE = 1e4  # [Pa] by which pressures drift while the mean of the start is taken
RIG = (BEGUN, "rig.load", "swing.angle", "boom.angle", "stick.angle", "oil.offset", "tilt")


class Task(NamedTuple):
    """One refinement."""

    free: tuple[str, ...]  # keys to be found here; their prior counts if there is one
    carried: tuple[str, ...]  # keys found before, with their prior; left out if there is none
    channels: tuple[str, ...]
    nuisances: tuple[str, ...]


def valve_section(machine: Machine, axis: int) -> str:
    """Return where an axis' valve stands in the machine: "valve", or its own section."""
    name = AXES[axis]
    return f"{name}.valve" if machine.drives[axis].valve is not None else "valve"


def hose_section(machine: Machine, axis: int) -> str:
    """Return where an axis' hose stands in the machine."""
    name = AXES[axis]
    return f"{name}.hose" if machine.drives[axis].hose is not None else "hose"


def _law(section: str) -> tuple[str, ...]:
    parts = ("deadband_voltage", "minimum_resistance")
    return tuple(f"{section}.{way}{part}" for way in ("", "backward.") for part in parts)


def task(machine: Machine, session: Session) -> Task | None:
    """Return what a session's refinement finds, or None for a session that only checks."""
    kind, _, tail = session.name.partition("_")
    axis = AXES.index(tail) if tail in AXES else 0
    pump = _pump_keys(machine)
    if kind == "valve":
        section = f"{tail}.valve" if tail in AXES else "valve"
        free = (*_law(section), f"{section}.port_2_area", *_spool_keys(machine, section), *pump)
        channels = tuple(name for name in _bench_channels(spool=True) if not name.endswith("actuator"))
        # Between valve and load lies a short piece of hose, which nobody has measured yet.
        own = axis if tail in AXES else experiments.shared_valve_axis(machine)
        hose = hose_section(machine, own)
        pieces = tuple(f"{hose}.{part}" for part in ("turbulent_resistance", "inertance", "capacitance"))
        return Task(free, pieces, channels, ("rig.load",))
    if session.name == "spool_lag":
        section = valve_section(machine, 0)
        return Task(_spool_keys(machine, section), (), ("swing_spool",), ())
    if kind == "hose":
        axis, laminar = int(session.facts["hose_axis"]), session.facts["laminar"] > 0.0
        section = hose_section(machine, axis)
        law = "laminar" if laminar else "turbulent"
        free = tuple(f"{section}.{part}" for part in (f"{law}_resistance", "inertance", "capacitance"))
        valve = valve_section(machine, axis)
        carried = (*_law(valve), f"{valve}.port_2_area", *_spool_keys(machine, valve), *pump)
        return Task(free, carried, _bench_channels(spool=False), ("rig.load",))
    return _crane_task(machine, session, kind, axis)


def _crane_task(machine: Machine, session: Session, kind: str, axis: int) -> Task | None:
    pump = _pump_keys(machine)
    section = valve_section(machine, axis)
    valve = (*_law(section), f"{section}.port_2_area", *_spool_keys(machine, section))
    hoses = _hose_keys(machine, axis)
    leakage = ("swing.internal_leakage_resistance", "swing.external_leakage_resistance")
    offsets = ("boom.angle", "stick.angle", "oil.offset")
    shut = session.name == "motor_internal"
    if session.name in ("motor_external", "motor_internal"):
        free = leakage if session.name == "motor_internal" else leakage[1:]
        more = ("swing.damping",) if session.name == "motor_internal" else ("swing.damping", leakage[0])
        carried = (*more, *hoses) if shut else (*more, *valve, *hoses, *pump)
        tilt = ("tilt", "swing.angle") if shut else ()
        channels = (*_axis_channels(0)[: -1 if shut else None], "case_drain")
        return Task(free, carried, channels, (*offsets, *tilt))
    if kind == "deadband":
        section = f"{AXES[axis]}.valve"
        return Task(
            (f"{section}.deadband_voltage", f"{section}.backward.deadband_voltage"),
            (
                *(*_law(section)[1::2], f"{section}.port_2_area", f"{AXES[axis]}.damping"),
                *(*(leakage if axis == 0 else ()), *pump),
            ),
            _axis_channels(axis),
            offsets,
        )
    if kind == "damping":
        carried = (*valve, *hoses, *(leakage if axis == 0 else ()), *pump)
        return Task((f"{AXES[axis]}.damping",), carried, _axis_channels(axis), offsets)
    return None


def _pump_keys(machine: Machine) -> tuple[str, ...]:
    if isinstance(machine.pump, PressureCompensatedPump):
        return ("pump.supply_pressure", "pump.compensator_band")
    if isinstance(machine.pump, LoadSensingPump):  # which no experiment loads up to its greatest pressure
        return ("pump.margin", "pump.response_time")
    return ("pump.supply_pressure",)


def _spool_keys(machine: Machine, section: str) -> tuple[str, ...]:
    own, _, _ = section.rpartition(".")
    valve = getattr(machine, own).valve if own else machine.valve
    names = [name for name in ("spool_bandwidth", "spool_damping") if getattr(valve, name) is not None]
    return tuple(f"{section}.{name}" for name in names)


def _hose_keys(machine: Machine, axis: int) -> tuple[str, ...]:
    section, regime = hose_section(machine, axis), machine.drives[axis].flow_regime
    return tuple(f"{section}.{part}" for part in (f"{regime}_resistance", "inertance", "capacitance"))


def _bench_channels(spool: bool) -> tuple[str, ...]:
    ports = ("swing_pressure_1_valve", "swing_pressure_2_valve", "swing_pressure_1_actuator")
    flows = ("swing_flow", "stick_flow")
    return (*ports, *flows, "supply_pressure", *(("swing_spool",) if spool else ()))


def _axis_channels(axis: int) -> tuple[str, ...]:
    name = AXES[axis]
    ports = (f"{name}_pressure_1_actuator", f"{name}_pressure_2_actuator")
    return (f"{name}_resolver", f"{name}_transducer", *ports, f"{name}_flow", "supply_pressure")


def refine(
    machine: Machine,
    session: Session,
    belief: Belief,
    progress: Callable[[], None] = lambda: None,
    keep_only: int = 0,
) -> tuple[Task, Fit] | None:
    """Return what a session makes of its parameters, through the simulator; None if it finds none.

    Args:
        machine: with the values to start from.
        session: the record.
        belief: what earlier experiments found.
        progress: called after every simulation.
        keep_only: rows of the session that count, from its start; 0: all.
    """
    work = task(machine, session)
    if work is None:
        return None
    if keep_only:
        session = session.part(0, keep_only)
    if session.name.startswith("deadband"):
        machine = with_directions(machine, f"{session.name.partition('_')[2]}.valve")
    is_bench = session.name.split("_")[0] in ("valve", "spool", "hose")
    unknowns = [*_unknowns(machine, session, work), *_begun(machine, session, work, belief)]
    sensed = dataclasses.replace(machine, sensors=test_rig.meters(machine)) if is_bench else machine
    channels = noise_model.judged(sensed, session, work.channels)
    # Static errors stay, the noise of the means that a session starts from is its own.
    noise = {f"{axis}.angle": noise_model.start_noise(machine, session, axis) for axis in AXES}
    belief = widened(belief, noise)
    measured = sample_mask.fresh({c.name: session.column(c.name) for c in channels})
    if is_bench:
        floor = max((c.floor for c in channels), default=0.0)
        settled = SETTLED if session.name.startswith("valve") else 0.0
        measured = sample_mask.while_open(measured, session, settled, floor)
    else:
        measured = sample_mask.without_start(measured, session)
    known = session if session.is_exact else apply_calibration.corrected(session, machine)

    def driven_by(inputs: Session) -> Model:
        return lambda values: _predicted(machine, inputs, values, is_bench)

    again = () if is_bench else [driven_by(one) for one in redrawn(machine, known)]
    return work, fit(driven_by(known), measured, channels, unknowns, progress, belief=belief, redrawn=again)


def _unknowns(machine: Machine, session: Session, work: Task) -> list[Unknown]:
    found = []
    for key in (*work.free, *work.carried):
        positive = not key.endswith("deadband_voltage")
        # An overlap that a curve in volts hides stays where it was told, or it would leave the curve behind.
        spread = math.inf if key in work.free and positive else UNKNOWN
        found.append(Unknown(key, value_of(machine, key), spread, positive))
    exact = session.is_exact
    for name in work.nuisances:
        if name == "rig.load":
            found.append(Unknown(f"{name}.{session.name}", _load(session), math.inf))
        elif exact:
            continue
        elif name == "tilt":
            sd = noise_model.accuracy(machine, session, "inclinometer") or 0.01
            found.append(Unknown(name, 0.0, sd, positive=False))
        elif name == "oil.offset" and session.temperature() is not None and machine.oil is not None:
            sd = noise_model.accuracy(machine, session, "thermocouple") / math.sqrt(3.0)
            found.append(Unknown(name, 0.0, max(sd, 0.01), positive=False, difference=0.1))
        elif name.endswith(".angle"):
            sd = noise_model.accuracy(machine, session, "resolver")
            if sd > 0.0:
                found.append(Unknown(name, 0.0, sd, positive=False))
    return found


def _begun(machine: Machine, session: Session, work: Task, belief: Belief) -> list[Unknown]:
    """Return the pressures that a crane's record began with: behind a shut valve they are felt for long."""
    found: list[Unknown] = []
    for name in work.channels if is_crane(session) else ():
        if "_pressure_" not in name or not session.has(name):
            continue
        offset = noise_model.channel(machine, session, name).offset
        if f"{name}.b" in belief.names:  # calibrated: the record is read with that
            _, offset = belief.of(f"{name}.b")
        spread = math.hypot(offset, BEGUN_NOISE)
        found.append(Unknown(f"{BEGUN}{name}.{session.name}", 0.0, spread, False, 100.0))
    return found


def _load(session: Session) -> float:
    """Return R_L [Pa s/m^3] of a bench's load as pressures and flow have it, to start from."""
    drop = session.column("swing_pressure_1_actuator") - session.column("swing_pressure_2_actuator")
    flow = session.column("swing_flow")
    return float(drop @ flow / (flow @ flow))


def is_crane(session: Session) -> bool:
    """Tell whether a session is the crane's, not a rig's."""
    return session.name.split("_")[0] not in ("valve", "spool", "hose", "calibration")


def prepared(machine: Machine, session: Session) -> Machine:
    """Return the machine as it stood in a session: on its rig, or with its platform tilted as read."""
    kind = session.name.split("_")[0]
    if kind in ("valve", "spool", "hose"):
        return experiments.plan(session.name, machine).machine
    if session.has("platform_roll"):
        tilt = float(np.mean(session.column("platform_roll")))
    else:
        tilt = session.facts.get("platform_tilt", machine.manipulator.platform_tilt)
    if session.name != "motor_internal":
        return machine
    links = dataclasses.replace(machine.manipulator, platform_tilt=tilt)
    return dataclasses.replace(machine, manipulator=links)


def _predicted(
    machine: Machine, session: Session, values: Mapping[str, float], is_bench: bool
) -> Mapping[str, Floats]:
    """Return what the machine with these values would have read."""
    load = values.get(f"rig.load.{session.name}")
    own = {key: value for key, value in values.items() if not key.startswith(RIG)}
    model = prepared(with_values(machine, own), session)
    if load is not None:
        model = with_values(model, {test_rig.LOAD_KEY: load * test_rig.DISPLACEMENT**2})
    if "tilt" in values:
        key = "manipulator.platform_tilt"
        model = with_values(model, {key: value_of(model, key) + values["tilt"]})
    offsets = Offsets(
        values.get("swing.angle", 0.0),
        values.get("boom.angle", 0.0),
        values.get("stick.angle", 0.0),
        values.get("oil.offset", 0.0),
    )
    begun = {key.split(".")[1]: value for key, value in values.items() if key.startswith(BEGUN)}
    return predict(model, session, is_bench, offsets, begun=begun)
