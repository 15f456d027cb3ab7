"""Steps with a record: the state after every period, and the energy that passed through every part within it.

`compiled_plant` has the same as machine code; without llvmlite `record` is interpreted. The power
flows of `power_flows` are integrated by the integrator's own scheme, from both stages of each step.
A valve that shuts at once stops a flow between two states: what that destroys is added at once.

| array | shape | holds |
|---|---|---|
| voltages | M, 3 | V at the valves, one row per step |
| schedule | N | how many steps of which length [s] each period has, M in all; or the length of all |
| states | N, 121 | what `STATE` names, one row per period |
| energies | N, 69 | J over the period through what `ENERGY` names |
"""

import numpy as np

from forest_compile import flat_layout
from forest_description.types import AXES, Floats
from forest_sim.equations.drive import DriveState
from forest_sim.equations.elastic_links import RootState
from forest_sim.equations.multibody import HANGING_STILL, HeadState
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.command_history import SIZE, CommandHistory
from forest_sim.hydraulics.flow_force import Jets
from forest_sim.hydraulics.load_holding import Lifts
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.spool_dynamics import CENTRED, Spool
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.hydraulics.tank_line import TankState
from forest_sim.solver.integrator import WEIGHTS, Events, Simulation, parts, step_by_stages
from forest_sim.solver.power_flows import AxisPower, SupplyPower, power_flows, stopped_energy
from forest_sim.solver.step_schedule import StepSchedule, schedule_of

STATE = (
    *(f"{axis}_{field}" for axis in AXES for field in AxisState._fields),
    *(f"supply_{field}" for field in SupplyState._fields),
    *(f"head_{field}" for field in HeadState._fields),
    *(f"drive_{field}" for field in DriveState._fields),
    *(f"pump_{field}" for field in PumpState._fields),
    *(f"{axis}_root_{field}" for axis in AXES for field in RootState._fields),
    *(f"{axis}_spool_{field}" for axis in AXES for field in Spool._fields),
    *Events._fields,
    *(f"{name}_acceleration" for name in (*AXES, "head_alpha", "head_beta")),
    *(f"command_{field}_{k}" for field in CommandHistory._fields for k in range(SIZE)),
    *(f"{axis}_lift_{field}" for axis in AXES for field in Lifts._fields),
    *(f"{axis}_jets_{field}" for axis in AXES for field in Jets._fields),
    *(f"tank_{field}" for field in TankState._fields),
)
ENERGY = (
    *(f"pump_{field}" for field in SupplyPower._fields),
    *(f"{axis}_{field}" for axis in AXES for field in AxisPower._fields),
    *(f"{axis}_stopped" for axis in AXES),
)


def record(
    simulation: Simulation,
    voltages: Floats,
    schedule: StepSchedule | float,
    p: PlantParameters,
    states: Floats,
    energies: Floats | None,
) -> Simulation:
    """Advance the machine by one step for each row of voltages; fill `states` and `energies`.

    Without an array for them the energies, which take as long as the steps themselves, are left
    out.
    """
    schedule = schedule_of(schedule, len(states), len(voltages))
    after_row = np.cumsum(schedule.counts).astype(int).tolist()
    divided = parts(p)
    pack_flows = flat_layout.packer(power_flows(simulation, p))
    for row, (h, count, end) in enumerate(zip(*map(np.ndarray.tolist, schedule), after_row, strict=True)):
        for volts in voltages[end - round(count) : end].tolist():
            for _ in range(divided):
                taken = step_by_stages(simulation, (volts[0], volts[1], volts[2]), h / divided, p)
                if energies is not None:
                    early = np.array(pack_flows(power_flows(taken.early, p)))
                    late = np.array(pack_flows(power_flows(taken.late, p)))
                    flowed = h / divided * (WEIGHTS[0] * early + WEIGHTS[1] * late)
                    stopped = stopped_energy(simulation.plant, taken.early, taken.late, h / divided, p)
                    energies[row] += np.concatenate([flowed, stopped])
                simulation = taken.after
        store(simulation, states[row])
    return simulation


def store(simulation: Simulation, row: Floats) -> None:
    """Write a machine's state into a row of `STATE`'s length."""
    row[:] = _pack(simulation)


def restore(row: Floats) -> Simulation:
    """Return the machine that `store` wrote."""
    simulation: Simulation = _unpack(row.tolist())
    return simulation


_REST = AxisState(angle=0.0, rate=0.0, pressure_1=0.0, pressure_2=0.0, flow_1=0.0, flow_2=0.0)
_EXAMPLE = Simulation(
    PlantState(swing=_REST, boom=_REST, stick=_REST, supply=SupplyState(0.0, 0.0), head=HANGING_STILL),
    (CENTRED, CENTRED, CENTRED),
    Events(0, 0, 0),
    (0.0, 0.0, 0.0),
    (0.0, 0.0),
)
_pack, _unpack = flat_layout.packer(_EXAMPLE), flat_layout.unpacker(_EXAMPLE)
