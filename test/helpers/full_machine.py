"""What tests of the kernel share: pumps of every sort, a machine with everything, its state as an array."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.integrate import solve_ivp

from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.hydraulics.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
)
from forest_description.hydraulics.valve_parameters import BackwardValve, TableCurve
from forest_description.machine import Machine, load_machine
from forest_description.mechanics.drives import Backlash, BearingFriction, Cushion, Friction
from forest_description.mechanics.elasticity_parameters import Elasticity
from forest_description.mechanics.load import Log, Pendulum
from forest_sim.analysis.modes import states
from forest_sim.equations.drive import DriveState
from forest_sim.equations.elastic_links import Roots, RootState
from forest_sim.equations.multibody import HeadState
from forest_sim.equations.plant import AxisState, PlantState, state_derivative
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.integrator import ports_of

C180 = load_machine("c180_hoses")
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)
PRESSURE = C180.pump.supply_pressure
SHARED = {field.name: getattr(C180.pump, field.name) for field in dataclasses.fields(ConstantFlowPump)}
BAND, RELIEF = C180.pump.compensator_band, C180.pump.relief_pressure

PUMPS = {
    "ideal": IdealPump(PRESSURE),
    "compensated": PressureCompensatedPump(**SHARED, relief_pressure=RELIEF, compensator_band=BAND),
    "constant flow": ConstantFlowPump(**SHARED),
    "load sensing": LoadSensingPump(
        **SHARED, relief_pressure=RELIEF, compensator_band=BAND, margin=2e6, response_time=0.05
    ),
}
FRICTION = Friction(coulomb_force=4e3, breakaway_force=7e3, stribeck_speed=0.02, smoothing_speed=2e-3)
BEARING = BearingFriction(800.0, 1100.0, 0.01, stiffness=1e7, damping=5e4, elastic_share=0.8)
BACKLASH = Backlash(free_way=1.5e-3, motor_inertia=2.4e-3, stiffness=3e7, damping=1.2e4)
ELASTIC = Elasticity(stiffness=2e7, damping=2e4, root_inertia=80.0)
CUSHION = Cushion(length=0.08, resistance=3e7)


def with_pump(name: str, machine: Machine = C180, **changes: float) -> Machine:
    """Return a machine with another pump."""
    return dataclasses.replace(machine, pump=dataclasses.replace(PUMPS[name], **changes))


def rigid(machine: Machine) -> Machine:
    """Return a machine whose links do not give way."""
    swing, boom, stick = (dataclasses.replace(drive, elasticity=None) for drive in machine.drives)
    return dataclasses.replace(machine, swing=swing, boom=boom, stick=stick)


def full_machine(pump: str = "load sensing") -> Machine:
    """Return a machine that has every component, its axes' valves and hoses of different sorts."""
    leaking = dataclasses.replace(
        C180.valve,
        leakage_conductance=2e-13,
        port_2_area=0.8,
        backward=BackwardValve(deadband_voltage=1.3, minimum_resistance=1.5e12),
        spool_damping=0.7,
    )
    underlapped = dataclasses.replace(C180.valve, deadband_voltage=-0.2, leakage_conductance=1e-13)
    measured = dataclasses.replace(
        C180.valve, curve=TableCurve((2.0, 4.0, 7.0, 10.0), (9e13, 1.2e13, 3e12, 1e12)), spool_bandwidth=20.0
    )
    swing = dataclasses.replace(
        C180.swing,
        flow_regime="turbulent",
        valve=leaking,
        friction=BEARING,
        backlash=BACKLASH,
        elasticity=ELASTIC,
    )
    boom = dataclasses.replace(
        C180.boom,
        flow_regime="laminar",
        valve=underlapped,
        friction=FRICTION,
        cushion=CUSHION,
        elasticity=ELASTIC,
    )
    stick = dataclasses.replace(
        C180.stick, valve=measured, friction=FRICTION, cushion=CUSHION, elasticity=ELASTIC
    )
    hanging = dataclasses.replace(
        C180.manipulator, pendulum=Pendulum(1.2, 60.0, 300.0), log=Log(mass=400.0, x=0.5, y=0.0)
    )
    return dataclasses.replace(
        with_pump(pump),
        name=f"full, {pump}",
        swing=swing,
        boom=boom,
        stick=stick,
        manipulator=hanging,
    )


def advance(simulation, voltages, h, count, p):
    return compiled_advance()(simulation, voltages, h, count, p)


AXIS_SCALE, PUMP_SCALE = [1.0, 1.0, 2e7, 2e7, 3e-3, 3e-3], [1.0, 100.0]
# A root weighs a hundredth of its link: its rate [rad/s] is as exact as that needs.
ROOT_SCALE = [1.0, 10.0]
SCALE = np.array(
    [*(AXIS_SCALE * 3), 2e7, 2e7, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1e-3, *PUMP_SCALE, *(ROOT_SCALE * 3)]
)


def pack(state: PlantState) -> np.ndarray:
    """Return all states over their scales: axes, supply, hanging head, swing's drive, pump and roots."""
    return states(state) / SCALE


def unpack(y: np.ndarray) -> PlantState:
    """Return the state that `pack` was given."""
    v = (y * SCALE).tolist()
    axes = (AxisState(*v[0:6]), AxisState(*v[6:12]), AxisState(*v[12:18]))
    head, drive, pump = HeadState(*v[20:24]), DriveState(*v[24:27]), PumpState(*v[27:29])
    roots = Roots(RootState(*v[29:31]), RootState(*v[31:33]), RootState(*v[33:35]))
    return PlantState(*axes, SupplyState(*v[18:20]), head, drive, pump, roots)


def reference(simulation, p: PlantParameters, seconds: float) -> np.ndarray:
    """Integrate `state_derivative` with the spools held, by scipy's Radau."""
    ports = ports_of(simulation, p)
    solution = solve_ivp(
        lambda _, y: pack(state_derivative(unpack(y), ports, p)),
        (0.0, seconds),
        pack(simulation.plant),
        method="Radau",
        rtol=1e-8,
        atol=1e-10,
    )
    assert solution.success, solution.message
    return solution.y[:, -1]
