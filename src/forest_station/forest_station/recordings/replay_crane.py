"""The crane of a bag: what it looks like, and where its passive joints are.

A recorded robot description tells what the crane looks like. Cylinders it tells only about, so their
joints are computed where the description is that of a machine whose file is in the bag, or is shipped.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.recorded_machine import recorded_machine
from forest_description.config.source_tree import shipped_machines
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES
from forest_description.urdf.robot_description import robot_description
from forest_station.scene.crane_signals import CRANE_JOINTS, crane_signals, signal_of
from forest_station.scene.scene_description import scene_from_urdf, scene_of
from forest_station.scene.scene_elements import Scene

NO_CRANE = (ValueError, LookupError, ArithmeticError, TypeError)  # what is raised over a text of anybody's


class RecordedCrane(NamedTuple):
    """What is known of a bag's crane."""

    machine: Machine | None = None  # None: nobody here knows it
    scene: Scene | None = None  # None: it looks as the station's own does
    note: str = ""  # why it is not drawn as recorded

    @property
    def signals(self) -> dict[str, str]:
        """Names and units of the passive joints' signals."""
        joints = () if self.machine is None else CRANE_JOINTS
        return {signal_of(name): "m" if name.endswith("_rod") else "rad" for name in joints}

    def positions(self, angles: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Return the signals, N by k, at some angles of swing, boom and stick, 3 by N [rad]."""
        assert self.machine is not None
        rows = np.column_stack(angles).tolist()
        found = [crane_signals(self.machine, dict(zip(AXES, row, strict=True))) for row in rows]
        return np.array([list(row.values()) for row in found]).reshape(len(rows), len(self.signals))


def recorded_crane(bag: BagReader, urdf: str, own: Machine) -> RecordedCrane:
    """Return the crane of a bag.

    Args:
        bag: that may hold the machine's file.
        urdf: robot description from the bag; "" where there is none.
        own: machine of the station.
    """
    if not urdf or urdf == robot_description(own):
        return RecordedCrane(own)
    for machine in (recorded_machine([bag], urdf), *map(load_machine, shipped_machines())):
        if machine and robot_description(machine) == urdf:
            return RecordedCrane(machine, scene_of(machine))
    try:
        return RecordedCrane(scene=scene_from_urdf(urdf))
    except NO_CRANE as error:
        return RecordedCrane(own, note=f"the recorded crane cannot be drawn: {error}")
