"""The energy account of a run: what the engine gave and where it went. Thesis section 2.2, fig. 2.3.

| entry | is |
|---|---|
| engine | work of the shaft |
| pump | lost in the pump: friction, leakage, main relief valve |
| throttling | lost in valves (edges, compensators, load holding), less what chambers give back: compression |
| port_valves | lost over relief and anti-cavitation valves |
| hoses | lost to the hoses' resistance |
| leakage | lost in the swing motor |
| friction | lost to viscous and dry friction and in cushions |
| gear | lost between the teeth of a gear with play |
| bending | lost in links that give way |
| stops | taken by the end stops |
| mechanical | handed to the links, less what they gave back on their way down; see `link_account` |
| stopped | kinetic energy of oil in hoses that a valve shuts on, or that tears behind its edge: lost |
| return_line | lost in filter and tank line |
| stored | in oil, engine, motor, teeth, bristles and bent links, less what was there at the start |

The recorded flows of `power_flows` close at every instant, so their integrals close whatever the
states do: their sum tests nothing of a run. A valve that shuts at once stops oil between two
instants, and a torn column more than its law tells; `stopped` has that from the states on either
side. `with_stored_energy` computes `stored` from the states at both ends. What the account then
leaves open, `unaccounted`, is the error of the integration.
"""

from typing import NamedTuple

import numpy as np

from forest_description.hydraulics.hose import Line
from forest_description.types import AXES, Floats
from forest_sim.equations.drive import drive_energy
from forest_sim.equations.elastic_links import bending_energy
from forest_sim.equations.plant import at_joints, transmissions
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.oil_volume import OilVolume, stored_energy
from forest_sim.hydraulics.supply import manifold_energy
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.state_recording import ENERGY


class Account(NamedTuple):
    """Energies [J], or powers [W]; shape () or [N]."""

    engine: Floats
    pump: Floats
    throttling: Floats
    port_valves: Floats
    hoses: Floats
    leakage: Floats
    friction: Floats
    gear: Floats
    stops: Floats
    mechanical: Floats
    return_line: Floats
    stored: Floats
    bending: Floats
    stopped: Floats


_PARTS = {
    "engine": ("pump_engine",),
    "pump": ("pump_pump_friction", "pump_pump_leakage", "pump_main_relief"),
    "throttling": ("throttling", "holding", "compression"),
    "port_valves": ("port_valves",),
    "hoses": ("resistance",),
    "leakage": ("leakage",),
    "friction": ("damping", "dry_friction", "cushion"),
    "gear": ("gear",),
    "stops": ("stop",),
    "mechanical": ("joint",),
    "return_line": ("pump_return_line",),
    "stored": ("pump_manifold", "pump_flywheel", "pump_tank_line", "hose", "elastic"),
    "bending": ("bending",),
    "stopped": ("stopped",),
}


def dissipated_energy(energies: Floats) -> float:
    """Return what rows of energies turned into heat [J]: all but work on the links and what is stored."""
    total = account(np.sum(energies, axis=0))
    held = total.stored - total.stopped  # the power that stores knows nothing of what a valve stops
    return float(total.engine - total.mechanical - total.stops - held)


def account(energies: Floats) -> Account:
    """Return the account of recorded energies [..., 69], `state_recording.ENERGY`."""
    parts = {
        entry: sum(energies[..., place] for name in names for place in _places(name))
        for entry, names in _PARTS.items()
    }
    return Account(**parts)  # type: ignore[arg-type]


def _places(name: str) -> list[int]:
    """Return the columns of a flow: of the pump, or of all three axes."""
    if name in ENERGY:
        return [ENERGY.index(name)]
    return [ENERGY.index(f"{axis}_{name}") for axis in AXES]


def with_stored_energy(total: Account, first: Simulation, last: Simulation, p: PlantParameters) -> Account:
    """Return a run's account with `stored` from the states at both ends instead of by integrated power.

    Args:
        total: the integrals over the run [J].
        first: the machine at the start.
        last: the machine at the end.
        p: its parameters.
    """
    return total._replace(stored=np.asarray(stored_in(last, p) - stored_in(first, p)))


def unaccounted(total: Account) -> float:
    """Return what an account leaves open [J]: the engine's work less the sum of all other entries."""
    return float(total.engine) - float(sum(total[1:]))


def stored_in(simulation: Simulation, p: PlantParameters) -> float:
    """Return the energy [J] in the oil, engine, swing's drive (motor, teeth, bristles) and bent links."""
    plant, joints = simulation.plant, at_joints(simulation.plant, p)
    bent = (
        bending_energy(root, axis.angle, link)
        for root, axis, link in zip(plant.roots, plant.axes, p.elastic.links, strict=True)
    )
    turning = 0.5 * p.supply.drive.inertia * plant.pump.speed**2
    swung = drive_energy(plant.drive, joints.swing.angle, p.drive)
    return oil_energy(simulation, p) + turning + swung + sum(bent)


def oil_energy(simulation: Simulation, p: PlantParameters) -> float:
    """Return the energy [J] in manifold, tank line, hoses, chambers: C P^2/2, I Q^2/2, `stored_energy`."""
    plant = at_joints(simulation.plant, p)
    supply = 0.0 if p.supply.ideal else manifold_energy(plant.supply.pressure, p.supply)
    at = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    returning = 0.5 * p.tank_line.capacitance * simulation.midpoint.tank.pressure**2
    return (
        supply
        + returning
        + sum(
            _hose(axis.line_1, axis.oil_1, state.pressure_1, state.flow_1, t.position)
            + _hose(axis.line_2, axis.oil_2, state.pressure_2, state.flow_2, t.position)
            for state, t, axis in zip(plant.axes, at, p.axes, strict=True)
        )
    )


def _hose(line: Line, oil: OilVolume, pressure: float, flow: float, position: float) -> float:
    moving = 0.5 * line.inertance * flow**2
    if oil.yields:
        return stored_energy(pressure, position, oil) + moving
    return 0.5 * line.capacitance * pressure**2 + moving
