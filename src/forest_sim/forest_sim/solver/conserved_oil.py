"""What a step conserves: the oil of each volume, in place of its pressure.

Where hose and chamber hold oil that yields (`oil_volume`), a step is linear in that oil and loses
none of it; the pressure follows from it. Where a hose has a constant capacitance, oil and pressure
are one, and both functions here return what they are given.
"""

from forest_sim.equations.plant import AxisState, PlantState, Transmission, at_joints, transmissions
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.hydraulics.load_holding import AllLifts, Lifts
from forest_sim.hydraulics.oil_volume import content, settled_pressure
from forest_sim.hydraulics.supply import SupplyState, manifold_oil
from forest_sim.midpoint.holding_step import flowing


def with_contents(state: PlantState, lifts: AllLifts, p: PlantParameters) -> PlantState:
    """Return a state with the oil that each volume holds [m^3] in place of its pressure.

    Oil stops where a load-holding valve has shut on it.
    """
    return _contents(state, lifts, p) if _conserves_oil(p) else state


def settled(state: PlantState, contents: PlantState, p: PlantParameters) -> PlantState:
    """Return a state with the pressures at which each volume holds its oil; the inverse of `with_contents`.

    Args:
        state: with pressures near them; the manifold's is left.
        contents: the same with oil in place of pressures.
        p: the machine.
    """
    return _settled(state, contents, p) if _conserves_oil(p) else state


def _conserves_oil(p: PlantParameters) -> bool:
    swing, boom, stick = p.swing.oil_1.yields != 0, p.boom.oil_1.yields != 0, p.stick.oil_1.yields != 0
    return swing or boom or stick or p.supply.volume > 0.0


def _settled(state: PlantState, contents: PlantState, p: PlantParameters) -> PlantState:
    """Return what `settled` does; not inlined."""
    joints = at_joints(state, p)
    t_1, t_2, t_3 = transmissions(joints.swing.angle, joints.boom.angle, joints.stick.angle, p)
    return PlantState(
        swing=_settled_axis(state.swing, contents.swing, t_1, p.swing),
        boom=_settled_axis(state.boom, contents.boom, t_2, p.boom),
        stick=_settled_axis(state.stick, contents.stick, t_3, p.stick),
        supply=state.supply,
        head=state.head,
        drive=state.drive,
        pump=state.pump,
        roots=state.roots,
    )


def _settled_axis(s: AxisState, contents: AxisState, t: Transmission, axis: Axis) -> AxisState:
    if not axis.oil_1.yields:
        return s
    return AxisState(
        angle=s.angle,
        rate=s.rate,
        pressure_1=settled_pressure(s.pressure_1, contents.pressure_1, t.position, axis.oil_1),
        pressure_2=settled_pressure(s.pressure_2, contents.pressure_2, t.position, axis.oil_2),
        flow_1=s.flow_1,
        flow_2=s.flow_2,
    )


def _contents(state: PlantState, lifts: AllLifts, p: PlantParameters) -> PlantState:
    """Return what `with_contents` does; not inlined."""
    joints = at_joints(state, p)
    t_1, t_2, t_3 = transmissions(joints.swing.angle, joints.boom.angle, joints.stick.angle, p)
    return PlantState(
        swing=_axis_contents(state.swing, t_1, lifts[0], p.swing),
        boom=_axis_contents(state.boom, t_2, lifts[1], p.boom),
        stick=_axis_contents(state.stick, t_3, lifts[2], p.stick),
        supply=SupplyState(manifold_oil(state.supply.pressure, p.supply), state.supply.reference),
        head=state.head,
        drive=state.drive,
        pump=state.pump,
        roots=state.roots,
    )


def _axis_contents(s: AxisState, t: Transmission, lifts: Lifts, axis: Axis) -> AxisState:
    if not axis.oil_1.yields:
        return s
    flow_1, flow_2 = s.flow_1, s.flow_2
    if axis.holds:
        flow_1 = flowing(flow_1, lifts.one, axis.holding_1)
        flow_2 = -flowing(-flow_2, lifts.two, axis.holding_2)
    return AxisState(
        angle=s.angle,
        rate=s.rate,
        pressure_1=content(s.pressure_1, t.position, axis.oil_1).oil,
        pressure_2=content(s.pressure_2, t.position, axis.oil_2).oil,
        flow_1=flow_1,
        flow_2=flow_2,
    )
