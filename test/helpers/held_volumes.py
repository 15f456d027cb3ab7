"""A crane whose boom hangs on a counterbalance valve between a hose and a chamber, each a volume.

Independent of `load_holding`, `holding_stage` and `holding_step`: the poppet is a state of the same
stiff system.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from two_volumes import CHAMBER_1, CHAMBER_2, HOSE_1, SCALE, TwoVolumes

from forest_description.machine import Machine

BOOM = 1
SHUT = 1e-6  # lift


class HeldVolumes(TwoVolumes):
    """As `TwoVolumes`, with `boom.holding_1` of the machine file; the last state is its lift."""

    def __init__(self, machine: Machine) -> None:
        super().__init__(machine)
        self.lift = 0.0

    def _through(self, axis: int, resistance: float, drop: float) -> float:
        # Only the boom's head side has the pair of pressures that `_held` names.
        if axis != BOOM or drop != self._held:
            return super()._through(axis, resistance, drop)
        valve = self.machine.boom.holding_1
        if drop > 0.0:
            square = valve.check_resistance
        elif self.lift > SHUT:
            square = valve.minimum_resistance / self.lift**2
        else:
            return 0.0
        if self.machine.boom.flow_regime != "laminar":
            return super()._through(axis, resistance + square, drop)
        root = math.sqrt(resistance**2 + 4.0 * square * abs(drop))
        return 2.0 * drop / (resistance + root)

    def all_rates(self, y: np.ndarray, spools) -> np.ndarray:
        """Return dy/dt of [25] states."""
        valve, boom = self.machine.boom.holding_1, (y[:-1] * SCALE).reshape(3, 8)[BOOM]
        self.lift, self._held = min(1.0, max(0.0, y[-1])), boom[HOSE_1] - boom[CHAMBER_1]
        force = boom[CHAMBER_1] + valve.pilot_ratio * boom[CHAMBER_2] - valve.setting
        rising, falling = force / valve.opening_range, (force + valve.hysteresis) / valve.opening_range
        pulled = rising - y[-1] if rising > y[-1] else min(0.0, falling - y[-1])
        at_an_end = (y[-1] <= 0.0 and pulled < 0.0) or (y[-1] >= 1.0 and pulled > 0.0)
        moves = 0.0 if at_an_end else pulled / valve.response_time
        return np.append(self.rates(y[:-1], spools), moves)

    def run_held(self, angles, spools, times: np.ndarray) -> np.ndarray:
        """Return states at some times [N, 25] in SI from rest, spools open from the start."""
        found = solve_ivp(
            lambda _, z: self.all_rates(z, spools),
            (times[0], times[-1]),
            np.append(self.start(angles), 0.0),
            method="Radau",
            t_eval=times,
            rtol=1e-6,
            atol=1e-8,
            max_step=2e-3,
        )
        assert found.success, found.message
        return found.y.T * np.append(SCALE, 1.0)
