"""What is allowed to each residual, from healthy machines (`forest_study.diagnosis.population`).

Tolerance: what residuals of machines that are as far off their file as the matrix' differ by at most.
Spread, and the slack beyond it: what one machine's wander by in ten minutes, oil that warms included.
Threshold: a fifth above the greatest sum in 24 healthy hours (100 runs of `c180_hoses`, 45 of `c180`), or in
80 more (240 of each) where that is higher; 9 at least. What the driver learns takes two minutes to settle,
and as long a supply's mean over a day's motions. What that costs in false alarms on other machines:
`docs/explanation/diagnosis.md`.
"""

from forest_ident.diagnosis.residuals import NAMES
from forest_ident.diagnosis.sequential_test import Limits

OF: dict[str, Limits] = {
    "swing_lost": Limits(8.0, 1.0, 12.0, 15.0, 15.0),
    "lost": Limits(1.5, 0.5, 9.0, 0.3, 0.0),
    "follow": Limits(0.1, 0.7, 20.0, 0.2, 20.0),
    "spool": Limits(10.0, 1.0, 26.0, 25.0, 20.0),
    "stiff": Limits(0.25, 0.7, 12.5, 0.4, 6.0),
    "swing_deadband": Limits(0.16, 1.0, 12.0, 0.3, 120.0),
    "swing_gain": Limits(0.5, 1.0, 12.0, 0.5, 120.0),
    "deadband": Limits(0.04, 1.0, 12.0, 0.3, 120.0),
    "gain": Limits(0.06, 1.0, 12.0, 0.3, 120.0),
    "supply": Limits(0.03, 1.0, 15.5, 0.08, 120.0),
    "drain": Limits(0.4, 1.5, 12.0, 1.0, 60.0),
    "swing_meter": Limits(0.1, 1.0, 12.0, 0.3, 20.0),
    "meter": Limits(0.05, 0.7, 12.0, 0.07, 20.0),
    "agree": Limits(0.3, 1.0, 12.0, 2.0, 30.0),
    "pair": Limits(0.003, 1.0, 15.5, 0.01, 5.0),
    "cold": Limits(1.0, 1.0, 9.0, 0.0, 0.0),
}
"""By a part of the residual's name; the first that it holds."""


def kind(name: str) -> str:
    """Return which row of `OF` a residual goes by."""
    return next(key for key in OF if key in name)


LIMITS = tuple(OF[kind(name)] for name in NAMES)
