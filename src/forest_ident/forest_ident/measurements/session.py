"""A recorded session for the estimators: readings on one time base, voltages, metadata.

A session comes from a bag (`session_bag`) or from a simulated experiment (`simulated_experiment`), and is the
same to the estimators. Ground truth is in neither.

| array | shape | unit |
|---|---|---|
| time | N, rising in equal steps | s |
| voltages | N, 3 (swing, boom, stick), each row holds until the next | V |
| a reading | N, by channel of `sensor_suite.CHANNELS`; absent sensors are absent | the channel's |
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from forest_description.types import AXES, Floats

RIGS = ("valve", "spool", "compensator", "hose")
"""Kinds of experiments that are driven on a test rig instead of the crane."""
THERMOCOUPLES = ("tank_temperature", "pump_temperature", "motor_temperature")


class SessionError(ValueError):
    """A session does not hold what is asked of it; the message says what is missing."""


@dataclass(frozen=True)
class Session:
    """One experiment, or any other record of the machine."""

    name: str
    """Of the experiment (`experiment_plan.names`); "motion" for any other record."""
    time: Floats
    voltages: Floats
    readings: Mapping[str, Floats]
    metadata: Mapping[str, float] = field(default_factory=dict)
    """Facts that no sensor measures: set or read by hand, SI."""
    whole: bool = True
    """False: its recorder was killed, or the file was cut off; this is the part that is left."""

    @property
    def period(self) -> float:
        """Time between two rows [s]."""
        return float(np.median(np.diff(self.time)))

    @property
    def kind(self) -> str:
        """First word of the experiment's name: "damping" of "damping_boom"."""
        return self.name.partition("_")[0]

    @property
    def own_axis(self) -> str:
        """Axis that the experiment's name ends with; "" for an experiment that names none."""
        tail = self.name.partition("_")[2]
        return tail if tail in AXES else ""

    @property
    def on_rig(self) -> bool:
        """Whether it was recorded on a test rig."""
        return self.kind in RIGS

    @property
    def on_crane(self) -> bool:
        """Whether it was recorded on the crane: neither on a rig, nor a calibration."""
        return self.kind not in (*RIGS, "calibration")

    @property
    def is_exact(self) -> bool:
        """Whether a simulator's exact sensors made it."""
        return self.metadata.get("exact_sensors", 0.0) > 0.0

    def has(self, *channels: str) -> bool:
        """Tell whether all of these channels were there, with samples throughout."""
        return all(name in self.readings and np.isfinite(self.readings[name]).all() for name in channels)

    def column(self, channel: str) -> Floats:
        """Return a channel's readings.

        Raises:
            SessionError: it was not recorded; the message names those that were.
        """
        if channel not in self.readings:
            known = ", ".join(sorted(self.readings))
            raise SessionError(f"{self.name}: no channel {channel}; the record holds {known}")
        return self.readings[channel]

    def pressures(self, axis: str, place: str) -> tuple[Floats, Floats]:
        """Return the pressures [Pa] at ports 1 and 2 of an axis; place: "valve" or "actuator".

        Raises:
            SessionError: one was not recorded.
        """
        one, two = (self.column(f"{axis}_pressure_{port}_{place}") for port in (1, 2))
        return one, two

    def part(self, first: int, last: int) -> Session:
        """Return the rows from ``first`` to before ``last``."""
        rows = slice(first, last)
        readings = {name: column[rows] for name, column in self.readings.items()}
        return replace(self, time=self.time[rows], voltages=self.voltages[rows], readings=readings)

    def temperature(self) -> Floats | None:
        """Return the oil's temperature [K], the mean of its thermocouples; None if there are none."""
        columns = [self.readings[name] for name in THERMOCOUPLES if self.has(name)]
        return np.asarray(np.mean(columns, axis=0), dtype=np.float64) if columns else None
