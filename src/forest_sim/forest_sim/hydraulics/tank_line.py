"""The line from the valves to the tank: what it passes, and how its pressure follows the return flow.

| symbol | name | unit |
|---|---|---|
| P_t | pressure before filter and preload valve | Pa |
| Q | oil that valves return, less what anti-cavitation valves take | m^3/s |
| P_0 | preload | Pa |
| R | resistance of filter and line | Pa s^2/m^6 |
| C | capacitance of the oil before them | m^3/Pa |

    C dP_t/dt = Q - q(P_t),    steady P_t = P_0 + R Q^2

Up to P_0 nothing passes. What anti-cavitation valves take beyond that comes from the tank through
an ideal suction check: P_t is never below zero. Drains of pumps and motors and the main relief
valve have lines of their own.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.tank_line_parameters import TankLine


class ReturnLine(NamedTuple):
    """Constants of the law; a capacitance of 0: there is no line, and P_t is zero."""

    preload: float  # P_0 [Pa]
    resistance: float  # R [Pa s^2/m^6]
    capacitance: float  # C [m^3/Pa]


class TankState(NamedTuple):
    """The tank line between two steps."""

    pressure: float  # P_t [Pa]
    seen: float  # P_t at the end of the last stage, with which its flows were found [Pa]
    owed: float = 0.0  # what more than it held has been taken, as a pressure [Pa], 0 or less


NO_LINE = ReturnLine(0.0, 0.0, 0.0)
DRAINED = TankState(0.0, 0.0)


def return_line(line: TankLine | None) -> ReturnLine:
    """Return the kernel's constants of a tank line."""
    return NO_LINE if line is None else ReturnLine(line.preload, line.resistance, line.capacitance)


def line_flow(pressure: float, line: ReturnLine) -> float:
    """Return q [m^3/s] that goes on to the tank at P_t [Pa]."""
    return math.sqrt((pressure - line.preload) / line.resistance) if pressure > line.preload else 0.0


def pressure_at_stage(base: TankState, flow: float, yielding: float, h: float, line: ReturnLine) -> float:
    """Return P_t [Pa] at a stage's end, implicitly: C (P_t - base) = h (Q - q(P_t)).

    Args:
        base: the stage's known part of the line.
        flow: Q if P_t stayed so [m^3/s].
        yielding: -dQ/dP_t [m^3/(s Pa)], of port valves that are open.
        h: the stage's implicit step [s].
        line: the line.
    """
    stiffness = line.capacitance / h
    admittance = stiffness + yielding
    shut = base.pressure + (flow + stiffness * base.owed) / admittance
    if shut <= line.preload:
        return max(0.0, shut)
    beyond = admittance * (shut - line.preload)
    q = 2.0 * beyond / (1.0 + math.sqrt(1.0 + 4.0 * admittance * line.resistance * beyond))
    return line.preload + line.resistance * q * q


def pressure_after(state: TankState, returned: float, step: float, line: ReturnLine) -> TankState:
    """Return the tank line after a stage's share of a step.

    Port valves may take more than was foreseen and the line had. It is owed: a suction check that gave
    it would make oil, and the line would jump from step to step. An open one gives what is missing.

    Args:
        state: P_t before it, and at the stage's end.
        returned: what the valves return at the stage's end [m^3/s].
        step: that share [s].
        line: the line.
    """
    passed = line_flow(state.seen, line)
    after = state.pressure + state.owed + step / line.capacitance * (returned - passed)
    owed = min(0.0, after) if state.seen > 0.0 else 0.0
    return TankState(max(0.0, after), state.seen, owed)
