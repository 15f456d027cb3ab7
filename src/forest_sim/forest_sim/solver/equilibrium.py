"""Where a simulation starts: every valve shut, nothing moving, gravity held by trapped oil."""

import math
from functools import lru_cache

from forest_description.geometry.linkage import lever_arm
from forest_description.types import Vec3
from forest_sim.equations.drive import DriveState
from forest_sim.equations.elastic_links import NO_ROOT, Roots, RootState
from forest_sim.equations.multibody import HANGING_STILL, HeadState, mechanics
from forest_sim.equations.plant import AxisState, PlantState
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.hydraulics.load_holding import Lifts, resting_lift
from forest_sim.hydraulics.pump_drive import UNDRIVEN, PumpState
from forest_sim.hydraulics.spool_dynamics import CENTRED
from forest_sim.hydraulics.supply import Supply, SupplyState, asked_stroke, flow_at, pump_torque
from forest_sim.mechanics.elasticity import ElasticLink
from forest_sim.mechanics.gear import Gear
from forest_sim.mechanics.pendulum import hanging_angles
from forest_sim.midpoint.midpoint_state import NO_MIDPOINT
from forest_sim.solver.integrator import Events, Simulation

PRELOAD = 0.1  # pressure in the less loaded chamber, as a share of the supply's


def equilibrium(angles: Vec3, p: PlantParameters) -> Simulation:
    """Return the machine at rest with its links at the angles [rad], valves shut.

    The trapped volumes leave one pressure per cylinder free: the less loaded chamber gets `PRELOAD`
    of the supply pressure. Joints stand above links that give way by what gravity bends them.
    The swing's hoses have leaked empty, and the tank line through them. On a tilted platform the hose
    under load has the weight's pressure, as in slow creep, and a gear with play bears on one flank; on
    level ground it stands in the middle of its play. Bristles are straight.
    From there the swing creeps unless its friction sticks, and so does every axis whose valve leaks or
    is underlapped.
    """
    angles = float(angles[0]), float(angles[1]), float(angles[2])  # compiled kernels know no whole numbers
    head = HeadState(*hanging_angles(angles[0], p.body), 0.0, 0.0) if p.head.mass > 0.0 else HANGING_STILL
    bias, supply = mechanics(angles, (0.0, 0.0, 0.0), head, p).bias, idle_supply(p.supply)
    swing = angles[0] + _give(bias[0], p.elastic.swing)
    boom = angles[1] + _give(bias[1], p.elastic.boom)
    stick = angles[2] + _give(bias[2], p.elastic.stick)
    return Simulation(
        PlantState(
            swing=_leaning(angles[0], bias[0], p.swing),
            boom=_hold(angles[1], bias[1] / lever_arm(boom, p.boom_linkage), p.boom, p),
            stick=_hold(angles[2], bias[2] / lever_arm(stick, p.stick_linkage), p.stick, p),
            supply=supply,
            head=head,
            drive=DriveState(_motor_angle(swing, bias[0], p.drive.gear), 0.0, 0.0),
            pump=idle_pump(supply, p.supply),
            roots=Roots(
                _root(swing, p.elastic.swing),
                _root(boom, p.elastic.boom),
                _root(stick, p.elastic.stick),
            ),
        ),
        (CENTRED, CENTRED, CENTRED),
        Events(0, 0, 0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0),
        midpoint=NO_MIDPOINT._replace(lifts=(_lifts(p.swing), _lifts(p.boom), _lifts(p.stick))),
    )


def _give(torque: float, link: ElasticLink) -> float:
    """Return by how much a joint stands before its link [rad] that bears a torque [N m]."""
    return torque / link.stiffness if link.inertia > 0.0 else 0.0


def _root(angle: float, link: ElasticLink) -> RootState:
    return RootState(angle, 0.0) if link.inertia > 0.0 else NO_ROOT


def _lifts(axis: Axis) -> Lifts:
    return Lifts(resting_lift(axis.holding_1), resting_lift(axis.holding_2))


@lru_cache(maxsize=64)  # runs of a study share their supply
def idle_supply(s: Supply) -> SupplyState:
    """Return the supply when nobody draws: the pressure at which the pumps deliver nothing."""
    reference = s.margin if s.rate > 0.0 else s.set_pressure
    if s.ideal:
        return SupplyState(reference, reference)
    low, high = 0.0, s.relief_pressure + s.flow_limit / s.relief_conductance
    for _ in range(80):
        middle = 0.5 * (low + high)
        here = SupplyState(middle, reference)
        if flow_at(here, idle_pump(here, s), s).delivered > 0.0:
            low = middle
        else:
            high = middle
    return SupplyState(0.5 * (low + high), reference)


def idle_pump(supply: SupplyState, s: Supply) -> PumpState:
    """Return swash plate and engine as they stand while the manifold stays as it is."""
    d = s.drive
    if d.present == 0:
        return UNDRIVEN
    stroke = asked_stroke(supply, s).value
    load = pump_torque(stroke, supply.pressure, s)
    return PumpState(stroke, d.speed - load / d.governor if d.inertia > 0.0 else d.speed)


def _leaning(angle: float, torque: float, axis: Axis) -> AxisState:
    """Return the swing at rest under a torque [N m] of its motor; the hose without load has leaked empty."""
    return AxisState(
        angle=angle,
        rate=0.0,
        pressure_1=max(0.0, torque) / axis.actuator.displacement_1,
        pressure_2=max(0.0, -torque) / axis.actuator.displacement_2,
        flow_1=0.0,
        flow_2=0.0,
    )


def _motor_angle(angle: float, torque: float, gear: Gear) -> float:
    """Return where the motor stands [rad] while its gear bears a torque [N m]; 0 without play."""
    if gear.inertia == 0.0:
        return 0.0
    if torque == 0.0:
        return angle
    return angle + math.copysign(gear.teeth.upper + abs(torque) / gear.teeth.stiffness, torque)


def _hold(angle: float, force: float, axis: Axis, p: PlantParameters) -> AxisState:
    """Return the axis at rest with A_1 P_1 - A_2 P_2 = force [N]."""
    a_1, a_2 = axis.actuator.displacement_1, axis.actuator.displacement_2
    preload = PRELOAD * p.supply.set_pressure
    if force + a_2 * preload >= a_1 * preload:
        return AxisState(
            angle=angle,
            rate=0.0,
            pressure_1=(force + a_2 * preload) / a_1,
            pressure_2=preload,
            flow_1=0.0,
            flow_2=0.0,
        )
    return AxisState(
        angle=angle,
        rate=0.0,
        pressure_1=preload,
        pressure_2=(a_1 * preload - force) / a_2,
        flow_1=0.0,
        flow_2=0.0,
    )
