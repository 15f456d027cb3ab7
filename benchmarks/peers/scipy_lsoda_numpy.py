"""scipy's LSODA (odeint, whose loop over steps is compiled) with an interpreted right-hand side.

The right-hand side works on Python floats between two NumPy arrays: for 18 states that is several times
faster than array operations. LSODA's own differences give the Jacobian.
"""

from collections.abc import Callable

from scipy.integrate import odeint

from peers import Run
from peers.equations import right_hand_side
from peers.segments import by_segment
from work import Floats, Segment, Work


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""

    def solve(times: Floats, y: Floats, segment: Segment) -> Floats:
        return odeint(
            right_hand_side,
            y,
            times,
            args=(segment.wave.tolist(),),
            tfirst=True,
            rtol=tolerance,
            atol=tolerance,
            mxstep=100_000,
        )

    return by_segment(work, start, solve)
