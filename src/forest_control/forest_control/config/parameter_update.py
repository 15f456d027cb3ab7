"""When parameters that were set while the crane moves take effect: one change fades before the next begins.

A change keeps the command where it was and lets the difference fade (`handover`). Changes that come faster
than that, from a slider that is dragged or a script that has gone mad, would hold the command up again and
again, so that levers and servos hardly get through, and rock the crane. So they wait, and the newest counts.
"""

from forest_control.config.settings import Parameters

SETTLED = 1.0  # [s] hand-overs fade in 0.2 s, the rocking of a swing in 1 s


class Retuning:
    """The parameters in force.

    Args:
        core: in force from the beginning.
    """

    def __init__(self, core: Parameters) -> None:
        self.core = core
        self._wanted: Parameters | None = None
        self._since = SETTLED  # [s] since the last change

    def want(self, core: Parameters) -> None:
        """Note the parameters that shall be in force; what was noted before is forgotten."""
        self._wanted = core

    def changes(self, resting: bool, dt: float) -> bool:
        """Put what is wanted in force, if it is time; tell whether it was.

        Args:
            resting: nothing is commanded.
            dt: since the last time [s].
        """
        self._since += dt
        if self._wanted is None or not (resting or self._since >= SETTLED):
            return False
        self.core, self._wanted, self._since = self._wanted, None, 0.0
        return True
