"""A session in numbers: what `summary.json` holds and the table that the demo ends with."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag
from forest_control.operator.operator_profile import OperatorProfile
from forest_description.types import AXES, Floats
from forest_msgs_py.interfaces import topics
from forest_study.demo.hand_measures import hand_measures
from forest_study.latency import lever_delay
from forest_study.measures import Deviation

SUMMARY_DIGITS = 3


TIP_ROWS = {
    "governed": "tip to reference",
    "cross_track": "tip to drawn path",
    "wish": "tip to wish",
}


def bag_summary(bag: Bag, scheme: str, profile: OperatorProfile) -> dict[str, Any]:
    """Return the part of the summary that the bag tells.

    `tip_error_mm` has the distances of the true tip from reference, drawn path and wish (`measures`), and
    `time_lost_s`; None in the joint scheme, where no tip motion is wished. `joy_to_valve_ms` is what the
    graph adds: the time from a joystick sample to the first voltage that answers a later state of the
    machine. `lever_to_valve_ms` is what the hand feels (`lever_delay`). `valve_crossings` counts how often a
    spool goes over its overlap.
    """
    counts = {name: _topic_summary(info) for name, info in sorted(bag.topics.items())}
    return {
        "topics": counts,
        "lost_messages": sum(info.lost for info in bag.topics.values()),
        "tip_error_mm": None if scheme == "joint" else _tip_error_mm(bag, profile),
        "pump_work": pump_work(bag),
        "joy_to_valve_ms": joy_to_valve_ms(bag),
        "valve_crossings": valve_crossings(bag.series(topics.VALVE_VOLTAGES).values),
        "lever_to_valve_ms": lever_delay.lever_to_valve_ms(bag),
        "missed_deadlines": int(bag.series(topics.AUXILIARY).column("missed_deadlines")[-1]),
    }


def _topic_summary(info: Any) -> dict[str, float]:
    seconds = (info.last_ns - info.first_ns) * 1e-9
    rate = (info.count - 1) / seconds if seconds > 0.0 else 0.0
    return {"count": info.count, "rate_hz": round(rate, 1)}


def _tip_error_mm(bag: Bag, profile: OperatorProfile) -> dict[str, Any]:
    found = hand_measures(bag, profile)
    told: dict[str, Any] = {name: _rounded(getattr(found, name)) for name in TIP_ROWS}
    return {**told, "time_lost_s": round(found.time_lost_s, 2)}


def _rounded(off: Deviation | None) -> dict[str, float] | None:
    return None if off is None else {"rms": round(off.rms_mm, 1), "max": round(off.max_mm, 1)}


def pump_work(bag: Bag) -> dict[str, float]:
    """Return what the pump gave to its oil [kJ], and that per metre that the tip went [kJ/m]."""
    supply, tip = bag.series(topics.SUPPLY), bag.series(topics.GROUND_TRUTH_TIP_POSE)
    return work_per_metre(
        1e-9 * (supply.time_ns - supply.time_ns[0]),
        supply.column("pressure") * supply.column("flow"),
        tip.values[:, :3],
    )


def work_per_metre(time: Floats, power: Floats, places: Floats) -> dict[str, float]:
    """Return a pump's work [kJ], and that per metre of a tip's way [kJ/m]; 0 where it did not move.

    Args:
        time: of the powers [N] s.
        power: pressure times flow at the pump [N] W.
        places: of the tip [M, 3] m.
    """
    work = 1e-3 * float(0.5 * (power[1:] + power[:-1]) @ np.diff(time))
    way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
    return {"kj": round(work, 1), "kj_per_m": round(work / way, 1) if way > 0.0 else 0.0}


def valve_crossings(voltages: Floats) -> dict[str, int]:
    """Return how often each axis' voltage changes its side, zeros left out: its spool crosses the overlap.

    Args:
        voltages: [N, 3] V, a row a message.
    """
    sides = [np.sign(column[column != 0.0]) for column in voltages.T]
    return {axis: int(np.count_nonzero(np.diff(side))) for axis, side in zip(AXES, sides, strict=True)}


def joy_to_valve_ms(bag: Bag) -> dict[str, float] | None:
    """Return median and 99th percentile [ms], None if no voltage ever followed a joystick sample."""
    joy, volts = bag.series(topics.JOY), bag.series(topics.VALVE_VOLTAGES)
    # Zeros that a watchdog said carry the time of saying, not that of a state.
    answers = np.isin(volts.time_ns, bag.series(topics.JOINT_STATES).time_ns)
    delays = response_times(joy.time_ns, volts.time_ns[answers], volts.log_time_ns[answers]) * 1e-6
    if len(delays) == 0:
        return None
    p50, p99 = np.percentile(delays, [50, 99])
    return {"p50": round(float(p50), SUMMARY_DIGITS), "p99": round(float(p99), SUMMARY_DIGITS)}


def response_times(
    cause_ns: NDArray[np.int64], state_ns: NDArray[np.int64], effect_ns: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return how long after each cause [ns] the first effect came whose state was sampled after that cause.

    Args:
        cause_ns: stamps of the causes [N], rising.
        state_ns: stamps of the machine states that the effects answer [M], rising.
        effect_ns: when the effects were seen [M].
    """
    first = np.searchsorted(state_ns, cause_ns, side="right")
    answered = first < len(state_ns)
    times: NDArray[np.int64] = effect_ns[first[answered]] - cause_ns[answered]
    return times


def table(summary: dict[str, Any]) -> str:
    """Return the short table that ends the demo."""
    delay = summary["joy_to_valve_ms"]
    rows = [
        ("scheme", summary["scheme"]),
        ("duration", f"{summary['duration_s']:g} s"),
        (
            "messages",
            f"{sum(t['count'] for t in summary['topics'].values())}, lost {summary['lost_messages']}",
        ),
        *_tip_rows(summary["tip_error_mm"]),
        (
            "joystick to valve",
            "-" if delay is None else f"{delay['p50']:.1f} ms median, {delay['p99']:.1f} ms p99",
        ),
        *lever_delay.rows(summary["lever_to_valve_ms"]),
        ("pump work", f"{summary['pump_work']['kj_per_m']:g} kJ per metre of the tip"),
        ("memory", ", ".join(f"{name} {mb:.0f} MB" for name, mb in summary["peak_memory_mb"].items())),
    ]
    return "\n".join(f"  {name:<18} {value}" for name, value in rows)


def _tip_rows(errors: dict[str, Any] | None) -> list[tuple[str, str]]:
    """Return every measure's row: none is told alone."""
    if errors is None:
        return [("tip error", "- (joint mode)")]
    rows = [(text, _off(errors[name])) for name, text in TIP_ROWS.items()]
    return [*rows, ("time lost", f"{errors['time_lost_s']:g} s")]


def _off(error: dict[str, float] | None) -> str:
    return "- (no lever asked)" if error is None else f"{error['rms']:g} mm RMS, {error['max']:g} mm max"
