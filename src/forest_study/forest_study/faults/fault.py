"""What a fault, a state of the crane and a bound are.

A fault begins at a moment, lasts for two seconds or less, and heals, but for what is broken for good.
Meanwhile and after, the operator goes on as before: the crane must not move again before a deliberate act.
That act comes at the end: deadman released, levers centred, deadman pressed.
"""

import math
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple

from forest_control.operator.joystick_watch import Sample
from forest_control.valve.command_gate import Command
from forest_description.types import Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.signal_processing import Measurement
from forest_sim.solver.integrator import Simulation

LASTS = 2.0  # [s] of a fault that heals


class State(Enum):
    """What the crane is about."""

    STANDING = "standing"
    MOTION = "motion"
    LIMIT = "at a limit"
    POSITION = "position mode"
    TAUGHT = "taught cycle"
    EXPERIMENT = "experiment"


MOVING = State.MOTION, State.LIMIT, State.POSITION
DRIVEN = *MOVING, State.TAUGHT
HELD = State.STANDING, *DRIVEN
ALL = tuple(State)


class Moment(NamedTuple):
    """When a fault acts."""

    since: float  # [s] it began
    axis: int  # that is hit: 0 swing, 1 boom, 2 stick
    first: Any  # what passed last before it began
    chance: float  # of this period, 0 .. 1


class Bound(NamedTuple):
    """What must happen; None: nothing is asked."""

    zero: float | None = None  # [s] until the valves get zero voltage, and keep it
    way: float | None = None  # [m] of the tip, from the fault's beginning until half a second after zero
    off: float | None = None  # [m] from where the tip would be without the fault
    speed: float | None = None  # [m/s] of the tip, at most
    told: str | tuple[str, ...] = ""  # how the sentence begins that the operator is told; "": none is asked
    told_within: float = math.inf  # [s]
    again: bool = True  # after a deliberate act the healed crane moves
    held: bool = False  # healed, the tip is held again, and led back, though nobody has acted: a gap


def passed(_moment: Moment, what: Any) -> Any:
    """Return what passes a wire that is well."""
    return what


class Fault(NamedTuple):
    """What is done, to which wire, in which states, and what must happen."""

    text: str
    reason: str  # of the bound
    bounds: dict[State, Bound]
    joystick: Callable[[Moment, Sample], Sequence[Sample]] | None = None
    sensors: str = ""  # a fault of `sensor_faults`; {axis} stands for the axis that is hit
    seen: Callable[[Moment, Measurement], Measurement] = passed
    stamp: Callable[[Moment, int], int] = passed  # of the machine's state [ns]
    state_lost: Callable[[Moment], bool] = lambda _moment: False
    command: Callable[[Moment, Command], Command | None] = passed  # at the driver; None: lost
    volts: Callable[[Moment, Vec3], Vec3] = passed  # that the spools follow
    breaks: Callable[[Simulation, PlantParameters], tuple[Simulation, PlantParameters]] | None = None
    restarts: bool = False  # the controller is started anew
    file: str = ""  # machine file that controller and driver believe, from the start
    lasts: float = LASTS  # [s]
    let_go: float = math.inf  # [s] after which the operator releases the deadman
    for_good: bool = False  # it does not heal


def same(bound: Bound, states: Sequence[State], **others: Bound) -> dict[State, Bound]:
    """Return one bound for several states, and others by the states' names."""
    return {state: others.get(state.name, bound) for state in states}
