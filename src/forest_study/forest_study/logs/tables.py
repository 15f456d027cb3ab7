"""The benchmark's runs as tables: each mode's figures, and what it saves against the first."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from forest_study.logs.statistics import Difference, Mean, difference, mean
from forest_study.sweep.workers import Row

SHOWN = {
    "time": "time, s",
    "loading": "loading, s",
    "within": "within the bunk, s",
    "unloading": "unloading, s",
    "up": "up, s",
    "across": "across, s",
    "down": "down, s",
    "grapple": "grapple, s",
    "path_ratio": "path ratio",
    "reversals": "lever reversals",
    "axes": "axes at once",
    "energy": "engine, kJ",
    "fuel": "fuel, mL",
    "sway": "sway RMS, deg",
    "sway_max": "sway at most, deg",
    "contacts": "contacts",
    "tip_over": "tip-over margin",
}
TIMES = ("time", "loading", "unloading")


class Group(NamedTuple):
    """What an operator does behind a link, by mode."""

    operator: str
    trip: float  # [s]
    modes: dict[str, dict[str, Mean]]  # figures of each
    saved: dict[str, dict[str, Difference]]  # of each but the first, against the first
    failed: dict[str, int]  # trials that were not ended


def groups(rows: Sequence[Row], modes: Sequence[str]) -> list[Group]:
    """Return the runs by operator and link; of a mode's figures the mean over persons."""
    found = []
    for operator, trip in dict.fromkeys((row["operator"], row["trip"]) for row in rows):
        mine = {
            mode: {
                row["seed"]: row
                for row in rows
                if (row["operator"], row["trip"], row["mode"]) == (operator, trip, mode)
            }
            for mode in modes
        }
        ended = {mode: {k: r for k, r in by.items() if r["error"] is None} for mode, by in mine.items()}
        found.append(
            Group(
                operator=operator,
                trip=trip,
                modes={m: {f: mean([r[f] for r in by.values()]) for f in SHOWN} for m, by in ended.items()},
                saved={mode: _saved(ended[mode], ended[modes[0]]) for mode in modes[1:]},
                failed={mode: len(by) - len(ended[mode]) for mode, by in mine.items()},
            )
        )
    return found


def _saved(ours: dict[int, Row], theirs: dict[int, Row]) -> dict[str, Difference]:
    both = sorted(set(ours) & set(theirs))
    return {f: difference([ours[k][f] for k in both], [theirs[k][f] for k in both]) for f in TIMES}


def text(found: Sequence[Group]) -> str:
    """Return Markdown tables: figures of each group, then what is saved."""
    lines: list[str] = []
    for group in found:
        lines += [
            f"{name(group)}: mean ± 95 % over persons",
            "",
            f"| figure | {' | '.join(group.modes)} |",
            "|---" * (1 + len(group.modes)) + "|",
        ]
        for figure, label in SHOWN.items():
            cells = [with_interval(m[figure]) for m in group.modes.values()]
            lines.append(f"| {label} | {' | '.join(cells)} |")
        lines += [f"| not ended | {' | '.join(str(n) for n in group.failed.values())} |", ""]
    first = next(iter(found[0].modes))
    if any(group.saved for group in found):
        lines += [
            f"time against {first}: change, 95 % interval, p",
            "",
            "| operator | mode | persons | in all | loading | unloading |",
            "|---|---|---|---|---|---|",
        ]
    for group in found:
        for mode, by in group.saved.items():
            cells = [change(by[figure]) for figure in TIMES]
            lines.append(f"| {name(group)} | {mode} | {by['time'].pairs} | {' | '.join(cells)} |")
    return "\n".join(lines)


def with_interval(m: Mean) -> str:
    """Return a mean as people write it, with its interval where there is one."""
    return f"{m.value:.4g}" if math.isnan(m.half) else f"{m.value:.4g} ± {m.half:.2g}"


def change(d: Difference) -> str:
    """Return a difference as people write it: less time is negative."""
    if math.isnan(d.p):
        return f"{-100 * d.saved:+.1f} % (two persons or more give an interval)"
    return f"{-100 * d.saved:+.1f} % ({-100 * d.high:+.1f} … {-100 * d.low:+.1f}), p {d.p:.2g}"


def name(group: Group) -> str:
    """Return who drives, and behind which link."""
    late = f", {1e3 * group.trip:.0f} ms" if group.trip else ""
    return f"{group.operator}{late}"


def told(found: Sequence[Group]) -> list[dict[str, Any]]:
    """Return the groups as JSON has them."""
    return [
        {
            "operator": g.operator,
            "trip_s": g.trip,
            "modes": {mode: {f: m._asdict() for f, m in by.items()} for mode, by in g.modes.items()},
            "saved": {mode: {f: d._asdict() for f, d in by.items()} for mode, by in g.saved.items()},
            "not_ended": g.failed,
        }
        for g in found
    ]
