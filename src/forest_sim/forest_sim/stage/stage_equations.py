"""The equations of an implicit stage at an iterate, and their derivatives: what Newton's step is made of.

`implicit_stage` iterates. The axes are solved for the iterate's rates and supply pressure; gear play and
elastic links stand between them and the joints.
"""

from typing import NamedTuple

from forest_description.types import Vec3
from forest_sim.equations.multibody import HeadState, Inertia, mechanics, resisted, times
from forest_sim.equations.plant import PlantState, transmissions
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.equations.valve_ports import Ports
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.mechanics.friction import pressed
from forest_sim.mechanics.manipulator import Pair
from forest_sim.stage.axis_stage import AxisSolution, solve_axis
from forest_sim.stage.drive_stage import DriveSolution, solve_drive, through_gear
from forest_sim.stage.elastic_stage import (
    ALL_STIFF,
    ElasticSolution,
    Rub,
    root_angles,
    solve_links,
    through_links,
)
from forest_sim.stage.supply_stage import SupplyError, supply_error

RIGID, ELASTIC = 0, 1  # literally, so that the machine code of rigid links has nothing of others
NO_FEEDS = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))
NO_DRIVE = DriveSolution(torque=0.0, resistance=0.0, share=0.0, excess=0.0, give=0.0)
UNLOADED = SupplyError(
    residual=0.0,
    slope=1.0,
    by_rate=(0.0, 0.0, 0.0),
    on_rates=(0.0, 0.0, 0.0),
    feeds=NO_FEEDS,
    state=SupplyState(0.0, 0.0),
)
"""Of an ideal supply."""


class Iterate(NamedTuple):
    """What Newton looks for: the rates and the supply's pressure at a stage's end."""

    rates: Vec3  # of the joints [rad/s]
    head_rates: Pair  # of the hanging head [rad/s]
    supply: SupplyState
    motor_rate: float  # of the swing's motor, seen at its joint [rad/s]: without play, the joint's
    root_rates: Vec3  # of the links' roots [rad/s]: of rigid links, the joints'


class StageEquations(NamedTuple):
    """A stage's equations at an iterate."""

    swing: AxisSolution
    boom: AxisSolution
    stick: AxisSolution
    matrix: Inertia
    residual: Vec3  # of the joints [N m s]
    head_residual: Pair
    supply: SupplyError
    motor_gain: float  # h d(the swing's draw)/d(its motor's rate) [m^3 s]
    drive: DriveSolution


def equations_at(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
    bends: int,
) -> tuple[StageEquations, ElasticSolution]:
    """Return M (rates - base) + h (bias - torque) = 0 and the supply's equation at an iterate."""
    u, w, supply = iterate.rates, iterate.root_rates, iterate.supply.pressure
    angles = base.swing.angle + h * u[0], base.boom.angle + h * u[1], base.stick.angle + h * u[2]
    joints = root_angles(base, w, h, p) if bends else angles
    t_1, t_2, t_3 = transmissions(joints[0], joints[1], joints[2], p)
    swing = solve_axis(base.swing, near.swing, iterate.motor_rate, t_1, ports[0], supply, p.swing, p.guard, h)
    boom = solve_axis(base.boom, near.boom, w[1], t_2, ports[1], supply, p.boom, p.guard, h)
    stick = solve_axis(base.stick, near.stick, w[2], t_3, ports[2], supply, p.stick, p.guard, h)
    head_rates = iterate.head_rates
    m = mechanics(angles, u, head_at(base.head, head_rates, h), p)
    gained, head_gained = times(
        m.inertia,
        (u[0] - base.swing.rate, u[1] - base.boom.rate, u[2] - base.stick.rate),
        (head_rates[0] - base.head.alpha_rate, head_rates[1] - base.head.beta_rate),
    )
    arms = t_1.arm, t_2.arm, t_3.arm
    train = _drive_train(base, iterate, (swing, boom, stick), ports, arms, joints[0], h, p, bends)
    equations = StageEquations(
        swing=swing,
        boom=boom,
        stick=stick,
        matrix=resisted(m.inertia, train.resistances, p.head.damping, h),
        residual=(
            gained[0] + h * (m.bias[0] - train.torques[0]),
            gained[1] + h * (m.bias[1] - train.torques[1]),
            gained[2] + h * (m.bias[2] - train.torques[2]),
        ),
        head_residual=(head_gained[0] + h * m.head_bias[0], head_gained[1] + h * m.head_bias[1]),
        supply=train.supply,
        motor_gain=train.motor_gain,
        drive=train.drive,
    )
    return equations, train.links


class DriveTrain(NamedTuple):
    """What gear play and elastic links let through from the actuators to the links."""

    torques: Vec3  # on the joints [N m]
    resistances: Vec3  # -d(torques)/d(rates) [N m s]
    supply: SupplyError
    motor_gain: float  # as of `StageEquations`
    drive: DriveSolution
    links: ElasticSolution


def _drive_train(
    base: PlantState,
    iterate: Iterate,
    axes: tuple[AxisSolution, AxisSolution, AxisSolution],
    ports: tuple[Ports, Ports, Ports],
    arms: Vec3,
    swing_angle: float,
    h: float,
    p: PlantParameters,
    bends: int,
) -> DriveTrain:
    """Return what reaches the joints of solved axes."""
    swing, boom, stick = axes
    w, error = iterate.root_rates, UNLOADED._replace(state=iterate.supply)
    if not p.supply.ideal:
        error = supply_error(base.supply, base.pump, iterate.supply.pressure, axes, ports, arms, h, p)
    torques = swing.torque, boom.torque, stick.torque
    resistances = swing.resistance, boom.resistance, stick.resistance
    drive, motor_gain, links = NO_DRIVE, 0.0, ALL_STIFF
    if p.drive.present:
        turned = iterate.motor_rate
        drive = solve_drive(base.drive, swing_angle, w[0], turned, torques[0], resistances[0], h, p.drive)
        torques = drive.torque, boom.torque, stick.torque
        resistances = drive.resistance, boom.resistance, stick.resistance
        motor_gain = error.on_rates[0]
        error = through_gear(error, drive)
    if bends:
        rubs = _rub(boom, arms[1], p.boom), _rub(stick, arms[2], p.stick)
        links = solve_links(base, iterate.rates, w, torques, resistances, rubs, error.on_rates, h, p.elastic)
        torques = links.swing.torque, links.boom.torque, links.stick.torque
        resistances = links.swing.resistance, links.boom.resistance, links.stick.resistance
        error = through_links(error, links)
    return DriveTrain(torques, resistances, error, motor_gain, drive, links)


def _rub(axis: AxisSolution, arm: float, constants: Axis) -> Rub:
    """Return the dry friction of a solved axis."""
    friction, here = pressed(constants.friction, axis.one.pressure, axis.two.pressure), axis.friction
    return Rub(friction, arm, torque=arm * here.force, resistance=arm * arm * here.slope)


def equations_again(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
    bends: int,
) -> tuple[StageEquations, ElasticSolution]:
    """Return what `equations_at` does; not inlined: few iterations come this far."""
    if bends:
        return _equations_at_elastic(base, near, iterate, ports, h, p)
    return _equations_at_again(base, near, iterate, ports, h, p), ALL_STIFF


def _equations_at_again(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> StageEquations:
    """Return what `equations_at` does of rigid links; not inlined."""
    return equations_at(base, near, iterate, ports, h, p, RIGID)[0]


def _equations_at_elastic(
    base: PlantState,
    near: PlantState,
    iterate: Iterate,
    ports: tuple[Ports, Ports, Ports],
    h: float,
    p: PlantParameters,
) -> tuple[StageEquations, ElasticSolution]:
    """Return what `equations_at` does of links that give way; not inlined."""
    return equations_at(base, near, iterate, ports, h, p, ELASTIC)


def head_at(base: HeadState, rates: Pair, h: float) -> HeadState:
    """Return the hanging head h [s] on, at these rates [rad/s]."""
    return HeadState(base.alpha + h * rates[0], base.beta + h * rates[1], rates[0], rates[1])
