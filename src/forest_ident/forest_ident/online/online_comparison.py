"""Running estimates over a record, beside the off-line fit."""

import math
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.measurements.readings import speeds
from forest_ident.measurements.session import Session
from forest_ident.online import online_estimator

UNITS = {"deadband": "V", "gain": "m3/(s*V*sqrt(Pa))"}
DAMPING = ("N*m*s/rad", "N*s/m", "N*s/m")


class Comparison(NamedTuple):
    """One quantity of a record: the start's, the running estimate at the record's end, the off-line one."""

    record: str
    name: str
    start: float
    online: float
    standard_error: float
    offline: float
    unit: str


def estimates(machine: Machine, session: Session) -> dict[str, float]:
    """Return the running estimates at a session's end, by the labels of `online_estimator.LABELS`.

    Args:
        machine: from which the estimation begins.
        session: of the crane, with all joints, pressures at the actuators, and the supply.

    Raises:
        SessionError: a channel is missing.
    """
    p = online_estimator.parameters(machine)
    state = online_estimator.initial(p)
    angles = np.column_stack([session.column(f"{axis}_resolver") for axis in AXES])
    rates = np.column_stack([speeds(column, session.period) for column in angles.T])
    one, two = map(np.column_stack, zip(*(session.pressures(axis, "actuator") for axis in AXES), strict=True))
    tables = (angles, rates, one, two, session.voltages)
    columns = [list(map(tuple, table.tolist())) for table in tables]
    supply = session.column("supply_pressure").tolist()
    for q, u, p_1, p_2, volts, p_s in zip(*columns, supply, strict=True):
        state = online_estimator.step(
            state,
            online_estimator.Sample(
                angles=q, rates=u, pressures_1=p_1, pressures_2=p_2, supply=p_s, voltages=volts
            ),
            p,
            session.period,
        )
    return dict(zip(online_estimator.LABELS, online_estimator.report(state), strict=True))


def compare(start: Machine, found: Machine, session: Session) -> list[Comparison]:
    """Return the running estimates of the axis that a session moved, beside the off-line fit.

    Thesis table 4.1.

    Args:
        start: from which the on-line estimation begins.
        found: of the off-line fit.
        session: ``damping_AXIS``.

    Raises:
        SessionError: a channel is missing.
    """
    axis = AXES.index(session.own_axis)
    running, rows = estimates(start, session), []
    known, offline = _quantities(start, axis), _quantities(found, axis)
    for part in known:
        name = f"{AXES[axis]}_{part}"
        error, unit = running[f"{name}_spread"], UNITS.get(part.partition("_")[0], DAMPING[axis])
        rows.append(
            Comparison(
                record=session.name,
                name=name,
                start=known[part],
                online=running[name],
                standard_error=error,
                offline=offline[part],
                unit=unit,
            )
        )
    return rows


def _quantities(machine: Machine, axis: int) -> dict[str, float]:
    """Return a machine's numbers by the names of the on-line estimation."""
    law, found = machine.valve_of(axis).law, {}
    for way, edge in (("forward", law.forward), ("backward", law.backward)):
        reach = edge.rated_voltage - edge.deadband_voltage
        found[f"deadband_{way}"] = edge.deadband_voltage
        found[f"gain_{way}"] = 1.0 / (math.sqrt(edge.resistance_1) * reach)
    return found | {"damping": machine.drives[axis].damping}
