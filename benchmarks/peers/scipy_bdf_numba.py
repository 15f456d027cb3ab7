"""scipy's BDF (solve_ivp) with right-hand side and Jacobian by Numba."""

from collections.abc import Callable

from scipy.integrate import solve_ivp

from peers import Run
from peers.compiled import jacobian, right_hand_side
from peers.segments import by_segment
from work import Floats, Segment, Work


def prepare(work: Work, start: Floats, tolerance: float, method: str = "BDF") -> Callable[[], Run]:
    """Return the function that does the work."""

    def solve(times: Floats, y: Floats, segment: Segment) -> Floats:
        wave = segment.wave
        return solve_ivp(
            lambda t, y: right_hand_side(t, y, wave),
            (times[0], times[-1]),
            y,
            method=method,
            t_eval=times,
            jac=lambda t, y: jacobian(t, y, wave),
            rtol=tolerance,
            atol=tolerance,
        ).y.T

    return by_segment(work, start, solve)
