"""The shipped profile lets in everyone on this machine, and keeps out every stranger and every packet in.

The stranger is a second network namespace at the other end of a virtual cable, who names us as a static peer.
Without the profile it does get in (LOCALHOST alone is no barrier), which shows that the test could fail.
"""

import os
import signal
import socket
import sys
import threading
from collections import Counter
from pathlib import Path

import hosts
import pytest

pytest.importorskip("rclpy")

HELPERS = Path(__file__).parents[1] / "helpers"
OURS, THEIRS = "10.77.0.1", "10.77.0.2"
LISTEN_S = 4
STRANGERS = 4  # at once: the few first announcements of one do not always meet somebody
ATTEMPTS = 4  # of theirs to get in where they can
UDP_IN_IPV4 = (b"\x08\x00", 17)


@pytest.fixture
def cable():
    """Two hosts and a cable between them."""
    with hosts.hosts("a", "b") as at:
        hosts.switch(at, [f"{address}/24" for address in (OURS, THEIRS)])
        yield at


def sniff() -> None:
    """Print the UDP packets on link0 of this network namespace by source address, until told to stop."""
    told = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: told.set())
    packets = Counter()
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x0003)) as wire:
        wire.bind(("link0", 0))
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
    sniff = "import sys; sys.path += sys.argv[1:]; import test_loopback; test_loopback.sniff()"
    words = [sys.executable, "-c", sniff, str(Path(__file__).parent), str(HELPERS)]
    sniffer = start_process(["ip", "netns", "exec", ours, *words], python=False)
    wait_until(lambda: "listening" in sniffer.text())
    stranger = {**os.environ, "ROS_STATIC_PEERS": OURS, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    stranger.pop("FASTRTPS_DEFAULT_PROFILES_FILE")
    words = hosts.on(theirs, sys.executable, str(HELPERS / "listener.py"), str(LISTEN_S))
    for _ in range(1 if closed else ATTEMPTS):
        listeners = [start_process(words, python=False, env=stranger) for _ in range(STRANGERS)]
        inside = [listener.ended() == 0 for listener in listeners]
        if any(inside):
            break
    assert any(inside) == (not closed), [listener.text() for listener in listeners]
    assert sniffer.stop(signal.SIGTERM) == 0, sniffer.text()
    assert THEIRS in sniffer.text(), "the stranger did not even knock"
    assert (OURS in sniffer.text()) == (not closed), sniffer.text()


def test_no_one_writes_to_shared_memory_of_ours(domain_id, start_process, wait_until):
    """A reader that is killed may keep its port locked: writers then wait for a second and more."""
    talker = start_process(["-m", "talker"])
    wait_until(lambda: "up" in talker.text())
    assert "fastrtps_port" not in Path(f"/proc/{talker.pid}/maps").read_text()
    assert talker.stop() == 0


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
