"""What was gained: on plants that the search has not seen, and at which robustness."""

from collections.abc import Mapping, Sequence
from typing import Any

from forest_study.logs.statistics import Difference, difference
from forest_study.stability.margins import Margins
from forest_study.tune.bench import Row

FIGURES = {
    "cross_track_rms_mm": "cross-track RMS",
    "cross_track_max_mm": "cross-track, max",
    "governed_rms_mm": "governed RMS",
    "governed_max_mm": "governed, max",
    "wish_rms_mm": "wish RMS",
    "velocity_rms": "velocity RMS",
    "activity": "valve activity",
}


def compared(ours: Sequence[Row], rule: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Return, by row of the matrix and figure, the change with its interval, and each side's worst seed."""
    found: dict[str, dict[str, Any]] = {}
    for name in dict.fromkeys(one["row"] for one in rule):
        both = [(a["figures"], b["figures"]) for a, b in zip(ours, rule, strict=True) if b["row"] == name]
        ended = [(a, b) for a, b in both if a and b]
        found[name] = {
            "plants": len(both),
            "not_ended": {"rule": sum(not b for _, b in both), "tuned": sum(not a for a, _ in both)},
            "figures": {key: _figure(ended, key) for key in FIGURES},
        }
    return found


def _figure(ended: Sequence[tuple[Mapping[str, float], Mapping[str, float]]], key: str) -> dict[str, Any]:
    ours, rule = [a[key] for a, _ in ended], [b[key] for _, b in ended]
    worst = {"rule": max(rule, default=None), "tuned": max(ours, default=None)}
    return {"worst": worst, "change": difference(ours, rule)._asdict()}


def answer(found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return a sentence for each row: what was gained, or that nothing is shown."""
    said = []
    for name, row in found.items():
        for key in ("cross_track_rms_mm", "governed_rms_mm"):
            d = Difference(**row["figures"][key]["change"])
            shown = "less" if d.low > 0.0 else "more" if d.high < 0.0 else "no difference is shown"
            said.append(f"{name}, {FIGURES[key]}: {shown}; {_change(d)} on {d.pairs} unseen plants.")
    return said


def _change(d: Difference) -> str:
    return f"{-100 * d.saved:+.1f} % ({-100 * d.high:+.1f} … {-100 * d.low:+.1f})"


def table(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the comparison as Markdown: mean change with its interval, and the worst seed."""
    lines = ["| row | figure | change, 95 % interval | worst, rule | worst, tuned |", "|---" * 5 + "|"]
    for name, row in found.items():
        lost = row["not_ended"]
        for key, label in FIGURES.items():
            of = row["figures"][key]
            worst = " | ".join("" if x is None else f"{x:.3g}" for x in of["worst"].values())
            lines.append(f"| {name} | {label} | {_change(Difference(**of['change']))} | {worst} |")
        if lost["rule"] or lost["tuned"]:
            lines.append(f"| {name} | not ended of {row['plants']} | | {lost['rule']} | {lost['tuned']} |")
    return "\n".join(lines)


def robustness(rule: Mapping[str, Margins], tuned: Mapping[str, Margins]) -> str:
    """Return the least margins over the poses as Markdown."""
    head = "| joint | gains | gain margin | phase margin, deg | crossover, Hz | greatest 1/abs(1 + L) |"
    lines = [head, "|---" * 6 + "|"]
    for axis in rule:
        for label, one in (("rule", rule[axis]), ("tuned", tuned[axis])):
            lines.append(
                f"| {axis} | {label} | {one.gain:.3g} | {one.phase:.0f} | {one.crossover:.2f} "
                f"| {one.sensitivity:.2f} |"
            )
    return "\n".join(lines)
