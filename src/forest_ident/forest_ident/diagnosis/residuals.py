"""Residuals: what the machine does beside what its file says, at the end of each bin.

`axis_residuals` has those of swing, boom and stick; `machine_residuals` those of supply and sensors.
"""

from typing import NamedTuple

from forest_description.types import AXES
from forest_ident.diagnosis import axis_residuals, machine_residuals
from forest_ident.diagnosis.axis_residuals import OF_AXIS, Axis, mean_of
from forest_ident.diagnosis.machine_residuals import OF_MACHINE, Machine
from forest_ident.diagnosis.monitor_readings import NAN, Readings
from forest_ident.diagnosis.residual_parameters import Parameters, thinned

BIN = 0.1  # [s]
NAMES = (*(f"{axis}_{name}" for axis in AXES for name in OF_AXIS), *OF_MACHINE)
COUNT = len(NAMES)
NONE = (NAN,) * COUNT


class Residuals(NamedTuple):
    """What is remembered, and the last bin's residuals."""

    axes: tuple[Axis, Axis, Axis] = (Axis(), Axis(), Axis())
    machine: Machine = Machine()
    values: tuple[float, ...] = NONE
    stands: int = 0  # 1: all valves were shut for all of the last bin
    ended: int = 0  # 1: a bin has ended with this sample


def updated(before: Residuals, r: Readings, p: Parameters, dt: float) -> Residuals:
    """Return the residuals after a sample, dt [s] after the last one: in the order of `NAMES`, else NaN."""
    axes = (
        axis_residuals.sampled(before.axes[0], 0, r, p, dt),
        axis_residuals.sampled(before.axes[1], 1, r, p, dt),
        axis_residuals.sampled(before.axes[2], 2, r, p, dt),
    )
    machine = machine_residuals.sampled(before.machine, r, dt)
    if machine.time < BIN - 0.5 * dt:
        return before._replace(axes=axes, machine=machine, values=NONE, ended=0)
    return _ended(axes, machine, r, p)


def _ended(axes: tuple[Axis, Axis, Axis], m: Machine, r: Readings, p: Parameters) -> Residuals:
    """Return the residuals at a bin's end."""
    n, dt, first = m.samples, m.time, m.primed == 0
    means = mean_of(axes[0].sums, n), mean_of(axes[1].sums, n), mean_of(axes[2].sums, n)
    thin = thinned(p.oil, r.temperature)
    swing, values_1 = axis_residuals.ended(axes[0], means[0], p.axes[0], r.valves[0], thin, dt, n, first)
    boom, values_2 = axis_residuals.ended(axes[1], means[1], p.axes[1], r.valves[1], thin, dt, n, first)
    stick, values_3 = axis_residuals.ended(axes[2], means[2], p.axes[2], r.valves[2], thin, dt, n, first)
    after = swing, boom, stick
    m, values = machine_residuals.ended(m, after, means, r.temperature, thin, p, dt, first)
    stands = swing.quiet > 0.0 and boom.quiet > 0.0 and stick.quiet > 0.0
    return Residuals(after, m, (*values_1, *values_2, *values_3, *values), int(stands), 1)
