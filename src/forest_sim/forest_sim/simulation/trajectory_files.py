"""A run on disk, written as it goes: a CSV for spreadsheets, and a bag as the graph's recorder makes.

Stamps are simulated time from zero, and so are log times: the same run gives the same bytes.
"""

import contextlib
from pathlib import Path
from typing import Any

import numpy as np

from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter
from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import (
    GROUND_TRUTH_LOAD,
    GROUND_TRUTH_TIP_POSE,
    ROBOT_DESCRIPTION,
    Topic,
    message_class,
)
from forest_msgs_py.serialization.batch_encoder import Encoder
from forest_msgs_py.serialization.cdr import to_cdr
from forest_sim.simulation.energy_account import Account, account
from forest_sim.simulation.open_loop import Block
from forest_sim.simulation.sensor_log import LOGGED_TOPICS, TopicTables
from forest_sim.solver.integrator import Events
from forest_sim.solver.state_recording import STATE

Rows = dict[Any, Floats]  # by topic or name, each [N, ...]

FRAME = "base_link"
CHUNK_BYTES = 4 * 1024 * 1024  # 10 000 entries in the bag's index after a day at 200 Hz
UNITS = {  # by a word of the name; the first that is in it
    "rate": "rad/s",
    "angle": "rad",
    "alpha": "rad",
    "beta": "rad",
    "position": "V",
    "pressure": "Pa",
    "reference": "Pa",
    "flow": "m3/s",
    "stroke": "1",
    "speed": "rad/s",
}
LEFT_OUT = (
    "spool_rate",
    "spool_target",
    "acceleration",
    "lift_one",
    "lift_two",
    "lift_compensator",
    "lift_felt",
    "jets_force",
    "jets_push",
    "tank_seen",
    "tank_owed",
)
COLUMNS = tuple(
    name
    for name in STATE
    if name not in Events._fields and not name.endswith(LEFT_OUT) and not name.startswith("command_")
)
_PLACES = [STATE.index(name) for name in COLUMNS]


def csv_header() -> str:
    """Return the columns of `trajectory.csv`, units in brackets; powers are means over the row's period."""
    volts = [f"{axis}_voltage[V]" for axis in AXES]
    states = [f"{name}[{_unit(name)}]" for name in COLUMNS]
    powers = [f"{entry}_power[W]" for entry in Account._fields]
    return ",".join(["time[s]", *volts, *(f"tip_{c}[m]" for c in "xyz"), *states, *powers])


def _unit(name: str) -> str:
    return next(unit for word, unit in UNITS.items() if word in name.split("_"))


class TrajectoryFiles:
    """`trajectory.csv` and the bag `trajectory` in a directory."""

    def __init__(self, directory: Path, machine: Machine, rate: float, loads: bool = False) -> None:
        """Begin both files.

        Args:
            directory: where they are.
            machine: that runs.
            rate: of the rows [Hz].
            loads: its head grasps or drops logs, which the bag tells.
        """
        self._rate = rate
        self._topics = (*LOGGED_TOPICS, GROUND_TRUTH_LOAD) if loads else LOGGED_TOPICS
        self._sequence = 0
        self.bag = directory / "trajectory"
        self.csv = directory / "trajectory.csv"
        self._csv = self.csv.open("w", encoding="utf-8", newline="\n")
        self._csv.write(csv_header() + "\n")
        self._writer = BagWriter(self.bag, Layout(chunk_bytes=CHUNK_BYTES))
        self._encoders = {topic: Encoder(topic, FRAME) for topic in self._topics}
        for topic in (ROBOT_DESCRIPTION, *self._topics):
            self._writer.add_topic(_resolved(topic), topic.type, [offered_qos(topic)], "")
        text = to_cdr(message_class(ROBOT_DESCRIPTION)(data=robot_description(machine)))
        self._writer.write(_resolved(ROBOT_DESCRIPTION), text, 0, 0, 1)

    def write(self, block: Block, observed: TopicTables) -> None:
        """Append a block.

        Raises:
            OSError: the disk is full, or a file cannot be written.
        """
        self._write_csv(block, observed[GROUND_TRUTH_TIP_POSE][:, :3])
        stamps = np.round(block.time * 1e9).astype(np.int64)
        encoded = [(_resolved(t), self._encoders[t].encode(stamps, observed[t])) for t in self._topics]
        for row, stamp in enumerate(stamps.tolist()):
            self._sequence += 1
            for name, messages in encoded:
                message = messages[row]
                if message is not None:
                    self._writer.write(name, message, stamp, stamp, self._sequence)

    def _write_csv(self, block: Block, tip: Floats) -> None:
        powers = np.column_stack(account(block.energies)) * self._rate
        table = np.column_stack([block.time, block.voltages, tip, block.states[:, _PLACES], powers])
        self._csv.writelines(",".join(f"{value:.9g}" for value in row) + "\n" for row in table.tolist())

    def close(self) -> None:
        """Finish both files."""
        with contextlib.closing(self._csv):
            self._writer.close()


class DecimatedRows:
    """A run small enough for pictures: all rows of a short one, every 2nd, 4th, 8th … of a long one."""

    LIMIT = 20_000  # rows

    def __init__(self) -> None:
        self._kept: list[Rows] = []
        self._every, self._rows, self._seen = 1, 0, 0

    def add(self, rows: Rows) -> None:
        """Keep what is due of some rows [N, ...]."""
        count = len(next(iter(rows.values())))
        first = -self._seen % self._every
        self._seen += count
        if first >= count:
            return
        # Copies: a slice would keep the whole block that it is a view of.
        self._keep({name: values[first :: self._every].copy() for name, values in rows.items()})
        if self._rows > self.LIMIT:
            kept = self.columns()
            self._kept, self._rows, self._every = [], 0, 2 * self._every
            self._keep({name: values[::2].copy() for name, values in kept.items()})

    def _keep(self, rows: Rows) -> None:
        self._kept.append(rows)
        self._rows += len(next(iter(rows.values())))

    def columns(self) -> Rows:
        """Return what was kept."""
        return {name: np.concatenate([rows[name] for rows in self._kept]) for name in self._kept[0]}


def _resolved(topic: Topic) -> str:
    return f"/{topic.name}"
