"""The figures of a trial.

| figure | is |
|---|---|
| `time`, `loading`, `within`, `unloading` | s in all, of carries and ways 1 to 3, 4, 5 to 7 |
| `up`, `across`, `down`, `grapple` | s of the parts, over all carries and ways |
| `path_ratio` | way of the tip over that of the legs; an operator who cuts corners may be under 1 |
| `reversals` | changes of a lever's sign, of all levers |
| `axes` | levers beyond 5 % at once, on average, while any is |
| `energy`, `fuel` | the engine's work, kJ; the diesel oil for it, mL |
| `sway`, `sway_max` | angle of what hangs from the vertical, RMS and greatest, deg |
| `contacts` | of crane and log with stakes, ground and floor |
| `tip_over` | the least margin, see `forest_description.derived.tip_over` |
"""

import numpy as np

from forest_description.derived.tip_over import tip_over_margins
from forest_description.types import Floats
from forest_study.log_work import clearance
from forest_study.log_work.task import ACROSS, DOWN, HOLD, PHASES, UP, shortest
from forest_study.log_work.work import LOOK_TIME, Work

PUSHED = 0.05  # [1] of a lever that counts as moved
FUEL = 0.0694  # [mL/kJ] of a diesel engine: 210 g/kWh at 0.84 g/mL; assumed, its best at half load
KEYS = {"loading": "loading", "within the bunk": "within", "unloading": "unloading"}


def figures(work: Work) -> dict[str, float]:
    """Return the figures of a trial."""
    m, site = work.machine.manipulator, work.site
    phase = np.array([PHASES[int(number)] for number in work.number])
    part = np.array(work.part)
    energy = 1e-3 * float(work.engine.sum())
    sway = np.degrees(np.arccos(np.clip(np.cos(work.head).prod(axis=1), -1.0, 1.0)))
    told = {"time": LOOK_TIME * len(part)}
    told |= {KEYS[name]: LOOK_TIME * float(np.count_nonzero(phase == name)) for name in KEYS}
    told |= {name: LOOK_TIME * float(np.count_nonzero(part == name)) for name in (UP, ACROSS, DOWN, HOLD)}
    return told | {
        "path_ratio": float(np.linalg.norm(np.diff(work.tip, axis=0), axis=1).sum()) / shortest(site),
        "reversals": float(sum(reversals(column) for column in work.levers.T)),
        "axes": axes_at_once(work.levers),
        "energy": energy,
        "fuel": FUEL * energy,
        "sway": float(np.sqrt(np.mean(sway**2))),
        "sway_max": float(sway.max()),
        "contacts": float(clearance.contacts(m, site, work.angles, work.head, work.loaded)),
        "tip_over": min(
            min(tip_over_margins(site.chassis, m, angles, loaded * site.log_mass))
            for angles, loaded in zip(work.angles, work.loaded, strict=True)
        ),
    }


def reversals(lever: Floats) -> int:
    """Return how often a lever [N] changes its side; what is near its middle has none."""
    sides = np.sign(lever[np.abs(lever) > PUSHED])
    return int(np.count_nonzero(np.diff(sides)))


def axes_at_once(levers: Floats) -> float:
    """Return how many levers [N, 3] are moved at once, on average, while any is."""
    counts = np.count_nonzero(np.abs(levers) > PUSHED, axis=1)
    return float(counts[counts > 0].mean()) if counts.any() else 0.0
