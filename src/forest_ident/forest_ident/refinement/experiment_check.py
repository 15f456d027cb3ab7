"""Is a record of the experiment that it names, and of this machine?

By the axes that were driven, how the platform stood, the facts beside it, the supply at rest, lengths over
angles, where oil flows under a voltage, and the oil's temperature.
"""

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.derived.limits import joint_limits
from forest_description.geometry.linkage import cylinder_length
from forest_description.hydraulics.oil import COLDEST, HOTTEST
from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.experiments.experiment_plan import TILT, plan
from forest_ident.measurements.session import THERMOCOUPLES, Session, SessionError

DRIVEN = 0.02  # of a valve's rated voltage: less is no opening
TILTED = 0.3 * TILT  # [rad]
STRANGE = 0.1  # of a cylinder's stroke: ten times what a tape's errors move its length by
BEYOND = 0.1  # [rad] past the end of a joint's way: more than any sensor's error
COUNT = 200  # samples of a record that are compared
PUMP = 2.0  # times the pressure of the idle pump, or under its half: more than a gauge is misread by
WIDE = 0.5  # of the greatest voltage: rows by which a direction is told
AGAINST = 1e-3  # of the pump's pressure, beside what the transducers err
WARM = 2.0  # [K] from the file's: a laminar hose's resistance changes by 4 % a kelvin
SPOOL = 0.3  # [V] more than a spool's sensor errs
REST = 20  # rows at the start without a voltage, at least, that tell the idle pump's pressure


def demand(machine: Machine, session: Session) -> None:
    """Refuse a record that is of another experiment than it says.

    Raises:
        SessionError: it drives an axis that its experiment leaves alone, stands otherwise, has facts of
            another experiment, or is another machine's.
    """
    _demand_facts(machine, session)
    demand_machine(machine, session)
    allowed = _axes(session)
    if allowed is None:
        return
    strangers = [name for name in _driven(machine, session) if name not in allowed]
    if strangers:
        only = f"only {' and '.join(allowed)}" if allowed else "none: all valves stay shut"
        raise SessionError(
            f"{session.name}: the record drives {' and '.join(strangers)}; allowed: {only}: is it another "
            "experiment's under this name?"
        )
    if session.name == "motor_external" and not _driven(machine, session):
        raise SessionError(
            "motor_external: the record drives no axis; allowed: the swing: is it motor_internal's?"
        )
    if session.kind == "motor" and session.has("platform_roll"):
        tilt = abs(float(np.mean(session.column("platform_roll"))))
        if (tilt > TILTED) != (session.name == "motor_internal"):
            stands = "tilted" if session.name == "motor_internal" else "level"
            raise SessionError(f"{session.name}: the platform rolls {tilt:.3f} rad; allowed: a {stands} one")


def _demand_facts(machine: Machine, session: Session) -> None:
    """Refuse a hose's record whose facts are of another hose's experiment."""
    if session.kind != "hose":
        return
    planned = plan(session.name, machine).metadata
    for fact in ("laminar", "hose_axis") if session.own_axis else ("laminar",):
        told = session.metadata.get(fact, planned[fact])
        if told != planned[fact]:
            raise SessionError(
                f"{session.name}: its experiment.yaml says {fact} {told:g}; allowed: {planned[fact]:g}: is "
                "it another hose's under this name?"
            )


def demand_machine(machine: Machine, session: Session) -> None:
    """Refuse a record that this machine cannot have made.

    Raises:
        SessionError: its pump idles at another pressure, its oil is not the file's, oil flows against the
            voltage, a joint goes where it has no way, a cylinder's length does not belong to its angle, or
            boom and stick have no resolvers.
    """
    _demand_pump(machine, session)
    _demand_temperatures(session)
    if session.on_rig:
        _demand_directions(machine, session)
        _demand_cooler(machine, session)
    if not session.on_crane:
        return
    try:
        machine.demand_resolvers("a fit")
    except MachineError as error:
        raise SessionError(f"{session.name}: {error}") from error
    for axis, (low, high) in zip(AXES, joint_limits(machine), strict=True):
        if not session.has(f"{axis}_resolver"):
            continue
        angles = session.column(f"{axis}_resolver")
        if axis != "swing" and (angles.min() < low - BEYOND or angles.max() > high + BEYOND):
            raise SessionError(
                f"{session.name}: {axis} goes from {angles.min():.2f} to {angles.max():.2f} rad; allowed on "
                f"{machine.name}: {low:.2f} .. {high:.2f}: is it another machine's record?"
            )
        if session.has(f"{axis}_transducer"):
            _demand_lengths(machine, session, axis)


def _demand_pump(machine: Machine, session: Session) -> None:
    """Refuse a record whose supply stands otherwise than the pump's, before a valve was opened."""
    rows = int(np.argmax(np.any(session.voltages != 0.0, axis=1))) or len(session.time)
    resting = (session.on_crane or session.on_rig) and session.has("supply_pressure") and rows >= REST
    if not resting or np.any(session.voltages[0] != 0.0):
        return
    idle, read = machine.pump.idle_pressure, float(np.mean(session.column("supply_pressure")[:rows]))
    if not idle / PUMP < read < idle * PUMP:
        raise SessionError(
            f"{session.name}: the supply stands at {1e-6 * read:.3g} MPa before a valve opens; allowed on "
            f"{machine.name}: {1e-6 * idle / PUMP:.3g} .. {1e-6 * idle * PUMP:.3g} MPa, its "
            f"{machine.pump.kind} pump's: is it another machine's record, or another kind of pump?"
        )


def _demand_temperatures(session: Session) -> None:
    """Refuse a record whose thermocouples read what no hydraulic oil has."""
    for name in filter(session.has, THERMOCOUPLES):
        low, high = float(np.min(session.column(name))), float(np.max(session.column(name)))
        if not COLDEST < low <= high < HOTTEST:
            raise SessionError(
                f"{session.name}: {name} reads {low:.4g} .. {high:.4g} K; allowed: {COLDEST:g} .. "
                f"{HOTTEST:g} K: is it in degrees Celsius?"
            )


def _demand_cooler(machine: Machine, session: Session) -> None:
    """Refuse a rig's record of other oil than that for which the machine's numbers are told."""
    read = session.temperature()
    if machine.oil is None or read is None:
        return
    told, mean = machine.oil.reference_temperature, float(np.mean(read))
    if abs(mean - told) > WARM:
        raise SessionError(
            f"{session.name}: the rig's oil is at {mean:.1f} K; allowed: {told:.1f} K within {WARM:g} K, as "
            f"{machine.name}'s oil.reference_temperature says: cool it, or state the rig's"
        )


def _demand_directions(machine: Machine, session: Session) -> None:
    """Refuse a rig's record in which flow, spool or the drop over the ports is against the voltage."""
    meter, transducer = machine.sensors.flow_meter, machine.sensors.pressure
    _demand_along(session, ("swing_flow",), meter.lowest if meter else 0.0, "is the meter")
    _demand_along(session, ("swing_spool",), SPOOL, "is the spool's sensor")
    ports = ("swing_pressure_1_valve", "swing_pressure_2_valve")
    error = 2.0 * transducer.full_scale * (transducer.accuracy or 0.0) if transducer else 0.0
    _demand_along(session, ports, error + AGAINST * machine.pump.idle_pressure, "are the ports")


def _demand_along(session: Session, channels: tuple[str, ...], least: float, suspect: str) -> None:
    """Refuse a record in which what is read is against the voltage by more than the least that counts."""
    if not session.has(*channels):
        return
    volts = session.voltages[:, 0]
    read = session.column(channels[0]) - sum(session.column(name) for name in channels[1:])
    for sign, called in ((1.0, "positive"), (-1.0, "negative")):
        wide = sign * volts > WIDE * np.max(np.abs(volts))
        mean = float(np.mean(read[wide])) if np.any(wide) else 0.0
        if sign * mean < -least:
            raise SessionError(
                f"{session.name}: {' less '.join(channels)} is {mean:.3g} in the mean of {called} voltages; "
                f"allowed: their sign: is the voltage reversed, or {suspect}?"
            )


def _demand_lengths(machine: Machine, session: Session, axis: str) -> None:
    drive, every = getattr(machine, axis), max(1, len(session.time) // COUNT)
    read = session.column(f"{axis}_transducer")[::every]
    angles = session.column(f"{axis}_resolver")[::every].tolist()
    off = float(np.median(np.abs(read - [cylinder_length(angle, drive.linkage) for angle in angles])))
    if off > STRANGE * drive.stroke:
        raise SessionError(
            f"{session.name}: the {axis}'s cylinder is {off:.2f} m longer or shorter than {machine.name}'s "
            f"at its angles; allowed: up to {STRANGE * drive.stroke:.2f} m: is it another machine's record?"
        )


def _axes(session: Session) -> tuple[str, ...] | None:
    """Return the axes that an experiment on the crane may drive; None for one of which nothing is known."""
    if session.own_axis and session.kind in ("damping", "deadband"):
        return (session.own_axis,)
    return {"gravity": AXES[1:], "motor_external": AXES[:1], "motor_internal": ()}.get(session.name)


def _driven(machine: Machine, session: Session) -> list[str]:
    most = np.max(np.abs(session.voltages), axis=0)
    return [name for k, name in enumerate(AXES) if most[k] > DRIVEN * machine.valve_of(k).rated_voltage]
