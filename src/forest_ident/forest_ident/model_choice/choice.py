"""Free the physics that a person allows, and keep what held-out records confirm."""

from collections.abc import Callable, Sequence

from forest_description.config.parameter import MachineError
from forest_description.machine import Machine
from forest_ident.measurements.session import SessionError
from forest_ident.model_choice import residual_patterns
from forest_ident.model_choice.candidates import CANDIDATES, added
from forest_ident.model_choice.held_out_comparison import compare
from forest_ident.model_choice.measured_curve import with_measured_curves
from forest_ident.refinement.result import Result

MACHINE = 200.0  # times a sensor's noise, that another machine leaves at least; dry friction leaves 160

Identify = Callable[[Machine], Result]


def chosen(start: Machine, identify: Identify, allowed: Sequence[str]) -> Result:
    """Return the identification with the allowed physics that the held-out records confirm.

    Each name is tried in turn on the best model so far: its sections are added to the start, all records are
    fitted anew, and the held-out records decide. A remark tells each decision, and what is still left over.

    Args:
        start: the machine as known until then.
        identify: start to result.
        allowed: names of `candidates.CANDIDATES`.

    Raises:
        SessionError: one record alone contradicts the others, and looks like no physics of a crane.
    """
    best: Result = identify(start)
    decisions: list[str] = []
    for candidate in CANDIDATES:
        if candidate.name not in allowed:
            continue
        try:
            fitted = {one.session.name for one in best.refined}
            richer_start, untold = added(candidate, best.start, fitted)
        except MachineError as error:
            decisions.append(f"--allow {candidate.name}: this crane cannot have it ({error})")
            continue
        cannot = _cannot_tell(untold)
        if richer_start == best.start:
            decisions.append(
                f"--allow {candidate.name}: "
                + (f"{candidate.physics}{cannot}" if untold else f"the start has {candidate.physics} already")
            )
            continue
        if candidate.name == "curve":
            records = [one.session for one in best.refined]
            richer_start = with_measured_curves(richer_start, records)
        try:
            richer = identify(richer_start)
            gain = compare(best.machine, richer.machine, best.held_out)
        except ValueError as error:  # what was fitted without it is not lost by it
            decisions.append(f"--allow {candidate.name}: {candidate.physics}, not kept: {error}")
            continue
        decisions.append(
            f"--allow {candidate.name}: {candidate.physics}, {'kept' if gain.better else 'not kept'}: "
            f"{gain.told()}{cannot}"
        )
        best = richer if gain.better else best
    named = residual_patterns.findings(best)
    if best.stranger and best.stranger not in {one.record for one in named}:
        _refuse_another_machines(best)
    best.remarks += decisions + [one.sentence() for one in named]
    return best


def _cannot_tell(axes: Sequence[str]) -> str:
    """Return the end of a remark on the axes of which no record tells; "" without one."""
    records = " and ".join(f"damping_{axis}" for axis in axes)
    return f"; these records cannot tell it of {' and '.join(axes)}: it takes {records}" if axes else ""


def _refuse_another_machines(result: Result) -> None:
    """Refuse the record that contradicts all others, if it does so by far."""
    if (
        max(residual_patterns.times_noise(r) for r in result.refined if r.session.name == result.stranger)
        < MACHINE
    ):
        return
    said = next(remark for remark in result.remarks if remark.startswith(f"{result.stranger}: the model"))
    raise SessionError(
        f"{said} The other records agree with each other, and it looks like no physics of a crane: leave "
        "this one out, or check whose it is and which experiment"
    )
