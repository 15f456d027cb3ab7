"""Is a record of the experiment that it names? By the axes that were driven, and how the platform stood."""

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.experiments.experiment_plan import TILT
from forest_ident.measurements.session import Session, SessionError

DRIVEN = 0.02  # of a valve's rated voltage: less is no opening
TILTED = 0.3 * TILT  # [rad]


def demand(machine: Machine, session: Session) -> None:
    """Refuse a record that is of another experiment than it says.

    Raises:
        SessionError: it drives an axis that its experiment leaves alone, or stands otherwise.
    """
    allowed = _axes(session)
    if allowed is None:
        return
    strangers = [name for name in _driven(machine, session) if name not in allowed]
    if strangers:
        only = f"only {' and '.join(allowed)}" if allowed else "none: all valves stay shut"
        raise SessionError(
            f"{session.name}: the record drives {' and '.join(strangers)}; allowed: {only}: is it another "
            "experiment's under this name?"
        )
    if session.name == "motor_external" and not _driven(machine, session):
        raise SessionError(
            "motor_external: the record drives no axis; allowed: the swing: is it motor_internal's?"
        )
    if session.kind == "motor" and session.has("platform_roll"):
        tilt = abs(float(np.mean(session.column("platform_roll"))))
        if (tilt > TILTED) != (session.name == "motor_internal"):
            stands = "tilted" if session.name == "motor_internal" else "level"
            raise SessionError(f"{session.name}: the platform rolls {tilt:.3f} rad; allowed: a {stands} one")


def _axes(session: Session) -> tuple[str, ...] | None:
    """Return the axes that an experiment on the crane may drive; None for one of which nothing is known."""
    if session.own_axis and session.kind in ("damping", "deadband"):
        return (session.own_axis,)
    return {"gravity": AXES[1:], "motor_external": AXES[:1], "motor_internal": ()}.get(session.name)


def _driven(machine: Machine, session: Session) -> list[str]:
    most = np.max(np.abs(session.voltages), axis=0)
    return [name for k, name in enumerate(AXES) if most[k] > DRIVEN * machine.valve_of(k).rated_voltage]
