"""Natural frequencies and damping of the machine about a pose: eigenvalues of the linearised plant.

| symbol | name | unit |
|---|---|---|
| x | state: `plant.PlantState` and the compensators' openings, without what stands still | |
| A | df/dx by central differences about x_0, `plant.state_derivative`, (balance - opening)/tau | 1/s |
| lambda | eigenvalue, -zeta w_n + j w_n sqrt(1 - zeta^2) | 1/s |
| p | participation of a state in a mode, abs(left eigenvector times right one); sums to 1 | 1 |

Behind a shut valve a hose's flow is zero and stays so: it is no state. With the valves open x_0 is
the steady motion with the joints held at the pose: each of them moves through the pose rather than
resting in it.

Relief and anti-cavitation valves, end stops and cushions are left out: they are off in the middle
of the working range, but an emptied hose lies right at the edge of an anti-cavitation valve.

Dry friction is linearised like all else. At rest that is a strong damper, which holds for small
oscillations only; `friction_linearisation` tells for which, and gives the parameters for large
ones. A swing's bearing sticks at rest, and its gear stands in the middle of its play.

Load-holding valves, flow forces and the tank line's pressure stand as they are: the modes are those
of times shorter than their time constants, and of amplitudes within a poppet's hysteresis.

Where links give way, a root's angle is replaced by its deflection from the link: that is what the
spring's energy goes by, and its participation is the spring's share of the mode's energy.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import scipy

from forest_description.types import AXES, Floats, Vec3
from forest_sim.equations.drive import DriveState
from forest_sim.equations.elastic_links import Roots, RootState
from forest_sim.equations.multibody import HeadState
from forest_sim.equations.plant import AxisState, PlantState, state_derivative
from forest_sim.equations.plant_parameters import NO_GUARD, PlantParameters
from forest_sim.equations.valve_ports import Ports, ports_at
from forest_sim.hydraulics.command_history import held_commands
from forest_sim.hydraulics.compensator import NONE
from forest_sim.hydraulics.load_holding import is_held, restriction
from forest_sim.hydraulics.port import is_shut
from forest_sim.hydraulics.pump_drive import PumpState
from forest_sim.hydraulics.spool_dynamics import STUCK, Spool, Spools
from forest_sim.hydraulics.supply import SupplyState
from forest_sim.mechanics.end_stop import NO_STOP, UNCUSHIONED
from forest_sim.midpoint.compensator_step import openings_after
from forest_sim.solver.compiled_plant import ready_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.integrator import Simulation, advance, ports_of

DIFFERENCE = (1e-6, 1e-6, 10.0, 10.0, 1e-8, 1e-8)  # rad, rad/s, Pa, m^3/s: rounding and curvature both small
DRIVE_PARTS = ("motor", "motor", "links")  # of `DriveState`
PARTS = {"angle": "links", "rate": "links", "pressure_1": "oil", "pressure_2": "oil"}
SETTLING, SETTLING_STEP = 3.0, 5e-3  # [s] over which the steady motion at a pose is found
SHUT: Vec3 = (0.0, 0.0, 0.0)  # [V] of the spools
PUMP = 27  # place of the first one of swash plate and engine
ROOTS = 29  # place of the first root's angle
COMPENSATORS = 35  # place of the first compensator's opening
STATES = 38  # of `PlantState`, and three openings
SLOWEST = 1e-3  # [Hz] anything below is no oscillation but rounding


class Mode(NamedTuple):
    """One oscillation."""

    frequency: float  # w_n/2pi [Hz]
    damping: float  # zeta
    axes: Vec3  # participation of swing, boom, stick
    parts: dict[
        str, float
    ]  # of links, oil, hoses (flow), pump, head; of a motor in play, bending and roots, compensators

    @property
    def axis(self) -> str:
        """The axis that takes the greatest part."""
        return AXES[int(np.argmax(self.axes))]

    @property
    def kind(self) -> str:
        """What swings on what."""
        links, hoses, pump, head = (self.parts[name] for name in ("links", "hoses", "pump", "head"))
        if head > 0.5:
            return "hanging head"
        most = max(links, hoses, pump)
        if self.parts.get("motor", 0.0) > most:
            return "motor in gear"
        if self.parts.get("roots", 0.0) > most:
            return "roots in links"
        if self.parts.get("compensators", 0.0) > most:
            return "compensators"
        if links >= max(hoses, pump):
            return "links bending" if self.parts.get("bending", 0.0) > self.parts["oil"] else "links on oil"
        return "oil in hoses" if hoses >= pump else "oil and pump"


def unguarded(p: PlantParameters) -> PlantParameters:
    """Return the parameters without what works at the edges of the working range only."""
    drive = p.drive._replace(gear=p.drive.gear._replace(stop=NO_STOP))
    return p._replace(guard=NO_GUARD, drive=drive).with_axes(stop=NO_STOP, cushion=UNCUSHIONED)


def operating_point(angles: Vec3, spools: Vec3, p: PlantParameters) -> Simulation:
    """Return the machine at rest at a pose, or in the steady motion that open valves give it there.

    Args:
        angles: of the links [rad].
        spools: spool positions [V]; inside the overlap a valve is shut.
        p: the machine, `unguarded`.
    """
    rest = equilibrium(angles, p)
    one, two, three = (Spool(position, 0.0, position) for position in spools)
    held = rest._replace(spools=(one, two, three), history=held_commands(spools))
    valves = (
        p.valves[0]._replace(lag=STUCK),
        p.valves[1]._replace(lag=STUCK),
        p.valves[2]._replace(lag=STUCK),
    )
    if all(is_shut(a.port_1) and is_shut(a.port_2) for a in ports_at(held.spools, p)):
        return held
    still, move = p._replace(valves=valves), ready_advance() or advance
    for _ in range(round(SETTLING / SETTLING_STEP)):
        after = move(held, spools, SETTLING_STEP, 1, still)
        plant = _brought_back(after.plant, angles, p)
        held = held._replace(plant=plant, midpoint=after.midpoint._replace(jets=held.midpoint.jets))
    return held


def _brought_back(plant: PlantState, angles: Vec3, p: PlantParameters) -> PlantState:
    """Return a plant with its links at a pose [rad] again, bent and with teeth pressed as they were."""
    ways = tuple(angle - axis.angle for axis, angle in zip(plant.axes, angles, strict=True))
    swing, boom, stick = (axis._replace(angle=angle) for axis, angle in zip(plant.axes, angles, strict=True))
    roots = (
        root._replace(angle=root.angle + way) if link.inertia > 0.0 else root
        for root, link, way in zip(plant.roots, p.elastic.links, ways, strict=True)
    )
    drive = _turned(plant.drive, ways[0], p)
    return plant._replace(swing=swing, boom=boom, stick=stick, drive=drive, roots=Roots(*roots))


def _flows(
    point: Simulation, ports: tuple[Ports, Ports, Ports], axis: int, port: int, p: PlantParameters
) -> bool:
    """Tell whether the flow through hose 1 or 2 of an axis (port 0 or 1) is a state: nothing shuts it."""
    state, valves = point.plant.axes[axis], (p.axes[axis].holding_1, p.axes[axis].holding_2)
    flow = -state.flow_2 if port else state.flow_1
    held = restriction(point.midpoint.lifts[axis][port], valves[port])
    spool = ports[axis].port_2 if port else ports[axis].port_1
    return not is_shut(spool) and not is_held(flow, held)


def _turned(drive: DriveState, by: float, p: PlantParameters) -> DriveState:
    """Return the swing's drive with its motor turned as the joint is [rad]."""
    if p.drive.gear.inertia == 0.0:
        return drive
    return drive._replace(motor_angle=drive.motor_angle + by)


def linearise(point: Simulation, p: PlantParameters) -> tuple[Floats, tuple[int, ...]]:
    """Return A [n, n] about an operating point, and the places of its n states among `rates_at`'s."""
    ports = ports_of(point, p)
    kept = [i for i in range(18) if i % 6 < 4 or _flows(point, ports, i // 6, i % 6 - 4, p)]
    if not p.supply.ideal:
        kept += [18] if p.supply.rate == 0.0 else [18, 19]
    if p.head.mass > 0.0:
        kept += [20, 21, 22, 23]
    kept += [24, 25] if p.drive.gear.inertia > 0.0 else []
    kept += [26] if p.drive.bearing.stiffness > 0.0 else []
    kept += [PUMP] if p.supply.drive.up > 0.0 else []
    kept += [PUMP + 1] if p.supply.drive.inertia > 0.0 else []
    kept += [
        place for place in range(ROOTS, COMPENSATORS) if p.elastic.links[(place - ROOTS) // 2].inertia > 0.0
    ]
    kept += [COMPENSATORS + axis for axis in range(3) if _meters(ports[axis], axis, p)]
    x = np.array([*states(point.plant), *(lifts.compensator for lifts in point.midpoint.lifts)])
    columns = []
    for place in kept:
        d = _difference(place)
        up, down = (
            rates_at(x + sign * d * np.eye(STATES)[place], point.spools, point, p) for sign in (1, -1)
        )
        columns.append((up - down)[kept] / (2.0 * d))
    return np.column_stack(columns), tuple(kept)


def rates_at(x: Floats, spools: Spools, point: Simulation, p: PlantParameters) -> Floats:
    """Return the rates of change of the plant's 35 states and of the three compensators' openings.

    Args:
        x: those states.
        spools: where the spools are.
        point: the operating point, of what stands still.
        p: the machine.
    """
    plant, openings = _shaped(x), x[COMPENSATORS:].tolist()
    one, two, three = (
        lifts._replace(compensator=opening)
        for lifts, opening in zip(point.midpoint.lifts, openings, strict=True)
    )
    ports = ports_at(spools, p, (one, two, three), point.midpoint.tank.seen)
    balanced = openings_after(plant, (one, two, three), spools, spools, math.inf, p)
    moving = [
        (there.compensator - opening) / valve.compensator.response_time
        for there, opening, valve in zip(balanced, openings, p.valves, strict=True)
    ]
    return np.array([*states(state_derivative(plant, ports, p)), *moving])


def _meters(ports: Ports, axis: int, p: PlantParameters) -> bool:
    """Tell whether an axis has a compensator through which oil flows."""
    open_to_pump = min(ports.port_1.to_supply, ports.port_2.to_supply) < math.inf
    return p.valves[axis].compensator.sort != NONE and open_to_pump


def modes(angles: Vec3, spools: Vec3, p: PlantParameters) -> list[Mode]:
    """Return the oscillations at a pose, the slowest first.

    Args:
        angles: joint angles [rad].
        spools: spool positions [V], (0, 0, 0): shut.
        p: the machine; port valves, stops and cushions are left out.
    """
    p = unguarded(p)
    a, kept = linearise(operating_point(angles, spools, p), p)
    a = _by_deflections(a, kept)
    scale = np.array([_difference(place) for place in kept])
    values, left, right = scipy.linalg.eig(a * scale[np.newaxis, :] / scale[:, np.newaxis], left=True)
    found = [
        _mode(value, np.abs(left[:, k].conj() * right[:, k]), kept)
        for k, value in enumerate(values)
        if value.imag > 2.0 * math.pi * SLOWEST
    ]
    return sorted(found, key=lambda mode: mode.frequency)


def _by_deflections(a: Floats, kept: tuple[int, ...]) -> Floats:
    """Return A with the deflections of elastic links in place of their roots' angles."""
    turn = np.eye(len(kept))
    for row, place in enumerate(kept):
        if ROOTS <= place < COMPENSATORS and (place - ROOTS) % 2 == 0:
            turn[row, kept.index(3 * (place - ROOTS))] = -1.0
    found: Floats = turn @ a @ (2.0 * np.eye(len(kept)) - turn)  # whose product with turn is 1
    return found


def _mode(value: complex, weights: Floats, kept: tuple[int, ...]) -> Mode:
    weights = weights / np.sum(weights)
    axes = [0.0, 0.0, 0.0]
    parts = dict.fromkeys(("links", "oil", "hoses", "pump", "head"), 0.0)
    parts |= {"motor": 0.0} if 24 in kept else {}
    parts |= {"bending": 0.0, "roots": 0.0} if any(ROOTS <= place < COMPENSATORS for place in kept) else {}
    parts |= {"compensators": 0.0} if kept[-1] >= COMPENSATORS else {}
    for place, weight in zip(kept, weights.tolist(), strict=True):
        if place < 18:
            axes[place // 6] += weight
            parts[PARTS.get(AxisState._fields[place % 6], "hoses")] += weight
        elif place < 20 or PUMP <= place < ROOTS:
            parts["pump"] += weight
        elif place < 24:
            parts["head"] += weight
        elif place >= COMPENSATORS:
            axes[place - COMPENSATORS] += weight
            parts["compensators"] += weight
        elif place >= ROOTS:
            axes[(place - ROOTS) // 2] += weight
            parts["roots" if (place - ROOTS) % 2 else "bending"] += weight
        else:
            axes[0] += weight
            parts[DRIVE_PARTS[place - 24]] += weight
    natural = abs(value)
    return Mode(natural / (2.0 * math.pi), -value.real / natural, (axes[0], axes[1], axes[2]), parts)


def slow_modes(found: list[Mode]) -> dict[str, Mode | None]:
    """Return the slowest oscillation of the links for each axis; None where an axis has none.

    Boom and stick move together in two modes: each gets the one in which it takes the greater part.
    """
    candidates = [mode for mode in found if mode.kind in ("links on oil", "links bending")][:3]
    swing = next((mode for mode in candidates if mode.axis == "swing"), None)
    pair = [mode for mode in candidates if mode.axis != "swing"]
    if len(pair) == 2 and pair[0].axes[1] + pair[1].axes[2] < pair[1].axes[1] + pair[0].axes[2]:
        pair.reverse()
    named: dict[str, Mode | None] = {"swing": swing, "boom": None, "stick": None}
    if len(pair) == 2:
        named["boom"], named["stick"] = pair
    elif pair:
        named[pair[0].axis] = pair[0]
    return named


def _difference(place: int) -> float:
    if place < 18:
        return DIFFERENCE[place % 6]
    return DIFFERENCE[2] if place < 20 else DIFFERENCE[0]


def states(state: PlantState) -> Floats:
    """Return the plant's 35 states, or their rates of change, as `state_recording.STATE` has them."""
    axes = *state.swing, *state.boom, *state.stick
    roots = (x for root in state.roots for x in root)
    return np.array([*axes, *state.supply, *state.head, *state.drive, *state.pump, *roots])


def _shaped(x: Floats) -> PlantState:
    v = x.tolist()
    axes = AxisState(*v[0:6]), AxisState(*v[6:12]), AxisState(*v[12:18])
    roots = Roots(*(RootState(*v[k : k + 2]) for k in range(ROOTS, COMPENSATORS, 2)))
    head, drive, pump = HeadState(*v[20:24]), DriveState(*v[24:PUMP]), PumpState(*v[PUMP:ROOTS])
    return PlantState(*axes, SupplyState(*v[18:20]), head, drive, pump, roots)


def as_json(found: list[Mode]) -> list[dict[str, Any]]:
    """Return the modes for JSON."""
    return [
        {
            "frequency_hz": mode.frequency,
            "damping_ratio": mode.damping,
            "kind": mode.kind,
            "participation": {**dict(zip(AXES, mode.axes, strict=True)), **mode.parts},
        }
        for mode in found
    ]


def table(found: list[Mode]) -> str:
    """Return the modes in a table."""
    if not found:
        return "  no oscillations: everything is overdamped"
    lines = [f"  {'Hz':>8} {'damping':>8}  {'axis':<6} {'kind':<13} participation"]
    for mode in found:
        shares = {**dict(zip(AXES, mode.axes, strict=True)), **mode.parts}
        participation = ", ".join(
            f"{name} {100 * share:.0f} %" for name, share in shares.items() if share >= 0.05
        )
        axis = mode.axis if max(mode.axes) > mode.parts["pump"] + mode.parts["head"] else "-"
        lines.append(
            f"  {mode.frequency:8.2f} {mode.damping:8.3f}  {axis:<6} {mode.kind:<13} {participation}"
        )
    return "\n".join(lines)
