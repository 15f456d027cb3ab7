"""What a process sets up before it touches ROS: the network it stays in, and the supervisor it belongs to.

Imports no ROS, so that a supervisor can have its nodes starting before it starts ROS itself.
"""

import atexit
import ctypes
import os
import signal
import socket
import tempfile
from collections.abc import Sequence
from pathlib import Path

PARENT_VARIABLE = "FOREST_PARENT"  # pid of the supervisor, in its nodes' environment
LOOPBACK_PROFILE = Path(__file__).resolve().parents[1] / "loopback.xml"
LOOPBACK = "<address>127.0.0.1</address>"  # in the profile: the interfaces that are used
# Between hosts packets are lost: readers are asked every 20 ms what they miss, and get it at once. On
# loopback next to nothing is lost, and fewer timers are better.
HEARTBEATS = "<heartbeatPeriod><sec>0</sec><nanosec>{}</nanosec></heartbeatPeriod>"
NETWORK_TIMES = (
    (HEARTBEATS.format(100000000), HEARTBEATS.format(20000000)),
    ("<nanosec>50000000</nanosec>", "<nanosec>0</nanosec>"),  # nackSupressionDuration
)
PROFILE_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
NETWORKS = "allowed: open, or addresses or names of other hosts, with commas between"
PR_SET_PDEATHSIG = 1  # of prctl(2)


class NoSupervisor(Exception):
    """The supervisor that started this process is gone, or called the start off."""


class NetworkError(OSError):
    """The network that FOREST_NETWORK asks for cannot be had; the message is one sentence for the user."""


def prepare_environment() -> None:
    """Keep every packet on this machine, unless FOREST_NETWORK says otherwise.

    Hosts, with commas between: these are sought, too, and no one is called who is not named. Packets leave
    by the interfaces that lead to them. `open`: ROS 2's usual variables decide.

    Raises:
        NetworkError: a host is unknown, is this one, or cannot be reached.
    """
    chosen = os.environ.get("FOREST_NETWORK", "")
    if chosen == "open":
        return
    peers = [_address(name.strip()) for name in chosen.split(",")] if chosen else []
    if peers or os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") != "OFF":
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"  # set: a sourced ROS sets it, too
    if peers:
        os.environ["ROS_STATIC_PEERS"] = ";".join(peers)
    if os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp") != "rmw_fastrtps_cpp":
        return
    if PROFILE_VARIABLE not in os.environ:
        os.environ[PROFILE_VARIABLE] = str(_profile_for(peers) if peers else LOOPBACK_PROFILE)


def _address(name: str) -> str:
    """Return the IPv4 address of a host."""
    try:
        return str(socket.getaddrinfo(name, 0, socket.AF_INET, socket.SOCK_DGRAM)[0][4][0])
    except (OSError, UnicodeError) as error:
        raise NetworkError(f"FOREST_NETWORK: {name!r} is no host that is known here; {NETWORKS}") from error


def _profile_for(peers: Sequence[str]) -> Path:
    """Write the profile that has the interfaces towards some hosts beside loopback; it ends with us."""
    ours = dict.fromkeys(map(_our_address, peers))
    text = LOOPBACK_PROFILE.read_text(encoding="utf-8")
    interfaces = "".join(f"<address>{address}</address>" for address in ours)
    number, name = tempfile.mkstemp(prefix="forest-network-", suffix=".xml")
    for local, between in ((LOOPBACK, LOOPBACK + interfaces), *NETWORK_TIMES):
        text = text.replace(local, between)
    with os.fdopen(number, "w", encoding="utf-8") as file:
        file.write(text)
    atexit.register(Path(name).unlink, missing_ok=True)
    return Path(name)


def _our_address(peer: str) -> str:
    """Return our address on the way to a host. The socket is never written to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as way:
        try:
            way.connect((peer, 9))
        except OSError as error:
            raise NetworkError(
                f"FOREST_NETWORK: no way leads to {peer}: {error.strerror}; {NETWORKS}"
            ) from error
        ours = str(way.getsockname()[0])
    if ours == peer or ours.startswith("127."):
        raise NetworkError(f"FOREST_NETWORK: {peer} is this host; {NETWORKS}")
    return ours


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
