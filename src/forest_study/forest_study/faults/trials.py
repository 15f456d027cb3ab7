"""Every fault in every state, seed by seed, and what is measured.

| time | what |
|---|---|
| 0 .. BEGUN | deadman held, levers centred |
| until the end | the operator drives; the fault begins at 1.2 to 1.7 s |
| 0.6 s after it has healed | the operator has gone on all the time: what stopped must stand |
| then | deadman released, levers centred, deadman pressed: the deliberate act; then driven again |
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_study.faults.fault import Fault, State
from forest_study.faults.faulty_loop import Wires
from forest_study.faults.scenes import BEGUN, scene

EARLIEST, SPREAD = 1.2, 0.5  # [s] of the fault's beginning
IN_EXPERIMENT = 1.3  # [s] later: the programme begins with a rest
GOES_ON = 0.6  # [s] of the operator after the fault has healed
LET_GO, PRESSED, AGAIN = 0.4, 0.2, 0.6  # [s] of the deliberate act, and of the driving after it
AFTER = 0.5  # [s] after zero voltage, in which the crane rocks on its oil
MOVED = 0.03  # [m] of the tip that are a motion, and not a crane that rocks or is held
STOPPED = 0.05  # [s] of shut valves at the end of the fault that count as a stop
NO_FAULT = Fault("nothing", "", {})


class Outcome(NamedTuple):
    """What a seed came to in a cell."""

    seed: int
    zero: float  # [s] from the fault to zero voltage that lasts; infinite: the valves never shut for good
    way: float  # [m] of the tip from the fault until `AFTER` that
    off: float  # [m] from the same run without the fault, until the fault heals
    speed: float  # [m/s] greatest of the tip since the fault
    told: str  # what the operator was told first, "" for nothing
    told_after: float  # [s] since the fault
    restarted: bool  # it stopped, and moved without a deliberate act
    again: bool  # it moved after one


class Course(NamedTuple):
    """A run, one row per period."""

    tips: Floats  # [N, 3] m
    volts: Floats  # [N, 3] V, as the driver gives them
    told: tuple[str, ...]
    begun: int  # row of the fault
    healed: int
    act: int  # row at which the deadman is released


def course(fault: Fault, state: State, seed: int, machine: Machine) -> Course:
    """Return a run of a fault in a state."""
    begins = EARLIEST + SPREAD * float(np.random.default_rng([seed, 8]).random())
    begins += IN_EXPERIMENT if state == State.EXPERIMENT else 0.0
    begun = 0 if fault.file else round(begins / PERIOD)
    healed, let_go = begun + round(fault.lasts / PERIOD), fault.let_go + begun * PERIOD
    act = healed + round(GOES_ON / PERIOD)
    pressed = act + round(LET_GO / PERIOD)
    driven = pressed + round(PRESSED / PERIOD)
    crane = scene(machine, state, Wires(fault, seed % 3, begun * PERIOD, seed), seed)
    tips, volts, told, links = [], [], [], machine.manipulator.links
    for k in range(driven + round(AGAIN / PERIOD)):
        if k == driven:
            crane.resume()
        held, goes = not act <= k < pressed, k * PERIOD >= BEGUN and not act <= k < driven
        held = held and not let_go <= k * PERIOD < pressed * PERIOD
        happened = crane.period(held, goes)
        tips.append(tip_position(happened.angles, links))
        volts.append(happened.voltages)
        told.append(crane.told())
    return Course(np.array(tips), np.array(volts), tuple(told), begun, healed, act)


@lru_cache(maxsize=256)
def _undisturbed(state: State, seed: int, machine: Machine) -> Course:
    return course(NO_FAULT, state, seed, machine)


def trial(fault: Fault, state: State, seed: int, machine: Machine) -> Outcome:
    """Return what a seed comes to in a cell."""
    run = course(fault, state, seed, machine)
    begun, healed = run.begun, run.healed
    open_rows = np.flatnonzero(run.volts.any(axis=1))
    meanwhile = open_rows[(open_rows >= begun) & (open_rows < healed)]
    last = int(meanwhile[-1]) + 1 if meanwhile.size else begun
    stops = healed - last >= STOPPED / PERIOD
    until = min(last + round(AFTER / PERIOD), run.act)
    way = np.linalg.norm(run.tips[begun:until] - run.tips[begun], axis=1)
    other = _undisturbed(state, seed, machine).tips
    reach = min(healed, len(other))
    off = np.linalg.norm(run.tips[begun:reach] - other[begun:reach], axis=1)
    speeds = np.linalg.norm(np.diff(run.tips[begun : run.act], axis=0), axis=1) / PERIOD
    heard = next((k for k in range(begun, run.act) if run.told[k]), None)
    gone = float(np.linalg.norm(run.tips[healed : run.act] - run.tips[healed], axis=1).max())
    late = open_rows[(open_rows >= healed) & (open_rows < run.act)]
    again = open_rows[open_rows >= run.act + (LET_GO + PRESSED) / PERIOD]
    return Outcome(
        seed=seed,
        zero=(last - begun) * PERIOD if stops else math.inf,
        way=float(way.max(initial=0.0)),
        off=float(off.max(initial=0.0)),
        speed=float(speeds.max(initial=0.0)),
        told="" if heard is None else run.told[heard],
        told_after=math.inf if heard is None else (heard - begun) * PERIOD,
        restarted=bool(stops and late.size and gone > MOVED),
        again=bool(again.size),
    )


def cell(fault: Fault, state: State, seeds: Sequence[int], machine: Machine) -> list[Outcome]:
    """Return what every seed comes to in a cell."""
    return [trial(fault, state, seed, machine) for seed in seeds]
