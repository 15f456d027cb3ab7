"""The equations of motion in Appendix B's form: arrays of 18 states and of 6 resistances."""

import math

import numpy as np
from numpy.typing import ArrayLike

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_sim.equations.multibody import HANGING_STILL
from forest_sim.equations.plant import AxisState, PlantState, state_derivative
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.port import Port
from forest_sim.hydraulics.supply import SupplyState


def to_array(state: PlantState) -> Floats:
    """Return the 18 states as an array in Appendix B's order."""
    return np.array([*state.swing, *state.boom, *state.stick], dtype=np.float64)


def from_array(x: ArrayLike, supply_pressure: float) -> PlantState:
    """Return the state that an array of 18 in Appendix B's order holds, with the supply at a pressure [Pa].

    Raises:
        ValueError: the array does not hold 18 finite numbers.
    """
    values = np.asarray(x, dtype=np.float64)
    if values.shape != (18,) or not np.all(np.isfinite(values)):
        raise ValueError(
            f"state x must hold 18 finite numbers in Appendix B's order, got shape {values.shape}"
        )
    v = values.tolist()
    supply = SupplyState(supply_pressure, supply_pressure)
    return PlantState(
        swing=AxisState(*v[0:6]),
        boom=AxisState(*v[6:12]),
        stick=AxisState(*v[12:18]),
        supply=supply,
        head=HANGING_STILL,
    )


def thesis_state_derivative(x: ArrayLike, c_r: ArrayLike, p_s: float, machine: Machine) -> Floats:
    """Return xdot of Appendix B, corrected, for given orifice resistances.

    Thesis eq. 3.20, App. B. Differs: docs/explanation/equations.md lists the corrections.
    Port 1 of every valve is connected to the supply, port 2 to the tank.

    Args:
        x: 18 states in Appendix B's order (`plant`).
        c_r: Crv1, Crv2 of swing, boom, stick, 6 resistances [Pa s^2/m^6], not negative.
        p_s: supply pressure [Pa].
        machine: `load_machine("c180_thesis")` gives Appendix B's numbers.

    Returns:
        xdot, shape (18,), in x's units per second.

    Raises:
        ValueError: wrong shape, or a value that is not finite (c_r may be inf where the flow is
            zero).
    """
    resistances = np.asarray(c_r, dtype=np.float64)
    if resistances.shape != (6,) or not np.all(resistances >= 0.0):
        raise ValueError(f"c_r must hold 6 resistances of at least 0 Pa s^2/m^6, got {c_r!r}")
    if not math.isfinite(p_s):
        raise ValueError(f"p_s must be a finite pressure [Pa], got {p_s}")
    r = resistances.tolist()
    ports = [Ports(Port(r[2 * i], math.inf, 0.0), Port(math.inf, r[2 * i + 1], 0.0)) for i in range(3)]
    state = from_array(x, float(p_s))
    derivative = state_derivative(state, (ports[0], ports[1], ports[2]), plant_parameters(machine))
    return to_array(derivative)
