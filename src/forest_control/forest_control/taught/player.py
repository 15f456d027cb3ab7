"""The player: leads the tip through the steps of a cycle, one piece of path after the other.

| phase | what is going on | what ends it |
|---|---|---|
| IDLE | nothing is played | a person plays a cycle |
| WAITING | until the deadman is held and the sticks are centred | that; or `PATIENCE` |
| RUNNING | the tip is led along a leg | its end; a stick, the deadman, a pause, a tip that does not follow |
| HOLDING | a step of the grapple, while the tip stands | a person's confirmation, or its time |
| PAUSED | broken off | a person resumes |
| FINISHED | all steps are done | a person plays a cycle |
| RECORDING | a path is taught; `taught_work` tells so, no state here has it | a person ends it |

While HOLDING and PAUSED the levers move the tip as ever. From where they left it the tip goes back on a
straight line, slowly, to where it was on its leg; that line is tried as every leg is.

| symbol | name | unit |
|---|---|---|
| s | way along the leg: where the path is beside the measured tip | m |
| v | speed along it: what the leg allows, with a ramp from rest | m/s |
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.operator.taught_command import NO_COMMAND, SHARPEST, TaughtCommand
from forest_control.taught.plan import RAMP, STEP, THERE, Hold, Leg, Step, leg
from forest_control.taught.tip_path import PathError
from forest_description.types import Vec3

PATIENCE = 10.0  # [s] WAITING: a deadman that is pressed much later must not start what was forgotten
NEAR = 0.01  # [m] from a stop: above the resolvers' noise, and what a machine's errors leave
SETTLED = 1.5  # [s] near a stop, after which the tip has arrived: the crane has rocked; chosen
STUCK = 3.0  # [s] without getting on by `PROGRESS`: something holds the tip
PROGRESS = 0.005  # [m] along the leg that shows that the tip follows
FARTHEST = 0.09  # [m] of the tip from its path: just before the controller refuses
GAP = 0.1  # [s] between two steps, at which the controller has taken the command for lost
BRAKE = 1.0  # [m/s^2] of a pause, along the path: so that the crane does not rock; chosen
BACK = 0.15  # [m/s] of the way back to a leg; chosen, not measured
LEAST = 0.02  # [m/s] of a command: it begins from rest, and ends by the way left
BASE = 0.02  # [m] on either side, over which direction and curvature are measured: over waypoints' noise


class Phase(IntEnum):
    """What the player is about; `cycle/status` carries the number."""

    IDLE = 0
    WAITING = 1
    RUNNING = 2
    HOLDING = 3
    PAUSED = 4
    FINISHED = 5
    RECORDING = 6


class Place(NamedTuple):
    """Where the tip is on a leg."""

    leg: Leg
    way: float = 0.0  # s [m]
    stop: int = 1  # index of the path's next stop

    @property
    def left(self) -> float:
        """Way to the next stop [m]."""
        return self.leg.path.stops[self.stop] - self.way


class State(NamedTuple):
    """What the player remembers between steps."""

    phase: Phase = Phase.IDLE
    steps: tuple[Step, ...] = ()
    at: int = 0  # index of the step
    place: Place | None = None  # on the step, if it is a leg
    back: Place | None = None  # on the way back to it
    speed: float = 0.0  # v [m/s]
    run: float = 0.0  # number of the run
    elapsed: float = 0.0  # [s] in this phase
    near: float = 0.0  # [s] near a stop
    stuck: float = 0.0  # [s] without progress
    reached: float = -math.inf  # [m] where it last showed progress
    pausing: bool = False  # the tip slows down
    cause: str = ""  # of PAUSED, in words


class Inputs(NamedTuple):
    """What a step sees."""

    tip: Vec3  # [m] measured
    time: float  # [s] rising: the number of the next run
    armed: bool  # the controller lets the levers move the crane
    centred: bool  # no stick is deflected
    go: bool = False  # a person resumes, or confirms
    pause: bool = False  # a person, or a program, pauses


class Output(NamedTuple):
    """What a step says."""

    command: TaughtCommand | None = None
    event: str = ""


def started(steps: tuple[Step, ...]) -> tuple[State, str]:
    """Return the state of a cycle that is to be played from its beginning, and the event."""
    return _entered(State(steps=steps), 0)


def step(state: State, inputs: Inputs, p: Parameters, dt: float) -> tuple[State, Output]:
    """Return the state dt [s] later, and what is said.

    Args:
        state: before.
        inputs: what is seen.
        p: the controller's parameters, by which a way back is tried.
        dt: since the last step [s].
    """
    state = state._replace(elapsed=state.elapsed + dt)
    if state.phase == Phase.WAITING:
        return _wait(state, inputs, p)
    if state.phase == Phase.RUNNING:
        return _run(state, inputs, dt)
    if state.phase == Phase.HOLDING:
        return _hold(state, inputs)
    if state.phase == Phase.PAUSED and inputs.go:
        return _resumed(state), Output()
    return state, Output()


def _resumed(state: State) -> State:
    return state._replace(phase=Phase.WAITING, elapsed=0.0, back=None, cause="")


def _paused(state: State, cause: str) -> tuple[State, Output]:
    """Return the state that a person must end, and the end of the run."""
    command = NO_COMMAND if state.phase == Phase.RUNNING else None
    paused = state._replace(phase=Phase.PAUSED, cause=cause, elapsed=0.0, pausing=False)
    return paused, Output(command, f"paused: {cause}")


def _entered(state: State, at: int) -> tuple[State, str]:
    """Return the state at the beginning of a step, and the event that tells it."""
    fresh = State(steps=state.steps, at=at, run=state.run)
    if at == len(state.steps):
        return fresh._replace(phase=Phase.FINISHED), "finished"
    entered = state.steps[at]
    if isinstance(entered, Hold):
        return fresh._replace(phase=Phase.HOLDING), entered.text
    phase = Phase.RUNNING if state.phase == Phase.RUNNING else Phase.WAITING
    told = at > 0 and state.steps[at - 1].number == entered.number  # its leg to its start
    return fresh._replace(phase=phase, place=Place(entered)), "" if told else f"segment {entered.name}"


def _wait(state: State, inputs: Inputs, p: Parameters) -> tuple[State, Output]:
    if inputs.pause:
        return _paused(state, "asked for")
    if state.elapsed > PATIENCE:
        return _paused(state, f"nobody held the deadman with centred sticks within {PATIENCE:g} s")
    if not (inputs.armed and inputs.centred):
        return state, Output()
    assert state.place is not None
    target, back = state.place.leg.path.at(state.place.way), None
    if math.dist(inputs.tip, target) > THERE:
        one = state.place.leg
        try:
            back = Place(leg(one.number, f"way back to {one.name}", [inputs.tip, target], BACK, p))
        except PathError as error:
            return _paused(state, str(error))
    begun = State(steps=state.steps, at=state.at, place=state.place, back=back)
    return begun._replace(phase=Phase.RUNNING, run=inputs.time), Output()


def _run(state: State, inputs: Inputs, dt: float) -> tuple[State, Output]:
    if trouble := _interrupted(inputs, dt):
        return _paused(state, trouble)
    place = state.back or state.place
    assert place is not None
    place = _followed(place, inputs.tip)
    if math.dist(place.leg.path.at(place.way), inputs.tip) > FARTHEST:
        return _paused(state, "the tip is too far from the path")
    state = _watched(state, place, dt)
    if state.stuck > STUCK:
        return _paused(state, "the tip does not get on: a limit, the joint scheme, or a fault")
    if state.near > SETTLED:
        return _arrived(state, place)
    pausing = state.pausing or inputs.pause
    if pausing and state.speed <= LEAST:
        return _paused(_at(state, place), "asked for")
    allowed = place.leg.speed_at(_from_stop(place))
    speed = min(allowed, state.speed - BRAKE * dt if pausing else state.speed + RAMP * dt)
    state = _at(state, place)._replace(speed=max(LEAST, speed), pausing=pausing)
    return state, Output(piece(place, state.speed))


def _interrupted(inputs: Inputs, dt: float) -> str:
    """Return why the run must end, or ""."""
    if not inputs.armed:
        return "the deadman was released, or the crane was stopped"
    if not inputs.centred:
        return "a stick moved"
    return f"the player was held up for {dt:.2g} s" if dt > GAP else ""


def _hold(state: State, inputs: Inputs) -> tuple[State, Output]:
    hold = state.steps[state.at]
    assert isinstance(hold, Hold)
    wait = hold.grapple.wait
    if not (inputs.go or (wait > 0.0 and state.elapsed >= wait)):
        return state, Output()
    state, event = _entered(state, state.at + 1)
    return state, Output(event=event)


def _followed(place: Place, tip: Vec3) -> Place:
    """Return where the path is beside the tip, between the stop before and the next one.

    One of Newton's steps a period is enough: the tip goes on by millimetres.
    """
    stops, at = place.leg.path.stops, place.leg.path.at(place.way)
    t = _shape(place).tangent
    ahead = (tip[0] - at[0]) * t[0] + (tip[1] - at[1]) * t[1] + (tip[2] - at[2]) * t[2]
    return place._replace(way=max(stops[place.stop - 1], min(stops[place.stop], place.way + ahead)))


def _watched(state: State, place: Place, dt: float) -> State:
    """Return the state with the times that tell of an arrival, or of no progress."""
    near = state.near + dt if place.left <= NEAR else 0.0
    if place.way > state.reached + PROGRESS or place.left <= NEAR:
        return state._replace(near=near, stuck=0.0, reached=place.way)
    return state._replace(near=near, stuck=state.stuck + dt)


def _at(state: State, place: Place) -> State:
    return state._replace(back=place) if state.back else state._replace(place=place)


def _arrived(state: State, place: Place) -> tuple[State, Output]:
    """Return the state at a stop: another stretch of the leg, the leg after a way back, or the next step."""
    state = state._replace(speed=0.0, near=0.0, stuck=0.0, reached=-math.inf)
    stops = place.leg.path.stops
    if place.stop + 1 < len(stops):
        place = place._replace(way=stops[place.stop], stop=place.stop + 1)
        return _at(state, place), Output(piece(place, LEAST))
    if state.back:
        assert state.place is not None
        return state._replace(back=None), Output(piece(state.place, LEAST))
    after, event = _entered(state, state.at + 1)
    if after.phase == Phase.RUNNING:
        assert after.place is not None
        return after, Output(piece(after.place, LEAST), event)
    return after, Output(NO_COMMAND, event)


def _from_stop(place: Place) -> float:
    """Return the way [m] at which the leg's speed is asked for: at the stop that is left it is zero."""
    start, end = place.leg.path.stops[place.stop - 1], place.leg.path.stops[place.stop]
    return max(place.way, start + min(STEP, 0.5 * (end - start)))


def piece(place: Place, speed: float) -> TaughtCommand:
    """Return the piece of path near a place, to be gone along at a speed [m/s]."""
    shape = _shape(place)
    left = place.leg.path.stops[place.stop] - shape.way
    return TaughtCommand(shape.place, shape.tangent, shape.curvature, speed, left)


class _Shape(NamedTuple):
    """What a path is like near a place: measured at least a `BASE` from its stops, where there is room."""

    way: float  # [m] where
    place: Vec3  # [m]
    tangent: Vec3
    curvature: Vec3  # [1/m]


def _shape(place: Place) -> _Shape:
    path, start, end = place.leg.path, place.leg.path.stops[place.stop - 1], place.leg.path.stops[place.stop]
    h = min(BASE, 0.5 * (end - start))
    middle = max(start + h, min(end - h, place.way))
    a, b, c = path.at(middle - h), path.at(middle), path.at(middle + h)
    size = math.dist(a, c)
    tangent = (c[0] - a[0]) / size, (c[1] - a[1]) / size, (c[2] - a[2]) / size
    bow = a[0] + c[0] - 2.0 * b[0], a[1] + c[1] - 2.0 * b[1], a[2] + c[2] - 2.0 * b[2]
    scale = 1.0 / max(h * h, 1.001 * math.hypot(*bow) / SHARPEST)
    return _Shape(middle, b, tangent, (scale * bow[0], scale * bow[1], scale * bow[2]))
