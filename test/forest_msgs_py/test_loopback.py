"""The shipped profile lets in everyone on this machine, and keeps out every stranger and every packet in.

The stranger is a second network namespace at the other end of a virtual cable, who names us as a static peer.
Without the profile it does get in (LOCALHOST alone is no barrier), which shows that the test could fail.
"""

import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
from collections import Counter
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

HELPERS = Path(__file__).parents[1] / "helpers"
OURS, THEIRS = "10.77.0.1", "10.77.0.2"
LISTEN_S = 4
STRANGERS = 4  # at once: the few first announcements of one do not always meet somebody
ATTEMPTS = 4  # of theirs to get in where they can
# Another machine shares no memory with ours; ``ip netns exec`` gives it mounts of its own.
OWN_MEMORY = 'mount -t tmpfs none /dev/shm && exec "$@"'
UDP_IN_IPV4 = (b"\x08\x00", 17)


def _can_make_namespaces() -> str:
    """Empty if this process may make network namespaces, else why not."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        return "needs root and the ip command to make network namespaces"
    name = f"forest-probe-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True, check=False)
    if made.returncode == 0:
        subprocess.run(["ip", "netns", "del", name], check=True)
    return made.stderr.strip()


@pytest.fixture
def cable():
    """Two namespaces and a virtual cable between them: (ours, theirs, our interface)."""
    reason = _can_make_namespaces()
    if reason:
        pytest.skip(reason)
    ours, theirs = f"forest-a-{os.getpid()}", f"forest-b-{os.getpid()}"

    def ip(*words):
        subprocess.run(["ip", *words], check=True)

    for name in (ours, theirs):
        ip("netns", "add", name)
    try:
        ip("link", "add", "veth0", "netns", ours, "type", "veth", "peer", "name", "veth0", "netns", theirs)
        for name, address in ((ours, OURS), (theirs, THEIRS)):
            ip("-n", name, "addr", "add", f"{address}/24", "dev", "veth0")
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "link", "set", "veth0", "up")
        yield ours, theirs
    finally:
        for name in (ours, theirs):
            ip("netns", "del", name)


def sniff() -> None:
    """Print the UDP packets on veth0 of this network namespace by source address, until told to stop."""
    told = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: told.set())
    packets = Counter()
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x0003)) as wire:
        wire.bind(("veth0", 0))
        wire.settimeout(0.1)
        print("listening", flush=True)
        while not told.is_set():
            try:
                frame = wire.recv(2000)
            except TimeoutError:
                continue
            if (frame[12:14], frame[23]) == UDP_IN_IPV4:
                packets[socket.inet_ntoa(frame[26:30])] += 1
    print(dict(packets))


def _profile(closed: bool) -> dict[str, str]:
    environment = dict(os.environ)
    if not closed:  # a profile of the user's own choice wins: here one that says nothing
        environment["FASTRTPS_DEFAULT_PROFILES_FILE"] = ""
    return environment


@pytest.mark.parametrize("closed", [True, False], ids=["profile", "no_profile"])
def test_a_stranger_gets_in_only_without_the_profile(closed, cable, domain_id, start_process, wait_until):
    ours, theirs = cable
    talker = start_process(
        ["ip", "netns", "exec", ours, sys.executable, str(HELPERS / "talker.py")],
        python=False,
        env=_profile(closed),
    )
    wait_until(lambda: "up" in talker.text())
    sniff = "import sys; sys.path.insert(0, sys.argv[1]); import test_loopback; test_loopback.sniff()"
    sniffer = start_process(
        ["ip", "netns", "exec", ours, sys.executable, "-c", sniff, str(Path(__file__).parent)], python=False
    )
    wait_until(lambda: "listening" in sniffer.text())
    stranger = {**os.environ, "ROS_STATIC_PEERS": OURS, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    stranger.pop("FASTRTPS_DEFAULT_PROFILES_FILE")
    command = [sys.executable, str(HELPERS / "listener.py"), str(LISTEN_S)]
    words = ["ip", "netns", "exec", theirs, "sh", "-c", OWN_MEMORY, "sh", *command]
    for _ in range(1 if closed else ATTEMPTS):
        listeners = [start_process(words, python=False, env=stranger) for _ in range(STRANGERS)]
        inside = [listener.ended() == 0 for listener in listeners]
        if any(inside):
            break
    assert any(inside) == (not closed), [listener.text() for listener in listeners]
    assert sniffer.stop(signal.SIGTERM) == 0, sniffer.text()
    assert THEIRS in sniffer.text(), "the stranger did not even knock"
    assert (OURS in sniffer.text()) == (not closed), sniffer.text()


@pytest.mark.parametrize("discovery", ["LOCALHOST", None])
def test_a_plain_program_on_this_machine_hears_the_joints(discovery, domain_id, start_process):
    talker = start_process(["-m", "talker"])
    plain = {**os.environ}
    plain.pop("FASTRTPS_DEFAULT_PROFILES_FILE")
    plain.pop("ROS_AUTOMATIC_DISCOVERY_RANGE")
    if discovery:
        plain["ROS_AUTOMATIC_DISCOVERY_RANGE"] = discovery
    listener = start_process([str(HELPERS / "listener.py"), "30"], env=plain)
    assert listener.ended() == 0, listener.text()
    assert talker.stop() == 0
