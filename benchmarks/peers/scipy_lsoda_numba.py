"""scipy's LSODA (odeint, whose loop over steps is compiled) with right-hand side and Jacobian by Numba.

The Jacobian by Numba is a third faster than letting LSODA take differences itself.
"""

from collections.abc import Callable

from scipy.integrate import odeint

from peers import Run
from peers.compiled import jacobian, right_hand_side
from peers.segments import by_segment
from work import Floats, Segment, Work


def prepare(work: Work, start: Floats, tolerance: float) -> Callable[[], Run]:
    """Return the function that does the work."""

    def solve(times: Floats, y: Floats, segment: Segment) -> Floats:
        return odeint(
            right_hand_side,
            y,
            times,
            args=(segment.wave,),
            Dfun=jacobian,
            tfirst=True,
            rtol=tolerance,
            atol=tolerance,
            mxstep=100_000,
        )

    return by_segment(work, start, solve)
