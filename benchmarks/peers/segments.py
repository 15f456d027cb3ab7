"""What the peers that integrate segment by segment share."""

import time
from collections.abc import Callable

import numpy as np

from peers import Run
from peers.equations import SCALE, SHUT_OPENING, deadband, per_volt
from work import SAMPLE, Floats, Segment, Work

# Solve(times, y, segment) returns the scaled states at `times`, y first.
Solve = Callable[[Floats, Floats, Segment], Floats]


def shut_flows(y: Floats, segment: Segment) -> Floats:
    """Return the state at a segment's start, without the flows that a valve shut at once has stopped."""
    mean, amplitude, omega, phase = segment.wave.reshape(3, 4).T
    voltage = mean + amplitude * np.sin(omega * segment.first * SAMPLE + phase)
    y = y.copy()
    for axis in np.flatnonzero((abs(voltage) - deadband) * per_volt < SHUT_OPENING):
        y[6 * axis + 4 : 6 * axis + 6] = 0.0
    return y


def by_segment(work: Work, start: Floats, solve: Solve) -> Callable[[], Run]:
    """Return a function that does the work with the solver restarted at every segment."""
    times = [np.arange(s.first, s.last + 1) * SAMPLE for s in work.segments]

    def integrate() -> Run:
        states = np.empty((work.samples + 1, 18))
        states[0] = y = start / SCALE
        began = time.process_time()
        for segment, t in zip(work.segments, times, strict=True):
            states[segment.first + 1 : segment.last + 1] = solve(t, shut_flows(y, segment), segment)[1:]
            y = states[segment.last]
        return Run(states * SCALE, time.process_time() - began)

    return integrate
