"""A guard with joystick, machine and driver that speak every 5 ms; what they say can be changed."""

import math

from forest_control.config.controller_settings import Settings, parameters
from forest_control.operator.joystick_watch import NO_HEARTBEAT, NO_STAMP, Sample, unreadable_sample
from forest_control.operator.levers import REST, Levers
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_guard import MotionGuard
from forest_control.safety.motion_permission import NOBODY, MachineState, PermissionParameters, Verdict
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD

P = parameters(load_machine("c180_hoses"), Settings())
ANGLES, PUSHED, COMMAND = (0.2, 0.4, -1.5), Levers(0.5, 0.0, 0.0), (3.0, 0.0, 0.0)
PERIOD_NS = 5_000_000


class Rig:
    """The guard and its world."""

    def __init__(self):
        self.guard, self.step, self.lag = MotionGuard(PermissionParameters()), 20_000, 0.0
        self.levers, self.held, self.angles, self.problem = REST, True, ANGLES, ""
        self.stamp = lambda k: k * PERIOD_NS
        self.shakes, self.driver_speaks, self.override = True, True, NOBODY
        self.volts, self.command, self.rates = (3.0, 0.0, 0.0), COMMAND, (0.6, 0.0, 0.0)
        self.speak = self.sample
        self.heard = -math.inf

    @property
    def now(self):
        return self.step * PERIOD

    def sample(self):
        return Sample(self.now, self.step * PERIOD_NS, NO_HEARTBEAT, False, True, self.levers, self.held)

    def once(self):
        """Return the decision on the next period."""
        self.step += 1
        sample = self.speak()
        if sample is not None:
            self.guard.hear(sample, "" if sample.good else "joy: nonsense")
        angles = tuple(angle + 1e-9 * self.shakes * (self.step % 2) for angle in self.angles)
        stamp, received = self.stamp(self.step), self.now - self.lag
        machine = MachineState(angles, self.rates, stamp, received, not self.problem)
        self.heard = self.now if self.driver_speaks else self.heard
        driver = DriverSample(self.volts, self.heard)
        return self.guard.decide(machine, driver, self.command, P, self.now, self.override, self.problem)

    def until(self, verdict, most):
        """Return the first decision of a verdict, and after how long [s] it came."""
        for k in range(round(most / PERIOD) + 2):
            decision = self.once()
            if decision.verdict == verdict:
                return decision, k * PERIOD
        raise AssertionError(f"no {verdict.name} within {most} s")

    def moving(self):
        """Arm with centred levers, and push one."""
        for _ in range(3):
            self.once()
        self.levers = PUSHED
        assert self.once().verdict == Verdict.MOVE
        return self


def nonsense(rig):
    rig.speak = lambda: unreadable_sample(rig.now)


def hangs(rig):
    rig.speak = lambda: rig.sample()._replace(same=True, stamp=NO_STAMP)
