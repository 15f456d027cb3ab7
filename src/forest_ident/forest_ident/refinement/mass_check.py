"""Check the masses of the machine file against rests in several poses.

Of boom, stick and head, forces at rest identify two sums along the links (`gravity.moments`). The stick's own
moment is taken from the file, since the head pulls alike: so the sums give head and boom. A mass is corrected
where its estimate differs by more than its errors and `DIFFERS`.
"""

from forest_ident.estimators import gravity
from forest_ident.estimators.least_squares import LinearFit
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.measurements.session import Session
from forest_ident.refinement.result import Result

DIFFERS = (4.0, 0.03)  # standard errors and share by which a mass must differ to be corrected
HEAD, BOOM = "manipulator.head_mass", "manipulator.boom_mass"
METHOD = "forces at rest"


def check_masses(result: Result, session: Session) -> None:
    """Compare a rest record with the file's masses; correct head and boom if they differ clearly."""
    sums = gravity.moments(result.machine, session)
    if not sums:
        result.remarks.append("load: no check; it takes three or more poses at rest, head without log")
        return
    result.linear += [
        Estimate(
            key=f"gravity: {m.name}",
            value=m.value,
            standard_error=m.error,
            unit="kg*m",
            condition=m.condition,
            method=METHOD,
            initial=False,
        )
        for m in sums
    ]
    estimates = ", ".join(
        f"{s.name} = {s.value:.5g} kg m (standard error {s.error:.2g}, told {s.known:.5g})" for s in sums
    )
    result.remarks.append(
        f"masses: rests tell {estimates}; stick and head are not told apart: weigh the head for that"
    )
    if any(drive.friction is not None for drive in (result.machine.boom, result.machine.stick)):
        result.remarks.append("masses: dry friction holds the crane at rest, too; none is corrected by it")
        return
    fit = gravity.masses(result.machine, session, ("head_mass", "boom_mass"))
    head, boom = _estimates(fit, HEAD, BOOM)
    if _differs(result, boom):
        _correct(result, (head, boom))
        return
    fit = gravity.masses(result.machine, session, ("head_mass",))
    (head,) = _estimates(fit, HEAD)
    result.linear.append(head)
    if _differs(result, head):
        _correct(result, (head,))


def _estimates(fit: LinearFit, *keys: str) -> list[Estimate]:
    pairs = zip(keys, fit.values.tolist(), fit.errors.tolist(), strict=True)
    return [
        Estimate(
            key=key,
            value=value,
            standard_error=error,
            unit="kg",
            condition=fit.condition,
            method=METHOD,
            initial=False,
        )
        for key, value, error in pairs
    ]


def _differs(result: Result, e: Estimate) -> bool:
    known = value_of(result.start, e.key)
    away = abs(e.value - known)
    return e.value > 0.0 and away > DIFFERS[0] * e.standard_error and away > DIFFERS[1] * known


def _correct(result: Result, masses: tuple[Estimate, ...]) -> None:
    for e in masses:
        known = value_of(result.start, e.key)
        result.machine = with_values(result.machine, {e.key: e.value})
        result.estimates[e.key] = e.checked()
        result.remarks.append(f"{e.key}: the forces at rest say {e.value:.1f} kg, told were {known:.1f} kg")
