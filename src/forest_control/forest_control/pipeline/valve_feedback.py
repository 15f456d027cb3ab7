"""What the valve driver reports, as the controller takes it: the valves' reach, and the last voltages.

From the voltages the controller also knows whether the driver is there, and does what it is told. While it is
not, the crane stands, but a reference would run ahead, and the crane after it, once the driver is back.
"""

import math
from typing import Any

from forest_control.valve.tracking_limit import FULL, Reach, reached
from forest_description.machine import Machine
from forest_description.types import ZERO, Vec3
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.unpacking import ArrayReader

WAYS = ("forward", "backward")
LEARNT = tuple(
    f"{joint}_{way}_{what}" for way in WAYS for joint in topics.JOINTS for what in ("deadband", "gain")
)
STATUS_TIMEOUT = 1.0  # [s] at which what was learnt is forgotten; it comes at 10 Hz
VOLTAGE_TIMEOUT = 0.1  # [s]
SILENT = 0.2  # [s] at which the driver is missed: by then the valves are shut, and the reference is ahead
DEAF = 1.5  # [s] of shut valves at which it counts as not obeying: links may be 0.6 s late, either way
HEARD = 0.5  # [V] of an ideal valve: what is commanded beyond is more than any hold zone, and opens the valve


class ValveReports:
    """The newest reports; what is older, or bad, says nothing: the valves are as the machine's file says.

    Args:
        clock: of the node, whose subscriptions and clock are used.
        machine: whose valves they are.
    """

    def __init__(self, clock: Any, machine: Machine) -> None:
        self._node_clock = clock
        self.status = clock.polled_subscription(topics.VALVE_DRIVER_STATUS, answered=True)
        self.volts = clock.polled_subscription(topics.VALVE_VOLTAGES, answered=True)
        self._status_reader = ArrayReader(topics.VALVE_DRIVER_STATUS, LEARNT)
        self._volts_reader = ArrayReader(topics.VALVE_VOLTAGES, topics.JOINTS)
        laws = [machine.valve_of(axis).law for axis in range(3)]
        self._edges = [law.forward for law in laws] + [law.backward for law in laws]
        self._reach, self._reach_received = FULL, -math.inf
        self._voltages, self._voltages_received = ZERO, -math.inf
        self._obeyed = -math.inf

    def read(self) -> tuple[Reach, Vec3]:
        """Return the valves' reach, and the voltages [V]."""
        now = self._node_clock.now()
        if status := self.status.newest():
            reading = self._status_reader.read(status.message, 0)
            if not reading.problem:
                self._reach, self._reach_received = self._reach_of(reading.values), status.time
        if volts := self.volts.newest():
            reading = self._volts_reader.read(volts.message, 0)
            if not reading.problem:
                self._voltages, self._voltages_received = reading.values, volts.time
        fresh = now - self._voltages_received <= VOLTAGE_TIMEOUT
        reach = self._reach if now - self._reach_received <= STATUS_TIMEOUT else FULL
        return reach, self._voltages if fresh else ZERO

    def objection(self, command: Vec3) -> str:
        """Return why a command [V] does not reach the valves, or "".

        Of a driver that has never spoken nothing is expected: it may be in shadow, or somebody else's.
        """
        now = self._node_clock.now()
        if self._voltages_received == -math.inf:
            return ""
        if now - self._voltages_received > SILENT:
            return "valve driver: no voltages"
        if self._voltages != ZERO or max(map(abs, command)) <= HEARD:
            self._obeyed = now
        return "valve driver: keeps the valves shut" if now - self._obeyed > DEAF else ""

    def _reach_of(self, learnt: tuple[float, ...]) -> Reach:
        """Return the reach for deadbands [V] and gains by `LEARNT`."""
        r = [reached(learnt[2 * k], learnt[2 * k + 1], edge) for k, edge in enumerate(self._edges)]
        return Reach((r[0], r[1], r[2]), (r[3], r[4], r[5]))
