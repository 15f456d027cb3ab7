"""The energy account of the links: the actuators' work, and where it went.

| entry | is |
|---|---|
| actuators | work of the actuators on the joints, `mechanical` of the machine's account |
| tip_force | work of an outer force on the tip |
| links | kinetic and potential energy of crane, head and log, less what was there at the start |
| sway | lost to the damping of a hanging head's joint |
| joining | lost where a log that lay still joined the head |
| carried_off | taken along by dropped logs, less what grasped ones brought |

`links` comes from the states at both ends, `joining` and `carried_off` from those at a change. So
what is `unaccounted` is the error of the integration, and of the trapezoids between the rows.
"""

from typing import NamedTuple

import numpy as np

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import AXES, Floats, Vec3
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.energy_account import account
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.simulation.open_loop import Block
from forest_sim.solver.load_change import link_energy
from forest_sim.solver.state_recording import ENERGY, STATE, restore

_ANGLES = [STATE.index(f"{axis}_angle") for axis in AXES]
_RATES = [STATE.index(name) for name in ("boom_rate", "stick_rate", "head_alpha_rate", "head_beta_rate")]


class LinkAccount(NamedTuple):
    """Energies [J]."""

    actuators: float
    tip_force: float
    links: float
    sway: float
    joining: float
    carried_off: float

    @property
    def unaccounted(self) -> float:
        """What the account leaves open [J]."""
        return self.actuators + self.tip_force - sum(self[2:])


class LinkBalance:
    """The account of a run, gathered block by block.

    Args:
        machine: that runs.
        tip_force: on its tip all the time [N].
    """

    def __init__(self, machine: Machine, tip_force: Vec3) -> None:
        self._machine, self._tip_force = machine, np.array(tip_force)
        self._p = plant_parameters(machine)
        self._first: Block | None = None
        self._last: Block | None = None
        self._energies, self._changes, self._sway = np.zeros(len(ENERGY)), np.zeros(2), 0.0

    def add(self, block: Block) -> None:
        """Take a block into account."""
        if self._last is None:
            self._first = block
        else:
            states = np.vstack([self._last.states[-1:], block.states])
            times = np.concatenate([self._last.time[-1:], block.time])
            power = self._damping_power(states)
            self._sway += float(0.5 * (power[1:] + power[:-1]) @ np.diff(times))
        self._last = block
        self._energies += block.energies.sum(axis=0)
        self._changes += block.load_change.sum(axis=0)

    def result(self) -> LinkAccount:
        """Return the account so far."""
        assert self._first is not None
        assert self._last is not None
        way = self._tip(self._last.states[-1]) - self._tip(self._first.states[0])
        joining, carried_off = self._changes.tolist()
        return LinkAccount(
            actuators=float(account(self._energies).mechanical),
            tip_force=float(self._tip_force @ way),
            links=self._links(self._last) - link_energy(restore(self._first.states[0]).plant, self._p),
            sway=self._sway,
            joining=joining,
            carried_off=carried_off,
        )

    def _links(self, block: Block) -> float:
        """Return kinetic and potential energy of links and log at a block's end [J]."""
        mass, length = block.load[-1].tolist()
        p = loaded(self._p, self._machine.manipulator, Load(mass, length))
        return link_energy(restore(block.states[-1]).plant, p)

    def _damping_power(self, states: Floats) -> Floats:
        """Return what the damping of the head's joint takes [N] W."""
        boom, stick, alpha, beta = states[:, _RATES].T
        power: Floats = self._p.head.damping * ((alpha - boom - stick) ** 2 + beta**2)
        return power

    def _tip(self, state: Floats) -> Floats:
        swing, boom, stick = state[_ANGLES].tolist()
        return np.array(tip_position((swing, boom, stick), self._machine.manipulator.links))
