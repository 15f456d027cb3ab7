"""scipy's BDF (solve_ivp) with an interpreted right-hand side; its own differences give the Jacobian."""

from collections.abc import Callable

from scipy.integrate import solve_ivp

from peers import Run
from peers.equations import right_hand_side
from peers.segments import by_segment
from work import Floats, Segment, Work


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""

    def solve(times: Floats, y: Floats, segment: Segment) -> Floats:
        wave = segment.wave.tolist()
        return solve_ivp(
            lambda t, y: right_hand_side(t, y, wave),
            (times[0], times[-1]),
            y,
            method="BDF",
            t_eval=times,
            rtol=tolerance,
            atol=tolerance,
        ).y.T

    return by_segment(work, start, solve)
