"""What a process sets up before it touches ROS: the network it stays in, and the supervisor it belongs to.

Imports no ROS, so that a supervisor can have its nodes starting before it starts ROS itself.
"""

import ctypes
import os
import signal
from pathlib import Path

PARENT_VARIABLE = "FOREST_PARENT"  # pid of the supervisor, in its nodes' environment
LOOPBACK_PROFILE = Path(__file__).resolve().parents[1] / "loopback.xml"
PR_SET_PDEATHSIG = 1  # of prctl(2)


class NoSupervisor(Exception):
    """The supervisor that started this process is gone, or called the start off."""


def prepare_environment() -> None:
    """Keep every packet on this machine, unless the user chose otherwise (FOREST_NETWORK=open)."""
    if os.environ.get("FOREST_NETWORK") == "open":
        return
    if (
        os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") != "OFF"
    ):  # else set, not defaulted: a sourced ROS sets it, too
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    if os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp") == "rmw_fastrtps_cpp":
        os.environ.setdefault("FASTRTPS_DEFAULT_PROFILES_FILE", str(LOOPBACK_PROFILE))


def wait_for_supervisor() -> None:
    """Hold a supervised process until it is told to go on, and let it end when its supervisor does.

    The supervisor has its nodes load while it looks whether another graph is running; a byte on standard
    input says go. The kernel sends SIGTERM when the supervisor is gone, however it ended. A process without
    one does not wait.

    Raises:
        NoSupervisor: it is gone already.
    """
    parent = os.environ.pop(PARENT_VARIABLE, "")
    if not parent:
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGTERM))
    if os.getppid() != int(parent) or not os.read(0, 1):
        raise NoSupervisor("the supervisor that started this node is gone")
