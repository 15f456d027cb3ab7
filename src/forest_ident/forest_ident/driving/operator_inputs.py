"""Inputs of the scripted operator: the sample on which it steps, and the newest of the other topics."""

import math
from collections.abc import Callable
from typing import Any

from forest_description.types import ZERO, Vec3
from forest_ident.driving.safety_monitor import Readings, monitored_ports
from forest_ident.experiments.experiment_plan import Plan
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader

NOTHING = math.nan

OnSample = Callable[[int, float, str, Vec3], None]  # stamp [ns], sent [s], problem, angles [rad]


class Inputs:
    """Joints, pressures at the monitored ports and of the supply, and the oil's temperature.

    Args:
        node_clock: of the node.
        plan: of the experiment; a rig is stepped by its pressures, a crane by its joints.
        on_sample: called with each sample on which the operator steps.
    """

    def __init__(self, node_clock: Any, plan: Plan, on_sample: OnSample) -> None:
        self._on_sample, self._joints = on_sample, JointReader(topics.JOINTS)
        self.ports = monitored_ports(plan)
        self._ports = ArrayReader(topics.PRESSURES, self.ports) if self.ports else None
        polled = node_clock.polled_subscription
        self._subscription = polled(topics.PRESSURES) if self.ports and not plan.bench else None
        labels = {topics.SUPPLY: "pressure", topics.AUXILIARY: "tank_temperature"}
        if node_clock.lockstep:  # the topics' table has no reader of it to wait for
            del labels[topics.AUXILIARY]
        self._slow = [(polled(topic), ArrayReader(topic, (label,))) for topic, label in labels.items()]
        self._values = [NOTHING, NOTHING]
        self._pressures: tuple[float, ...] = ()
        self._received = -math.inf
        self._crane: Any = None  # joints of the crane whose valve is on the rig
        if plan.bench:
            self._crane = None if node_clock.lockstep else polled(topics.JOINT_STATES)
            node_clock.on(topics.PRESSURES, self._on_pressures)
        else:
            node_clock.on(topics.JOINT_STATES, self._on_joints)

    def _on_joints(self, data: bytes, sent: float) -> None:
        reading = self._joints.read(data)
        self._on_sample(reading.stamp_ns, sent, reading.problem, reading.values.position)

    def _on_pressures(self, data: bytes, sent: float) -> None:
        stamp, problem = self._read_pressures(data, sent)
        self._on_sample(stamp, sent, problem, ZERO)

    def _read_pressures(self, data: bytes, sent: float) -> tuple[int, str]:
        """Read the monitored pressures; return their stamp [ns], and what is wrong with them."""
        if self._ports is None:
            return 0, f"the machine has no transducers; allowed: one with {topics.PRESSURES.name}"
        reading = self._ports.read(data, 0)
        if not reading.problem:
            self._pressures, self._received = reading.values, sent
        return reading.stamp_ns, reading.problem

    def crane_angles(self) -> Vec3 | None:
        """Return the newest angles [rad] of the crane beside a rig; None if nothing good arrived."""
        arrival = self._crane.newest() if self._crane is not None else None
        if arrival is None or (reading := self._joints.read(arrival.message)).problem:
            return None
        angles: Vec3 = reading.values.position
        return angles

    def read(self, angles: Vec3) -> Readings:
        """Return the newest readings together with the joints' angles [rad]."""
        if self._subscription is not None and (arrival := self._subscription.newest()):
            self._read_pressures(arrival.message, arrival.time)
        for place, (subscription, reader) in enumerate(self._slow):
            if arrival := subscription.newest():
                reading = reader.read(arrival.message, 0)
                self._values[place] = NOTHING if reading.problem else reading.values[0]
        return Readings(angles, self._pressures, *self._values)

    def overdue(self, now: float, timeout: float) -> str:
        """Return the complaint about pressures that have not come for a time [s]; "" if they have."""
        late = self.ports and now - self._received > timeout
        return f"nothing good on {topics.PRESSURES.name} for {timeout:g} s" if late else ""
