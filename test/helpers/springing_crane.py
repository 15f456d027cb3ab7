"""A crane in its plane on the oil that its valves have shut in, by itself.

Independent of `forest_sim`: mass points and bars by their Jacobians, a pressure a hose, scipy.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from forest_description.machine import Machine

STEP = 1e-6  # [rad] of the mass matrix' derivatives


class SpringingCrane:
    """Boom and stick of a machine with a fixed head and oil without air; its port valves stay shut."""

    def __init__(self, machine: Machine) -> None:
        m, self.machine = machine.manipulator, machine
        self.lengths, self.gravity = (m.boom_length, m.stick_length), m.gravity
        self.bars = [  # link, along, across, mass, inertia
            (0, m.boom_x, m.boom_y, m.boom_mass, m.boom_zz),
            (1, m.stick_x, m.stick_y, m.stick_mass, m.stick_zz),
            (1, m.stick_length, 0.0, m.head_mass, 0.0),
        ]

    def mass_and_weight(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return M [2, 2] and the weight's torques [2]."""
        mass, weight = np.zeros((2, 2)), np.zeros(2)
        for link, along, across, m, inertia in self.bars:
            first, turn = q[0], q[0] + link * q[1]
            at = along * np.exp(1j * turn) + across * 1j * np.exp(1j * turn)
            at_boom = at + link * self.lengths[0] * np.exp(1j * first)
            moves = 1j * np.array([at_boom, link * at])  # complex: forwards and up
            turns = np.array([1.0, link])
            mass += m * np.real(np.outer(moves, moves.conj())) + inertia * np.outer(turns, turns)
            weight += m * self.gravity * moves.imag
        return mass, weight

    def _velocity_torques(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        steps = STEP * np.eye(2)
        dm = [(self.mass_and_weight(q + s)[0] - self.mass_and_weight(q - s)[0]) / (2.0 * STEP) for s in steps]
        return np.einsum("kij,k,j->i", dm, u, u) - 0.5 * np.einsum("ijk,j,k->i", dm, u, u)

    def derivative(self, _time: float, x: np.ndarray) -> np.ndarray:
        """Return d/dt of two angles, two rates, and the pressures of boom and stick [MPa]."""
        q, u, pressures = x[:2], x[2:4], 1e6 * x[4:].reshape(2, 2)
        mass, weight = self.mass_and_weight(q)
        torques, changes = np.zeros(2), np.zeros((2, 2))
        for axis, drive in enumerate((self.machine.boom, self.machine.stick)):
            a, b, offset = drive.pivot_to_base, drive.pivot_to_rod, drive.angle_offset
            length = math.sqrt(a * a + b * b - 2.0 * a * b * math.cos(q[axis] + offset))
            arm = a * b * math.sin(q[axis] + offset) / length
            speed = arm * u[axis]
            flows = np.array([drive.head_area * speed, -drive.rod_area * speed])
            yielding, drops = self._oil(axis, length, flows)
            chambers = pressures[axis] - drops
            force = drive.head_area * chambers[0] - drive.rod_area * chambers[1] - drive.damping * speed
            torques[axis] = arm * force
            dense = 1.0 if drive.chambers is None else 1.0 + pressures[axis] / self.machine.oil.bulk_modulus
            changes[axis] = -dense * flows / yielding
        acceleration = np.linalg.solve(mass, torques - weight - self._velocity_torques(q, u))
        return np.concatenate([u, acceleration, 1e-6 * changes.ravel()])

    def _oil(self, axis: int, length: float, flows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return capacitances, and drops on the way to the piston [Pa]: in chambers there are none."""
        drive = (self.machine.boom, self.machine.stick)[axis]
        lines = [self.machine.line(axis + 1, port) for port in (1, 2)]
        hoses, resistances = np.array([[line.capacitance, line.resistance] for line in lines]).T
        if drive.chambers is None:
            return hoses, resistances * flows * (1.0 if drive.flow_regime == "laminar" else np.abs(flows))
        way = length - drive.retracted_length
        head = drive.chambers.head_dead_volume + drive.head_area * way
        rod = drive.chambers.rod_dead_volume + drive.rod_area * (drive.stroke - way)
        return hoses + np.array([head, rod]) / self.machine.oil.bulk_modulus, np.zeros(2)

    def run(self, start: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return the states [N, 8] at some times [s], from one at the first of them."""
        span = float(times[0]), float(times[-1])
        found = solve_ivp(self.derivative, span, start, "Radau", t_eval=times, rtol=1e-6, atol=1e-9)
        return found.y.T
