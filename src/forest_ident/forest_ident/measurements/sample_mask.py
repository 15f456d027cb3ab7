"""Mask the rows of a record that a refinement does not use: they become NaN."""

from collections.abc import Mapping

import numpy as np

from forest_description.types import Floats
from forest_ident.measurements.session import Session

HELD_SHARE = 0.3  # of rows that repeat the last one: from there on the sensors are slower
SHUT_SHARE = 0.03  # of the greatest flow: less counts as shut
AT_FLOOR = 1.02  # of the meter's floor: less is no reading
SHUT_AROUND = 0.05  # [s] before and after
FORGOTTEN = 2.0  # [s] after which a crane's pressures have settled from how the record began


def fresh(measured: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return columns without the rows that repeat the last one: sensors sampled slower than the record."""
    same = np.all([np.diff(column, prepend=np.nan) == 0.0 for column in measured.values()], axis=0)
    if float(np.mean(same)) < HELD_SHARE:
        return dict(measured)
    return {name: np.where(same, np.nan, column) for name, column in measured.items()}


def without_start(measured: Mapping[str, Floats], session: Session) -> dict[str, Floats]:
    """Return a crane's columns without the pressures that it began with.

    The simulation begins at rest with those that were read: no prediction, and the flows there are not.
    """
    begun = np.arange(len(session.time)) < round(FORGOTTEN / session.period)
    return {
        name: np.where(begun, np.nan, column) if "_pressure_" in name else column
        for name, column in measured.items()
    }


def while_open(
    measured: Mapping[str, Floats], session: Session, settled: float, floor: float
) -> dict[str, Floats]:
    """Return a bench's columns without the rows in which the valve is next to shut, or has just moved.

    The pressure that a closing valve traps in the hoses depends on its last millisecond: it is of no use, nor
    is a flow below the meter's floor. How the flow changes from one level to the next depends on the hoses.

    Args:
        measured: columns by channel, a value a row.
        session: whose flow and voltages show when the valve was shut or moved.
        settled: time after a change of voltage that does not count [s].
        floor: of the flow meter [m^3/s].
    """
    flow = session.column("swing_flow")
    shut = np.abs(flow) < max(SHUT_SHARE * float(np.max(np.abs(flow))), AT_FLOOR * floor)
    shut |= np.diff(np.sign(flow), prepend=0.0) != 0.0  # it may turn round between two rows
    around = round(SHUT_AROUND / session.period)
    shut = np.convolve(shut, np.ones(2 * around + 1), mode="same") > 0.5
    moved = np.diff(session.voltages[:, 0], prepend=0.0) != 0.0
    shut |= np.convolve(moved, np.ones(max(1, round(settled / session.period))))[: len(flow)] > 0.5
    kept = {"swing_spool"}
    return {
        name: column if name in kept else np.where(shut, np.nan, column) for name, column in measured.items()
    }
