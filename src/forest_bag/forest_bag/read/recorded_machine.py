"""The machine of a bag: a recorder attaches the file that a node named, and those that it is based on."""

import re
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from forest_bag.read.bag_reader import BagReader
from forest_description.config.parameter import MachineError
from forest_description.machine import Machine, load_machine
from forest_description.urdf.robot_description import robot_description

NAME = re.compile(r"machine/([\w.-]{1,100}\.yaml)", re.ASCII)  # of an attachment; a path is none


def recorded_machine(readers: Sequence[BagReader], urdf: str) -> Machine | None:
    """Return the machine that bags hold the file of, and that a robot description is of; None: none is."""
    with TemporaryDirectory() as folder:
        paths = []
        for attached in (a for reader in readers for file in reader.files for a in file.attachments):
            if name := NAME.fullmatch(attached.name):
                paths.append(Path(folder, name[1]))
                paths[-1].write_bytes(attached.data)
        return next((machine for machine in map(_loaded, paths) if _described(machine) == urdf), None)


def _loaded(path: Path) -> Machine | None:
    """Return a file's machine; None: another release wrote it, or nobody."""
    try:
        return load_machine(path)
    except MachineError:
        return None


def _described(machine: Machine | None) -> str:
    return robot_description(machine) if machine else ""
