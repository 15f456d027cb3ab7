"""The thesis' test rigs as simulated circuits: valve alone, and a hose with meters at both ends.

A circuit is a machine whose swing axis is on the bench: pump, valve, hose of port 1, a load, hose of port 2,
valve, tank. The load is a positive-displacement meter with a brake: it passes the flow Q with the loss R_L Q
and next to no inertance. So the laws, the integrator and the sensors are those of the whole machine.

| rig | thesis | hose 1 | what is read |
|---|---|---|---|
| valve | fig. 4.3 | a short piece | supply, both valve ports, flow, spool, voltage |
| compensator | - | the same | the same, under a load that takes all of the pump's pressure |
| hose | fig. 4.5, 4.7 | the hose, whole | pressure and flow at its entrance and its exit |

The motor's rig (fig. 4.9) is the machine itself with its platform tilted, see `experiments`.

| symbol | name | unit |
|---|---|---|
| D | displacement of the braked meter | m^3/rad |
| R_L | resistance of the load | Pa s/m^3 |
"""

import dataclasses
from functools import lru_cache

from forest_description.derived.actuator_kinematics import displacements, rated_speeds
from forest_description.hydraulics.hose import GeometricHose, MeasuredHose
from forest_description.machine import Machine, load_machine
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.sensors.sensor_kinds import Sensors
from forest_description.types import AXES

DISPLACEMENT = 0.01  # [m^3/rad] D: so small that a brake may take all of a pump's pressure
INERTIA = 1.0  # [kg m^2] of the meter: an inertance of 1e4 Pa s^2/m^3, three thousandths of the hose's
WEIGHTLESS = 1e-6  # [kg] of boom and stick, whose inertia about the swing axis is left out
TIGHT = 1e18  # [Pa s/m^3] leakage of the meter: none
SHORT = 0.3  # [m] of hose between valve and load
VALVE_LOAD, HOSE_LOAD = 1e8, 1.5e9  # [Pa s/m^3] R_L
OVERLOAD = 1.5  # times the pump's pressure, that the brake would take of the full flow
OF_THE_CRANE = ("chambers", "friction", "holding_1", "holding_2", "elasticity")
"""What an actuator has on the crane alone: of idle cylinders it would take three fourths of a simulation."""
LOAD_KEY = "swing.damping"
"""The load's number in a rig's machine: R_L D^2."""


def as_measured(machine: Machine, hose: MeasuredHose | GeometricHose) -> MeasuredHose:
    """Return a hose as the experiments see one: four numbers of a piece of it. Thesis eq. 4.3, 4.4, 4.5b."""
    if isinstance(hose, MeasuredHose):
        return hose
    assert machine.oil is not None  # a machine with a geometric hose has one
    length = 4.0
    turbulent, laminar = (hose.line(length, flag, machine.oil) for flag in (False, True))
    return MeasuredHose(
        length=length,
        bore=hose.bore,
        turbulent_resistance=turbulent.resistance,
        laminar_resistance=laminar.resistance,
        inertance=turbulent.inertance,
        capacitance=turbulent.capacitance,
    )


def valve_bench(machine: Machine, axis: int = 0, load: float = VALVE_LOAD) -> Machine:
    """Return the rig of fig. 4.3 with the valve of an axis. Thesis section 4.3.2, fig. 4.3.

    Args:
        machine: whose valve, pump, oil and hose are on the bench.
        axis: 0 swing, 1 boom, 2 stick.
        load: R_L [Pa s/m^3].
    """
    return _bench(machine, axis, SHORT, laminar=False, load=load)


def overloaded_bench(machine: Machine, axis: int = 0) -> Machine:
    """Return the rig of a valve whose load takes all of the pump's pressure, from two thirds of its flow on.

    Args:
        machine: whose valve has a compensator.
        axis: 0 swing, 1 boom, 2 stick.
    """
    displacement, _ = displacements(machine, axis)
    full = rated_speeds(machine)[axis] * displacement
    return valve_bench(machine, axis, OVERLOAD * machine.pump.supply_pressure / full)


def hose_bench(machine: Machine, axis: int = 0, laminar: bool = False, load: float = HOSE_LOAD) -> Machine:
    """Return the rig of fig. 4.5 and 4.7 with an axis' hose. Thesis section 4.3.3, 4.3.4, fig. 4.5, 4.7.

    Args:
        machine: whose hose is on the bench, in the length it was measured with.
        axis: 0 swing, 1 boom, 2 stick.
        laminar: which of the two laws of its resistance holds.
        load: R_L [Pa s/m^3].
    """
    length = as_measured(machine, machine.hose_of(axis)).length
    return _bench(machine, axis, length, laminar, load)


def _bench(machine: Machine, axis: int, length: float, laminar: bool, load: float) -> Machine:
    drive = dataclasses.replace(
        machine.swing,
        motor_displacement=1e-3,
        gear_ratio=DISPLACEMENT / 1e-3,
        internal_leakage_resistance=TIGHT,
        external_leakage_resistance=TIGHT,
        damping=load * DISPLACEMENT**2,
        line_1_length=length,
        line_2_length=SHORT,
        length_exponent=1.0,
        flow_regime="laminar" if laminar else "turbulent",
        valve=machine.valve_of(axis),
        hose=as_measured(machine, machine.hose_of(axis)),
        lower_limit=-20.0,
        upper_limit=20.0,
        **dict.fromkeys((*OF_THE_CRANE, "backlash")),
    )
    idle = {
        name: dataclasses.replace(getattr(machine, name), **dict.fromkeys(OF_THE_CRANE)) for name in AXES[1:]
    }
    return dataclasses.replace(
        machine,
        swing=drive,
        **idle,
        manipulator=_nothing_to_move(machine.manipulator),
        sensors=meters(machine),
        port_valves=None,
        end_stops=None,
    )


def _nothing_to_move(m: Manipulator) -> Manipulator:
    """Return links of which only the meter's inertia is felt."""
    bare = {
        field.name: 0.0
        for field in dataclasses.fields(m)
        if field.name.endswith(("_mass", "_xx", "_yy", "_xy", "_zz")) or field.name == "gravity"
    }
    bare |= {"base_zz": INERTIA, "boom_zz": 1e3, "stick_zz": 1e3}
    bare |= {"boom_mass": WEIGHTLESS, "stick_mass": WEIGHTLESS}
    return dataclasses.replace(m, log=None, pendulum=None, head_folding="thesis", **bare)


@lru_cache(maxsize=1)
def _usual() -> Sensors:
    return load_machine("c180_hoses").sensors


def meters(machine: Machine) -> Sensors:
    """Return the sensors of a bench: the machine's, and those of Table 4.2 that it lacks.

    A bench's record must be fitted with these. Without flow meters in the machine file, the floor of the
    bench's meters would be taken for flow.
    """
    usual, own = _usual(), machine.sensors
    wanted = ("pressure", "flow_meter", "spool_sensor", "thermocouple")
    missing = {name: getattr(usual, name) for name in wanted if getattr(own, name) is None}
    return dataclasses.replace(own, **missing)
