"""A machine at another temperature of its oil: the same machine with every number that the oil changes.

Symbols, each the value at the new temperature over that at the reference temperature:
    m  absolute viscosity μ
    r  density ρ
    b  bulk modulus β

What changes, and how:
    measured hose    R laminar m; R turbulent m^¼ r^¾ (Thesis eq. 4.3); I r; of C the oil's part 1/b, the
                     wall's part not (``MeasuredHose.oil_share``)
    geometric hose   made from the oil anew, ``GeometricHose.line``
    valve            C_R of edges and compensator r (sharp: viscosity has no say); leakage past the edges 1/m
    load holding     C_R of valve and check r
    motor, pump      leakage resistances m; capacitance of the manifold, whose walls are rigid, 1/b
    tank line        R r; C 1/b
    cushions         r, as orifices

What does not: viscous and dry friction of motor and cylinders and the pump's mechanical efficiency, which are
lumps of seals, bearings and oil; relief and anti-cavitation valves; spools; the flow regime. A hose that the
machine calls turbulent stays so in cold oil, where it would be laminar and lose more: the thesis' hose at 50
gal/min has Re = 4600 at 40 °C, 1600 at 20 °C.
"""

from typing import NamedTuple

from forest_description.config.parameter import MachineError, replace_unchecked
from forest_description.hydraulics.hose import Hose, MeasuredHose
from forest_description.hydraulics.load_holding_parameters import LoadHolding, RuptureValve
from forest_description.hydraulics.oil import Oil
from forest_description.hydraulics.pump import IdealPump, Pump
from forest_description.hydraulics.tank_line_parameters import TankLine
from forest_description.hydraulics.valve_parameters import Valve
from forest_description.machine import Machine
from forest_description.mechanics.drives import CylinderDrive, SwingDrive


class Change(NamedTuple):
    """The oil at a new temperature over the oil as it was."""

    viscosity: float  # m
    density: float  # r
    bulk_modulus: float  # b
    was: Oil


def at_temperature(machine: Machine, temperature: float) -> Machine:
    """Return a machine with its oil at another temperature.

    The machine itself at its reference temperature, and at any temperature if it has no oil. The result's
    reference temperature is the new one, so that a machine may be warmed again and again, and back.

    Args:
        machine: Its numbers hold at ``machine.oil.reference_temperature``.
        temperature: Of the oil, everywhere the same [K].

    Raises:
        MachineError: The temperature is outside its range; other numbers may leave theirs.
    """
    oil = machine.oil
    if oil is None or temperature == oil.reference_temperature:
        return machine
    try:
        change = change_of(oil, oil.at(temperature))
        return replace_unchecked(
            machine,
            oil=oil.at(temperature),
            pump=_pump(machine.pump, change),
            valve=_valve(machine.valve, change),
            hose=_hose(machine.hose, change),
            swing=_swing(machine.swing, change),
            boom=_cylinder(machine.boom, change),
            stick=_cylinder(machine.stick, change),
            tank_line=_tank_line(machine.tank_line, change),
        )
    except MachineError as error:
        raise MachineError(f"{machine.name} with its oil at {temperature:g} K: {error}") from error


def change_of(was: Oil, now: Oil) -> Change:
    """Return by how much an oil has changed from one reference temperature to another."""
    before = was.absolute_viscosity(was.reference_temperature)
    return Change(
        viscosity=now.absolute_viscosity(now.reference_temperature) / before,
        density=now.density / was.density,
        bulk_modulus=now.bulk_modulus / was.bulk_modulus,
        was=was,
    )


def _pump(pump: Pump, change: Change) -> Pump:
    if isinstance(pump, IdealPump):
        return pump
    return replace_unchecked(
        pump,
        leakage_resistance=pump.leakage_resistance * change.viscosity,
        manifold_capacitance=pump.manifold_capacitance / change.bulk_modulus,
    )


def _valve(valve: Valve, change: Change) -> Valve:
    backward, compensator = valve.backward, valve.compensator
    if compensator is not None:
        c_r = compensator.minimum_resistance * change.density
        compensator = replace_unchecked(compensator, minimum_resistance=c_r)
    if backward is not None:
        c_r = backward.minimum_resistance * change.density
        backward = replace_unchecked(backward, minimum_resistance=c_r)
    return replace_unchecked(
        valve,
        minimum_resistance=valve.minimum_resistance * change.density,
        leakage_conductance=valve.leakage_conductance / change.viscosity,
        backward=backward,
        compensator=compensator,
    )


def _holding(valve: LoadHolding | None, change: Change) -> LoadHolding | None:
    if valve is None:
        return None
    c_r = valve.minimum_resistance * change.density
    if isinstance(valve, RuptureValve):
        return replace_unchecked(valve, minimum_resistance=c_r)
    check = valve.check_resistance * change.density
    return replace_unchecked(valve, minimum_resistance=c_r, check_resistance=check)


def _tank_line(line: TankLine | None, change: Change) -> TankLine | None:
    if line is None:
        return None
    return replace_unchecked(
        line, resistance=line.resistance * change.density, capacitance=line.capacitance / change.bulk_modulus
    )


def _hose(hose: Hose, change: Change) -> Hose:
    """Return a warmed hose. Thesis eq. 4.3, 4.5b."""
    if not isinstance(hose, MeasuredHose):
        return hose
    share = hose.oil_share(change.was.bulk_modulus)
    turbulent = change.viscosity**0.25 * change.density**0.75
    return replace_unchecked(
        hose,
        turbulent_resistance=hose.turbulent_resistance * turbulent,
        laminar_resistance=hose.laminar_resistance * change.viscosity,
        inertance=hose.inertance * change.density,
        capacitance=hose.capacitance * (1.0 - share + share / change.bulk_modulus),
    )


def _swing(drive: SwingDrive, change: Change) -> SwingDrive:
    return replace_unchecked(
        drive,
        internal_leakage_resistance=drive.internal_leakage_resistance * change.viscosity,
        external_leakage_resistance=drive.external_leakage_resistance * change.viscosity,
        valve=None if drive.valve is None else _valve(drive.valve, change),
        hose=None if drive.hose is None else _hose(drive.hose, change),
        holding_1=_holding(drive.holding_1, change),
        holding_2=_holding(drive.holding_2, change),
    )


def _cylinder(drive: CylinderDrive, change: Change) -> CylinderDrive:
    cushion = drive.cushion
    if cushion is not None:
        cushion = replace_unchecked(cushion, resistance=cushion.resistance * change.density)
    return replace_unchecked(
        drive,
        valve=None if drive.valve is None else _valve(drive.valve, change),
        hose=None if drive.hose is None else _hose(drive.hose, change),
        holding_1=_holding(drive.holding_1, change),
        holding_2=_holding(drive.holding_2, change),
        cushion=cushion,
    )
