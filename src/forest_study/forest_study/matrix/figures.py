"""What a run of the matrix is judged by."""

from typing import NamedTuple


class Figures(NamedTuple):
    """What a run is judged by; of a seed, the worst of its paths."""

    cross_track_rms_mm: float
    cross_track_max_mm: float
    governed_rms_mm: float
    governed_max_mm: float
    wish_rms_mm: float
    wish_max_mm: float
    wish_over_bound: float  # share of its bound, of runs in which no limit acted
    waited_s: float  # longer than the profile, because a limit acted
    time_lost_s: float
    velocity_rms: float  # [m/s] against the governed reference
    end_mm: float
    overshoot_mm: float  # beyond the path's end, along its last direction
    activity: float  # [V/s] mean of |dV/dt| of the busiest valve
