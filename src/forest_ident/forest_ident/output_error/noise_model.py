"""Noise, static errors and censoring of each channel, from the machine file.

Exact sensors (a simulator's) get a noise near the rounding errors, so that the fit goes on to the end.
"""

import math

import numpy as np

from forest_description.machine import Machine
from forest_description.sensors.sensor_kinds import FlowMeter, LinearTransducer, Resolver
from forest_ident.measurements.session import Session
from forest_ident.output_error.fit_problem import Channel
from forest_ident.output_error.prediction import rest
from forest_sim.sensors.sensor_suite import KINDS

TINY = {"rad": 1e-6, "m": 1e-6, "Pa": 100.0, "m3/s": 1e-9, "K": 1e-3, "rad/s": 1e-3, "V": 1e-6}
KIND = {channel: kind for kind in KINDS for channel in kind.channels}


def channel(machine: Machine, session: Session, name: str) -> Channel:
    """Return the sensor errors of a session's channel. Thesis table 4.2.

    Args:
        machine: whose sensors the file describes.
        session: its metadata say whether sensors are exact.
        name: of the channel.
    """
    kind = KIND[name]
    tiny = Channel(name, TINY[kind.unit])
    part = getattr(machine.sensors, kind.name)
    if session.is_exact or part is None:
        return tiny
    step = _step(part) / math.sqrt(12.0)  # uniform within a step of the reading
    noise = max(math.hypot(part.noise or 0.0, step), tiny.noise)
    accuracy = (getattr(part, "accuracy", 0.0) or 0.0) / math.sqrt(3.0)  # uniform within the bound
    if isinstance(part, FlowMeter):
        return Channel(name, noise, gain=accuracy, floor=part.lowest, high=part.highest)
    if isinstance(part, LinearTransducer):
        return Channel(name, noise, offset=step)
    made = Channel(name, noise, offset=accuracy)
    if kind.name == "pressure":
        made = made._replace(offset=accuracy * part.full_scale, zero=True, high=part.full_scale)
    elif kind.name == "case_drain":
        made = made._replace(offset=0.0, gain=accuracy)
    elif kind.name == "resolver":
        # The simulation starts from the mean reading: the static error cancels, noise and step remain.
        made = made._replace(offset=start_noise(machine, session, name), run=session.name)
    return made


def start_noise(machine: Machine, session: Session, name: str) -> float:
    """Return the standard deviation [rad] of the angle that a session's simulation starts with."""
    part = machine.sensors.resolver
    if part is None or session.is_exact:
        return 0.0
    rows = rest(session, name.startswith("swing"))
    return math.hypot((part.noise or 0.0) / math.sqrt(rows.stop - rows.start), _step(part) / math.sqrt(12.0))


def _step(part: object) -> float:
    """Return the smallest step of a kind's readings [the kind's]."""
    resolution: float = getattr(part, "resolution", None) or 0.0
    return resolution * (1.0 if isinstance(part, Resolver) else getattr(part, "full_scale", 1.0))


def channels(machine: Machine, session: Session, names: tuple[str, ...]) -> list[Channel]:
    """Return the sensor errors of those channels that a session holds and that change in it."""
    there = [name for name in names if session.has(name) and np.ptp(session.readings[name]) > 0.0]
    return [channel(machine, session, name) for name in there]


def accuracy(machine: Machine, session: Session, kind: str) -> float:
    """Return the standard deviation of a kind's static error; 0 for exact sensors."""
    part = getattr(machine.sensors, kind)
    if part is None or session.is_exact:
        return 0.0
    return float((part.accuracy or 0.0) / math.sqrt(3.0))
