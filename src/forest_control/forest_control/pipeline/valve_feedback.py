"""What the valve driver reports to the controller: how far the valves open, and the last voltages."""

import math
from typing import Any

from forest_control.pipeline.control_state import ValveFeedback
from forest_control.safety.driver_response import DriverSample
from forest_control.valve.tracking_limit import FULL, OpeningRatio, opening_ratio
from forest_description.machine import Machine
from forest_description.types import ZERO
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.unpacking import ArrayReader

WAYS = ("forward", "backward")
LEARNT = tuple(
    f"{joint}_{way}_{what}" for way in WAYS for joint in topics.JOINTS for what in ("deadband", "gain")
)
STATUS_TIMEOUT = 1.0  # [s] at which what was learnt is forgotten; it comes at 10 Hz
VOLTAGE_TIMEOUT = 0.1  # [s] at which voltages count as none: as the driver's command_timeout


class ValveReports:
    """The newest reports; what is older, or bad, says nothing: the valves are as the machine's file says.

    Args:
        node_clock: of the node, whose subscriptions and clock are used.
        machine: whose valves they are.
    """

    def __init__(self, node_clock: Any, machine: Machine) -> None:
        self._node_clock = node_clock
        self.status = node_clock.polled_subscription(topics.VALVE_DRIVER_STATUS, answered=True)
        self.volts = node_clock.polled_subscription(topics.VALVE_VOLTAGES, answered=True)
        self._status_reader = ArrayReader(topics.VALVE_DRIVER_STATUS, LEARNT)
        self._volts_reader = ArrayReader(topics.VALVE_VOLTAGES, topics.JOINTS)
        laws = [machine.valve_of(axis).law for axis in range(3)]
        self._edges = [law.forward for law in laws] + [law.backward for law in laws]
        self._ratio, self._ratio_received = FULL, -math.inf
        self._driver = DriverSample()

    def read(self) -> ValveFeedback:
        """Return the reports by now."""
        now = self._node_clock.now()
        if status := self.status.newest():
            reading = self._status_reader.read(status.message, 0)
            if not reading.problem:
                self._ratio, self._ratio_received = self._ratio_of(reading.values), status.time
        if volts := self.volts.newest():
            reading = self._volts_reader.read(volts.message, 0)
            if not reading.problem:
                self._driver = DriverSample(reading.values, volts.time)
        fresh = now - self._driver.received <= VOLTAGE_TIMEOUT
        ratio = self._ratio if now - self._ratio_received <= STATUS_TIMEOUT else FULL
        return ValveFeedback(ratio, self._driver.voltages if fresh else ZERO, self._driver)

    def _ratio_of(self, learnt: tuple[float, ...]) -> OpeningRatio:
        """Return the opening ratios for deadbands [V] and gains by `LEARNT`."""
        r = [opening_ratio(learnt[2 * k], learnt[2 * k + 1], edge) for k, edge in enumerate(self._edges)]
        return OpeningRatio((r[0], r[1], r[2]), (r[3], r[4], r[5]))
