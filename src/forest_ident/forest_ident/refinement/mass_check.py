"""What rests in several poses tell of masses: moments of both links, and from them masses that one may doubt.

Of boom, stick and head, forces at rest tell two sums along the links (`gravity.moments`). The stick's own is
taken as told, since the head pulls alike: so the sums give head and boom. A mass is corrected where they say
another one than told by more than their errors and `DIFFERS`.
"""

from __future__ import annotations

from forest_ident.estimators import gravity
from forest_ident.estimators.estimate import Estimate, judged
from forest_ident.estimators.least_squares import Line
from forest_ident.measurements.parameter_path import value_of, with_values
from forest_ident.measurements.session import Session
from forest_ident.refinement.linear_estimates import First
from forest_ident.refinement.result import Result

DIFFERS = (4.0, 0.03)  # standard errors and share by which a mass must differ to be corrected
HEAD, BOOM = "manipulator.head_mass", "manipulator.boom_mass"
BY = "forces at rest"


def weigh(result: Result, session: Session) -> None:
    """Compare a rest record with the masses told; correct head and boom if they differ clearly."""
    sums = gravity.moments(result.machine, session)
    if not sums:
        result.remarks.append("load: no check; it takes three or more poses at rest, head without log")
        return
    for one in sums:
        result.linear.append(
            First(
                key=f"gravity: {one.name}",
                value=one.value,
                error=one.error,
                condition=one.condition,
                method=BY,
                main=False,
            )
        )
    told = ", ".join(
        f"{s.name} = {s.value:.5g} kg m (standard error {s.error:.2g}, told {s.told:.5g})" for s in sums
    )
    result.remarks.append(
        f"masses: rests tell {told}; stick and head are not told apart: weigh the head for that"
    )
    if any(drive.friction is not None for drive in (result.machine.boom, result.machine.stick)):
        result.remarks.append("masses: dry friction holds the crane at rest, too; none is corrected by it")
        return
    both = gravity.masses(result.machine, session, ("head_mass", "boom_mass"))
    if _differs(result, both, 1, BOOM):
        _correct(result, both, (HEAD, BOOM))
        return
    head = gravity.masses(result.machine, session, ("head_mass",))
    result.linear.append(
        First(
            key=HEAD,
            value=float(head.values[0]),
            error=float(head.errors[0]),
            condition=head.condition,
            method=BY,
            main=False,
        )
    )
    if _differs(result, head, 0, HEAD):
        _correct(result, head, (HEAD,))


def _differs(result: Result, line: Line, place: int, key: str) -> bool:
    value, error, told = float(line.values[place]), float(line.errors[place]), value_of(result.start, key)
    away = abs(value - told)
    return value > 0.0 and away > DIFFERS[0] * error and away > DIFFERS[1] * told


def _correct(result: Result, line: Line, keys: tuple[str, ...]) -> None:
    for place, key in enumerate(keys):
        value, error = float(line.values[place]), float(line.errors[place])
        told = value_of(result.start, key)
        result.machine = with_values(result.machine, {key: value})
        result.estimates[key] = judged(
            Estimate(
                key=key, value=value, standard_error=error, unit="kg", condition=line.condition, method=BY
            )
        )
        result.remarks.append(f"{key}: the forces at rest say {value:.1f} kg, told were {told:.1f} kg")
