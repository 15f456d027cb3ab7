"""The running estimates of `online` over a record, beside what the off-line fit says."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.measurements.readings import speeds
from forest_ident.measurements.session import Session
from forest_ident.online import estimator

UNITS = {"deadband": "V", "gain": "m3/(s*V*sqrt(Pa))"}
DAMPING = ("N*m*s/rad", "N*s/m", "N*s/m")


class Beside(NamedTuple):
    """One quantity of a record: as told, on line with its spread at the record's end, off line."""

    record: str
    name: str
    told: float
    running: float
    spread: float
    settled: float
    unit: str


def estimates(machine: Machine, session: Session) -> dict[str, float]:
    """Return what is believed at a session's end, by the labels of `online.LABELS`.

    Args:
        machine: as told to the on-line estimation.
        session: of the crane, with all joints, pressures at the actuators, and the supply.

    Raises:
        SessionError: a channel is missing.
    """
    p = estimator.parameters(machine)
    state = estimator.initial(p)
    angles = np.column_stack([session.column(f"{axis}_resolver") for axis in AXES])
    rates = np.column_stack([speeds(column, session.period) for column in angles.T])
    one, two = (
        np.column_stack([session.column(f"{axis}_pressure_{port}_actuator") for axis in AXES])
        for port in (1, 2)
    )
    tables = (angles, rates, one, two, session.voltages)
    columns = [list(map(tuple, table.tolist())) for table in tables]
    supply = session.column("supply_pressure").tolist()
    for q, u, p_1, p_2, volts, p_s in zip(*columns, supply, strict=True):
        state = estimator.step(
            state,
            estimator.Sample(angles=q, rates=u, pressures_1=p_1, pressures_2=p_2, supply=p_s, voltages=volts),
            p,
            session.period,
        )
    return dict(zip(estimator.LABELS, estimator.report(state), strict=True))


def beside(start: Machine, found: Machine, session: Session) -> list[Beside]:
    """Return what the on-line estimation says of the axis that a session moved, beside the off-line fit.

    Thesis table 4.1.

    Args:
        start: as told, from which the on-line estimation begins.
        found: as the off-line fit has it.
        session: ``damping_AXIS``.

    Raises:
        SessionError: a channel is missing.
    """
    axis = AXES.index(session.name.partition("_")[2])
    running, rows = estimates(start, session), []
    told, settled = _quantities(start, axis), _quantities(found, axis)
    for part in told:
        name = f"{AXES[axis]}_{part}"
        spread, unit = running[f"{name}_spread"], UNITS.get(part.partition("_")[0], DAMPING[axis])
        rows.append(
            Beside(
                record=session.name,
                name=name,
                told=told[part],
                running=running[name],
                spread=spread,
                settled=settled[part],
                unit=unit,
            )
        )
    return rows


def _quantities(machine: Machine, axis: int) -> dict[str, float]:
    """Return a machine's numbers as the on-line estimation speaks of them."""
    law, found = machine.valve_of(axis).law, {}
    for way, edge in (("forward", law.forward), ("backward", law.backward)):
        reach = edge.rated_voltage - edge.deadband_voltage
        found[f"deadband_{way}"] = edge.deadband_voltage
        found[f"gain_{way}"] = 1.0 / (math.sqrt(edge.resistance_1) * reach)
    return found | {"damping": machine.drives[axis].damping}
