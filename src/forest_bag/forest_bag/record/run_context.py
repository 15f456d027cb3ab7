"""What a bag says of the run beside its messages, so that the bag alone can make the run again.

=====================  =====================================================================================
in the bag             what
=====================  =====================================================================================
parameters/NODE.yaml   attachment for each node: all its parameters, as `--params-file` takes them
machine/FILE.yaml      attachment: the machine file that a parameter `machine` names, and those it is based on
forest_versions        metadata: of Python, ROS and the packages that compute
forest_seeds           metadata: parameter `seed` of each node that has one
=====================  =====================================================================================
"""

import os
import platform
import subprocess
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import yaml

from forest_bag.write.bag_writer import Attached
from forest_description.config.source_tree import texts
from forest_description.machine import MachineError

YAML = "application/yaml"
PACKAGES = (
    *("forest-crane", "numpy", "scipy", "numba", "llvmlite", "mcap"),
    *("ros-jazzy-rclpy", "ros-jazzy-rmw-fastrtps-cpp"),
)
ROS_VARIABLES = ("ROS_DISTRO", "RMW_IMPLEMENTATION", "ROS_DOMAIN_ID")


def versions() -> dict[str, str]:
    """Return the versions of what computes and records here."""
    known = {"python": platform.python_version(), "platform": f"{platform.system()} {platform.machine()}"}
    installed = {found.name: found.version for found in metadata.distributions()}
    known.update({package: installed[package] for package in PACKAGES if package in installed})
    known.update({name: os.environ[name] for name in ROS_VARIABLES if name in os.environ})
    revision = _revision(Path(__file__).resolve().parent)
    return known | ({"revision": revision} if revision else {})


def _revision(folder: Path) -> str:
    """Commit of the checkout that this code runs from; "" where it is installed."""
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--abbrev=40"]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=2, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""


class RunContext:
    """Collects what nodes tell of themselves, and puts it into the bag.

    Args:
        attach: takes a file for the bag.
        note: takes a metadata record for the bag.
        complain: takes a sentence about what could not be had.
    """

    def __init__(
        self,
        attach: Callable[[Attached], None],
        note: Callable[[str, dict[str, str]], None],
        complain: Callable[[str], object],
    ) -> None:
        self._attach, self._note, self._complain = attach, note, complain
        self._machines: set[str] = set()
        self._seeds: dict[str, str] = {}

    def node(self, name: str, parameters: Mapping[str, Any], time_ns: int) -> None:
        """Take in the parameters of a node (resolved name).

        Raises:
            OSError: the disk is full.
        """
        text = yaml.safe_dump({name: {"ros__parameters": dict(parameters)}}, sort_keys=True)
        self._attach(Attached(f"parameters{name}.yaml", YAML, text.encode(), time_ns))
        if "seed" in parameters:
            self._seeds[name] = str(parameters["seed"])
            self._note("forest_seeds", dict(self._seeds))
        machine = parameters.get("machine")
        if isinstance(machine, str) and machine and machine not in self._machines:
            self._machines.add(machine)
            self._machine(machine, time_ns)

    def _machine(self, machine: str, time_ns: int) -> None:
        try:
            files = texts(machine)
        except MachineError as error:
            self._complain(f"the machine file is not in the bag: {error}")
            return
        for label, text in files:
            self._attach(Attached(f"machine/{Path(label).name}", YAML, text.encode(), time_ns))
