"""Checks of a record's quality: cut off, not explained by the model, or not evaluable.

A remark where a fit is still of use; a `SessionError` that names the record where it is not.
"""

import contextlib
import dataclasses
from collections.abc import Iterator

import numpy as np

from forest_description.machine import Machine
from forest_ident.experiments import test_rig
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Fit

FAR = 5.0  # times a sensor's noise: greater residuals are errors of the model


def cut_off(session: Session) -> str:
    """Return the remark on a record that has no end."""
    return f"{session.name}: the bag was cut off, what is whole of it ({session.time[-1]:.1f} s) was used"


def not_explained(start: Machine, session: Session, fit: Fit) -> list[str]:
    """Return a remark if residuals are far above the noise of a sensor, naming the worst.

    Args:
        start: whose file has the sensors' noise; those it lacks are a bench's.
        session: that was fitted.
        fit: of it.
    """
    if session.is_exact:
        return []
    sensed = dataclasses.replace(start, sensors=test_rig.meters(start))
    known = (name for name in fit.noise if getattr(sensed.sensors, noise_model.KIND[name].name) is not None)
    times = {name: fit.noise[name] / noise_model.channel(sensed, session, name).noise for name in known}
    worst = max(times, key=times.__getitem__, default="")
    if not worst or times[worst] < FAR:
        return []
    left = f"{fit.noise[worst]:.2g} {noise_model.KIND[worst].unit} are left at {worst}"
    remark = (
        f"{session.name}: the model does not explain this record: {left}, {times[worst]:.0f} times the "
        "sensor's noise; intervals mean little then: is it another machine's, or was its computer late?"
    )
    return [remark]


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
