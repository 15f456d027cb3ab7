"""A crane whose hoses and chambers are volumes of their own, the hoses' resistance between them.

Independent of `oil_volume`: two pressures a port, integrated with scipy's Radau.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from forest_description.machine import Machine
from forest_description.mechanics.drives import Friction
from forest_sim.equations.multibody import HANGING_STILL, mechanics, solve
from forest_sim.equations.plant import transmissions
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import valve_ports
from forest_sim.hydraulics.port import is_shut, port_pressure
from forest_sim.mechanics.end_stop import end_stop_force
from forest_sim.solver.compiled_plant import compiled_record
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.state_recording import STATE

CREEPING = 2e6  # [Pa s/m^3] of a turbulent hose at tiny flows: 2 kPa at 1 L/s, so that it has a slope
SCALE = np.array([1.0, 1.0, 2e7, 2e7, 2e7, 2e7, 3e-3, 3e-3] * 3)
ANGLE, RATE, HOSE_1, CHAMBER_1, HOSE_2, CHAMBER_2, FLOW_1, FLOW_2 = range(8)


class TwoVolumes:
    """A machine with chambers, an ideal pump and no port valves; its spools stand still."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.p = machine, plant_parameters(machine)
        self.beta = machine.oil.bulk_modulus

    def start(self, angles) -> np.ndarray:
        """Return the state at rest, [24] over `SCALE`."""
        plant = equilibrium(angles, self.p).plant
        rows = [(s.angle, 0.0, *[s.pressure_1] * 2, *[s.pressure_2] * 2, 0.0, 0.0) for s in plant.axes]
        return np.concatenate(rows) / SCALE

    def chamber(self, axis: int, side: int, position: float) -> float:
        """Return a chamber's volume [m^3]."""
        drive = self.machine.drives[axis]
        if axis == 0:
            return drive.chambers.port_volume
        stroke = position - drive.retracted_length
        if side == 1:
            return drive.chambers.head_dead_volume + drive.head_area * stroke
        return drive.chambers.rod_dead_volume + drive.rod_area * (drive.stroke - stroke)

    def actuator(self, axis: int, u: float, p_1: float, p_2: float) -> tuple[float, float, float]:
        """Return what enters at port 1 and leaves at port 2, at the chambers' density, and the force."""
        drive = self.machine.drives[axis]
        if axis > 0:
            return (
                drive.head_area * u,
                drive.rod_area * u,
                drive.head_area * p_1
                - drive.rod_area * p_2
                - drive.damping * u
                - seals(drive.friction, u, p_1, p_2),
            )
        d = drive.gear_ratio * drive.motor_displacement
        inner = (p_1 - p_2) / drive.internal_leakage_resistance
        case_1, case_2 = p_1 / drive.external_leakage_resistance, p_2 / drive.external_leakage_resistance
        return d * u + inner + case_1, d * u + inner - case_2, d * (p_1 - p_2) - drive.damping * u

    def rates(self, y: np.ndarray, spools) -> np.ndarray:
        """Return dy/dt at held spools [V]."""
        x = (y * SCALE).reshape(3, 8)
        at = transmissions(*x[:, ANGLE], self.p)
        out, torques = np.zeros((3, 8)), []
        for axis, t in enumerate(at):
            torques.append(self._axis(axis, x[axis], t, spools[axis], out[axis]))
        m = mechanics(tuple(x[:, ANGLE]), tuple(x[:, RATE]), HANGING_STILL, self.p)
        driving = tuple(a - b for a, b in zip(torques, m.bias, strict=True))
        out[:, RATE] = solve(m.inertia, driving, (0.0, 0.0))[0]
        out[:, ANGLE] = x[:, RATE]
        return out.ravel() / SCALE

    def _axis(self, axis, s, t, spool, out) -> float:
        u, law = t.arm * s[RATE], self.p.valves[axis].law
        q_1, q_2, force = self.actuator(axis, u, s[CHAMBER_1], s[CHAMBER_2])
        ports = valve_ports(spool, law)
        for side, (hose, chamber, flow, port, taken) in enumerate(
            (
                (HOSE_1, CHAMBER_1, FLOW_1, ports.port_1, q_1),
                (HOSE_2, CHAMBER_2, FLOW_2, ports.port_2, -q_2),
            ),
            start=1,
        ):
            line = self.machine.line(axis, side)
            passed = self._through(axis, line.resistance, s[hose] - s[chamber])
            sign = 1.0 if side == 1 else -1.0
            into = sign * s[flow]
            out[hose] = (into - passed) / line.capacitance
            volume = self.chamber(axis, side, t.position)
            if axis > 0:  # the piston takes pressed oil
                taken *= 1.0 + s[chamber] / self.beta
            out[chamber] = self.beta * (passed - taken) / volume
            if not is_shut(port):
                supply = self.p.supply.set_pressure
                p = port_pressure(s[hose], into, port, supply)
                out[flow] = sign * (p - s[hose]) / line.inertance
        force += end_stop_force(t.position, u, self.p.axes[axis].stop)
        return t.arm * force

    def _through(self, axis: int, resistance: float, drop: float) -> float:
        if self.machine.drives[axis].flow_regime == "laminar":
            return drop / resistance
        return 2.0 * drop / (CREEPING + math.sqrt(CREEPING**2 + 4.0 * resistance * abs(drop)))

    def run(self, y: np.ndarray, spools, times: np.ndarray) -> np.ndarray:
        """Return the states at some times [N, 24] in SI, from `y` on at the first of them.

        What flows where a spool is shut stops at once.
        """
        y = y.reshape(3, 8).copy()
        for axis, spool in enumerate(spools):
            if is_shut(valve_ports(spool, self.p.valves[axis].law).port_1):
                y[axis, FLOW_1:] = 0.0
        found = solve_ivp(
            lambda _, z: self.rates(z, spools),
            (times[0], times[-1]),
            y.ravel(),
            method="Radau",
            t_eval=times,
            rtol=1e-7,
            atol=1e-9,
        )
        assert found.success, found.message
        return found.y.T * SCALE


def seals(f: Friction | None, u: float, p_1: float, p_2: float) -> float:
    """Return the friction [N] of seals that both chambers press against bore and rod."""
    if f is None:
        return 0.0
    sliding = f.coulomb_force + (f.pressure_coefficient or 0.0) * (max(p_1, 0.0) + max(p_2, 0.0))
    sticking = sliding * f.breakaway_force / f.coulomb_force
    share = math.exp(-((u / f.stribeck_speed) ** 2))
    return (share * sticking + (1.0 - share) * sliding) * u / math.hypot(u, f.smoothing_speed)


def opened_and_shut(machine: Machine, pose, axis: int, volts: float) -> tuple[np.ndarray, np.ndarray]:
    """Return one axis every 5 ms as the simulator has it [N, 6] and as two volumes have it [N, 8].

    Its valve opens at once for 0.15 s and is shut for 0.25 s.
    """
    two, spools = TwoVolumes(machine), tuple(volts if i == axis else 0.0 for i in range(3))
    shut_at, end, period = 0.15, 0.4, 5e-3
    moving = two.run(two.start(pose), spools, np.arange(0.0, shut_at + 1e-9, period))
    resting = two.run(moving[-1] / SCALE, (0.0, 0.0, 0.0), np.arange(shut_at, end + 1e-9, period))
    expected = np.concatenate([moving[1:], resting[1:]]).reshape(-1, 3, 8)[:, axis]
    rows = len(expected)
    table = np.zeros((rows * 20, 3))
    table[: round(shut_at / period) * 20, axis] = volts
    states = np.zeros((rows, len(STATE)))
    compiled_record()(equilibrium(pose, two.p), table, period / 20, two.p, states, None)
    return states[:, 6 * axis : 6 * axis + 6], expected
