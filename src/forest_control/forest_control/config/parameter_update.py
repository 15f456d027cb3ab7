"""Updates of parameters while the crane moves: one change fades before the next takes effect.

A change keeps the command where it was and lets the difference fade (`bumpless_transfer`). Changes
that come faster, as from a slider that is dragged, would hold levers and servos off and rock the
crane. So they wait, and the newest counts.

In the scheme `joint` a lever moves one joint, in all others the tip: one that is held would come to mean
another motion, up to nine times as fast. Such a change waits until nothing is commanded.
"""

from forest_control.config.controller_settings import Parameters
from forest_control.servo.schemes import Scheme

SETTLED = 1.0  # [s] between two changes: a transfer fades in 0.2 s, the rocking of a swing in 1 s


class ParameterUpdate:
    """The parameters in force, and those that wait.

    Args:
        core: in force from the beginning.
    """

    def __init__(self, core: Parameters) -> None:
        self.core = core
        self._requested: Parameters | None = None
        self._since = SETTLED  # [s] since the last change

    def request(self, core: Parameters) -> None:
        """Request parameters; they replace those that wait."""
        self._requested = core

    def apply_if_due(self, resting: bool, dt: float) -> bool:
        """Put the requested parameters in force if it is time; tell whether that happened.

        Args:
            resting: nothing is commanded.
            dt: since the last time [s].
        """
        self._since += dt
        if self._requested is None:
            return False
        other_levers = (self.core.scheme == Scheme.JOINT) != (self._requested.scheme == Scheme.JOINT)
        if not resting and (other_levers or self._since < SETTLED):
            return False
        self.core, self._requested, self._since = self._requested, None, 0.0
        return True
