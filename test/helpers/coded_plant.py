"""The coded equations of motion in Appendix B's form: arrays of 18 states and of 6 resistances."""

import math

import numpy as np

from forest_sim.equations.multibody import HANGING_STILL
from forest_sim.equations.plant import AxisState, PlantState, state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.port import Port
from forest_sim.hydraulics.supply import SupplyState


def to_array(state):
    """Return the 18 states as an array in Appendix B's order."""
    return np.array([*state.swing, *state.boom, *state.stick], dtype=np.float64)


def from_array(x, supply_pressure):
    """Return the state that an array of 18 in Appendix B's order holds, and a supply pressure [Pa]."""
    axes = (AxisState(*values) for values in np.asarray(x, dtype=np.float64).reshape(3, 6).tolist())
    return PlantState(*axes, supply=SupplyState(supply_pressure, supply_pressure), head=HANGING_STILL)


def thesis_state_derivative(x, c_r, p_s, machine):
    """Return xdot [18] of the coded plant for orifice resistances c_r [6] and a supply pressure [Pa].

    Port 1 of every valve is connected to the supply, port 2 to the tank, as in Appendix B.
    """
    r = np.asarray(c_r, dtype=np.float64).tolist()
    ports = (Ports(Port(r[2 * i], math.inf, 0.0), Port(math.inf, r[2 * i + 1], 0.0)) for i in range(3))
    return to_array(state_derivative(from_array(x, float(p_s)), tuple(ports), plant_parameters(machine)))
