"""A comparison told: as a table for people, as JSON for programs."""

import math
from typing import Any

from forest_bag.compare.comparison import Comparison, SignalDifference, Tolerance, TopicDifference
from forest_msgs_py.types import NS_PER_S

LISTED = 40  # characters for a name


def table(comparison: Comparison, tolerance: Tolerance) -> str:
    """Topics with their counts, and below those that differ their signals: RMS and largest difference."""
    lines = [f"{'topic':{LISTED}} {'messages':>17} {'alone':>11} {'differ':>8}"]
    for topic in comparison.topics.values():
        counts, alone = (f"{pair[0]} / {pair[1]}" for pair in (topic.counts, topic.alone))
        verdict = "" if topic.within(tolerance) else "  <-"
        lines.append(f"{topic.topic:{LISTED}} {counts:>17} {alone:>11} {topic.differing:>8}{verdict}")
        lines += [_signal_line(topic, signal) for signal in topic.signals.values()]
        if topic.log_times:
            lines.append(f"  {topic.log_times} log times differ")
    for side, names in zip("AB", comparison.alone, strict=True):
        lines += [f"{name:{LISTED}} only in {side}  <-" for name in names]
    if comparison.ignored:
        lines.append(f"not compared: {', '.join(comparison.ignored)}")
    if (first := comparison.first(tolerance)) is not None:
        name, place = first
        lines.append(f"first difference: {name}, message {place.message}{_at(place.stamp_ns)}: {place.what}")
    return "\n".join(lines)


def _signal_line(topic: TopicDifference, signal: SignalDifference) -> str:
    unit = "" if signal.unit in ("", "1") else f" {signal.unit}"
    place = _at(signal.largest_ns) if signal.largest else ""
    rms, largest = f"{topic.rms(signal):.3g}{unit}", f"{signal.largest:.3g}{unit}"
    return f"  {signal.label:{LISTED - 2}} RMS {rms}, at most {largest}{place}"


def as_json(comparison: Comparison, tolerance: Tolerance, names: tuple[str, str]) -> dict[str, Any]:
    """The same for programs; infinite differences (a number beside none) are null."""
    return {
        "a": names[0],
        "b": names[1],
        "same": comparison.same(tolerance),
        "only_in_a": list(comparison.alone[0]),
        "only_in_b": list(comparison.alone[1]),
        "not_compared": list(comparison.ignored),
        "topics": [_topic(topic, tolerance) for topic in comparison.topics.values()],
    }


def _topic(topic: TopicDifference, tolerance: Tolerance) -> dict[str, Any]:
    place = topic.place(tolerance)
    return {
        "topic": topic.topic,
        "type": topic.type,
        "same": topic.within(tolerance),
        "messages": topic.counts,
        "pairs": topic.pairs,
        "alone": topic.alone,
        "differing": topic.differing,
        "differing_log_times": topic.log_times,
        "differing_structure": topic.structure,
        "first": None
        if place is None
        else {"message": place.message, "stamp_ns": place.stamp_ns, "what": place.what},
        "signals": [
            {
                "label": signal.label,
                "unit": signal.unit,
                "rms": _finite(topic.rms(signal)),
                "largest": _finite(signal.largest),
                "largest_stamp_ns": signal.largest_ns,
                "tolerance": tolerance(topic.topic, signal.label),
            }
            for signal in topic.signals.values()
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _at(time_ns: int) -> str:
    return f" at {time_ns // NS_PER_S}.{time_ns % NS_PER_S:09d} s"
