"""The course of an experiment: from the first sample to the end, with every reason to stop.

The node passes in readings and times; what decides is here. Pure but for its own state.
"""

from forest_description.types import AXES, ZERO, Vec3
from forest_ident.driving import safety_monitor
from forest_ident.driving.safety_monitor import Readings
from forest_ident.experiments import excitation
from forest_ident.experiments.experiment_plan import Plan
from forest_msgs_py.runtime import stamp_order, stamped_period
from forest_msgs_py.types import PERIOD

START_LIMIT = 15.0  # [s] until which driver, listeners and the machine's state must be there
STILL = 0.02  # [rad] by which a joint of the crane may move while its valve is on a rig
PROGRESS = "operator at"  # begins a line on standard output for each second: of so many


class ScriptedOperator:
    """Drive an experiment's programme within its bounds.

    Args:
        plan: of the experiment.
        timeout: age at which the machine's state is lost [s].
        now: local time at the node's start [s].
    """

    def __init__(self, plan: Plan, timeout: float, now: float) -> None:
        self._plan, self._programme, self._timeout = plan, plan.programme, timeout
        self._bounds = safety_monitor.bounds(plan, plan.programme)
        self._excitation, self._monitor = excitation.START, safety_monitor.State()
        self._created = self._received = now
        self._period, self._order, self._dt = stamped_period.BEGIN, stamp_order.FIRST, PERIOD
        self._at_rest: Vec3 | None = None
        self._second, self._volts = -1, ZERO
        self.begun = False

    @property
    def finished(self) -> bool:
        """Whether the programme is at its end."""
        return self._excitation.time > self._programme.duration - 1e-9

    def accepts(self, stamp: int, sent: float, problem: str) -> bool:
        """Tell whether a sample of the machine's state is good and in order.

        Args:
            stamp: of the sample [ns].
            sent: local time at which it was sent [s].
            problem: what is wrong with its values; "" if nothing.
        """
        if problem:
            return False
        order, self._order = self._order, stamp_order.updated_order(self._order, stamp, sent, self._timeout)
        if not stamp_order.is_in_order(order, stamp):
            return False
        self._received = sent
        self._period, self._dt = stamped_period.clipped_period(self._period, stamp, PERIOD)
        return True

    def begin(self) -> None:
        """Begin with the programme as it is planned."""
        self.begun = True

    def begin_around(self, swing: float) -> None:
        """Begin with the swing going to and fro about where it stands [rad]."""
        self._programme = safety_monitor.around(self._programme, self._plan, swing)
        self._bounds = safety_monitor.bounds(self._plan, self._programme)
        self.begun = True

    def step(self, readings: Readings, crane: Vec3 | None = None) -> tuple[Vec3, str]:
        """Return the voltages [V] over the next period, and why the experiment must stop; "" if not.

        Args:
            readings: with the accepted sample.
            crane: joint angles [rad] of the crane beside a rig, where they are published.
        """
        if crane is not None and (moved := self._moved(crane)):
            return ZERO, moved
        self._monitor, reason = safety_monitor.step(
            self._monitor, readings, self._bounds, self._dt, self._volts
        )
        angles, programme = readings.angles, self._programme
        self._excitation, volts = excitation.step(self._excitation, angles, programme, self._dt)
        self._volts = ZERO if reason else volts
        return self._volts, reason

    def _moved(self, angles: Vec3) -> str:
        """Return which joint [rad] of the crane moves while valve or hose are on a rig; "" if none."""
        self._at_rest = self._at_rest or angles
        for name, angle, rest in zip(AXES, angles, self._at_rest, strict=True):
            if abs(angle - rest) > STILL:
                return f"the {name} moves: valve or hose are still on the crane, not on the rig"
        return ""

    def progress(self) -> str:
        """Return a line for each second of the experiment; "" within the second."""
        second = int(self._excitation.time)
        if second <= self._second:
            return ""
        self._second = second
        return f"{PROGRESS} {second} of {self._programme.duration:g} s"

    def overdue(self, now: float, needed: str) -> str:
        """Return why the experiment cannot begin or go on at a time [s]; "" if it can; needed: to begin."""
        if not self.begun and now - self._created > START_LIMIT:
            return f"not everything was there within {START_LIMIT:g} s: {needed}"
        if self.begun and now - self._received > self._timeout:
            return f"nothing good of the machine's state for {self._timeout:g} s"
        return ""
