"""The results of a fit as text for a terminal."""

import math

from forest_description.machine import Machine
from forest_ident.estimators.calibration import Offset
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.refinement.result import Result, table, told_table, value_in

LITTLE = 0.005  # share of a variance that is not worth a word


def text_table(result: Result) -> str:
    """Return the estimates as text: start, value, interval, warning; sensors."""
    lines = [f"  {'parameter':<42} {'stated':>11} {'found':>13}  {'of stated':>9}  95 % interval (most from)"]
    for e, before in table(result):
        lines.append(_row(e, before))
        if e.warning:
            lines.append(f"    warning: {e.warning}")
    if result.told:
        lines.append("  stated numbers as the records have them")
        lines += [_row(e, before) for e, before in told_table(result)]
        whys = dict.fromkeys(e.warning for e in result.told.values() if e.warning)
        lines += [f"    warning: {why}" for why in whys]
    return "\n".join(lines + [_calibrated(o) for o in result.calibration if math.isfinite(o.offset_error)])


def _row(e: Estimate, before: float | None) -> str:
    """Return an estimate's row of the table; before: what was stated."""
    value, low, high = e.formatted()
    was = "-" if before is None else f"{before:.5g}"
    most = f" ({e.most})" if e.stated > LITTLE else ""
    interval = "withheld" if e.withheld else f"{low} .. {high} {e.unit}"
    return f"  {e.key:<42} {was:>11} {value:>13}  {100.0 * e.stated:>7.0f} %  {interval}{most}"


def against(result: Result, truth: Machine) -> str:
    """Return the error of every estimate, and whether its interval contains the truth."""
    pairs = [(e, value_in(truth, e.key)) for e, _ in table(result)]
    known = [(e, true) for e, true in pairs if true is not None]
    told = [(e, true) for e, true in known if not e.withheld]
    held = sum(e.contains(true) for e, true in told)
    lines = []
    for e, true in known:
        off = f"{e.value - true:+.7f} {e.unit}"
        if true != 0.0 and e.positive:
            off = f"{100.0 * (e.value / true - 1.0):+.5f} %"
        missed = ", interval withheld" if e.withheld else "" if e.contains(true) else ", interval misses"
        lines.append(f"  {e.key:<42} truth {true:<11.6g} off by {off}{missed}")
    withheld = f", {len(known) - len(told)} are withheld" if len(told) < len(known) else ""
    return "\n".join([*lines, f"  {held} of {len(told)} 95 % intervals hold the truth{withheld}"])


def _calibrated(o: Offset) -> str:
    """Return offset and gain of a sensor as text."""
    pairs = zip(("offset", "gain"), o.formatted(), strict=True)
    parts = ", ".join(f"{name} {text}" for name, text in pairs if text)
    return f"  sensors.calibration.{o.channel:<26} {parts}"
