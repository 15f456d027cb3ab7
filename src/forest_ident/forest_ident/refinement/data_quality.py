"""Checks of a record's quality: cut off, not explained by the model, or not evaluable.

A remark where a fit is still of use; a `SessionError` that names the record where it is not.
"""

import contextlib
import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from forest_description.machine import Machine
from forest_ident.experiments import rigs
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error import noise_model, residual_test
from forest_ident.output_error.fit_problem import FAR, Fit
from forest_ident.output_error.residual_test import ResidualTest

AGREE = 4  # records of which one alone may be a stranger
CORRELATED = 0.2  # at the sensor's lag 1
LEFT = 1.5  # times a sensor's noise: correlated residuals of more are the model's
ASKED = 5.0  # standard deviations of a stated number: who told it is not that far off


def cut_off(session: Session) -> str:
    """Return the remark on a record that has no end."""
    return f"{session.name}: the bag was cut off, what is whole of it ({session.time[-1]:.1f} s) was used"


def residual_tests(start: Machine, session: Session, fit: Fit) -> list[ResidualTest]:
    """Return what is left of each channel, at its sensor's rate, against noise and what was told.

    Args:
        start: whose file has the sensors' noise; those it lacks are a bench's.
        session: that was fitted.
        fit: of it.
    """
    sensed = dataclasses.replace(start, sensors=rigs.meters(start))
    found = []
    for name, noise in fit.noise.items():
        known = not session.is_exact and getattr(sensed.sensors, noise_model.KIND[name].name) is not None
        own = noise_model.channel(sensed, session, name).noise if known else noise
        own = math.hypot(own, fit.stated_noise[name])  # wrong stated numbers may have left as much
        residual = fit.residuals[name]
        lags = residual_test.autocorrelation(residual)
        first = None if lags is None else float(lags[0])
        found.append(ResidualTest(name, noise, noise / own, int(np.isfinite(residual).sum()), first))
    return found


def is_explained(tests: Sequence[ResidualTest]) -> bool:
    """Tell whether no channel's residuals are far above the noise of its sensor."""
    return all(test.times < FAR for test in tests)


def not_explained(session: Session, tests: Sequence[ResidualTest]) -> list[str]:
    """Return a remark if residuals are far above the noise of a sensor, naming the worst."""
    if is_explained(tests):
        return []
    worst = max(tests, key=lambda test: test.times)
    left = f"{worst.noise:.2g} {noise_model.KIND[worst.channel].unit} are left at {worst.channel}"
    remark = (
        f"{session.name}: the model does not explain this record: {left}, {worst.times:.0f} times the "
        "sensor's noise; intervals mean little then, and are withheld: is it another machine's, or was its "
        "computer late?"
    )
    return [remark]


def doubt(session: Session, fit: Fit, tests: Sequence[ResidualTest], stated: Sequence[str]) -> str:
    """Return why what a record found is doubtful, "" if it is not.

    Args:
        session: that was fitted.
        fit: of it.
        tests: of what is left of each channel.
        stated: names of the stated numbers, in the order in which the fit has them.
    """
    if not fit.converged:
        return f"the search of {session.name} was broken off after {fit.iterations} steps"
    far, number = max(zip(np.abs(fit.asked).tolist(), stated, strict=False), default=(0.0, ""))
    if far > ASKED:
        return (
            f"what is left of {session.name} asks for {number} {far:.0f} standard deviations from what "
            "is told: told numbers are wrong, the search ended in a wrong place, or the model lacks "
            "something; its interval holds none of that"
        )
    odd = [t for t in tests if t.times > LEFT and (t.correlation or 0.0) > CORRELATED]
    if not odd:
        return ""
    worst = max(odd, key=lambda test: test.times)
    return (
        f"interval widened, residuals of {session.name} are {worst.times:.1f} times the noise of "
        f"{worst.channel} and correlated ({worst.correlation:.2f})"
    )


def stranger(tests_by_record: Mapping[str, Sequence[ResidualTest]]) -> str:
    """Return the only record that is not explained, where the others agree with each other; else "".

    A machine that obeys other laws shows in several records. One alone is of another machine, or of another
    experiment than it says.
    """
    odd = [name for name, tests in tests_by_record.items() if not is_explained(tests)]
    return odd[0] if len(odd) == 1 and len(tests_by_record) >= AGREE else ""


@contextlib.contextmanager
def evaluated(session: Session) -> Iterator[None]:
    """Name the session that cannot be evaluated: a record of something else, or hardly any.

    Raises:
        SessionError: it cannot.
    """
    try:
        yield
    except SessionError:
        raise
    except (ArithmeticError, LookupError, ValueError, np.linalg.LinAlgError) as error:
        raise SessionError(
            f"{session.name}: the record cannot be evaluated ({error}); allowed: this experiment, as "
            "`forest-ident experiment list` tells it"
        ) from error
