"""`FOREST_NETWORK` names the other host: these two hear each other; who else does depends on the routes.

Three hosts stand on one switch: ours, the one that we name, and a stranger who names us.
"""

import os
import sys
from pathlib import Path

import hosts
import pytest

from forest_msgs_py.runtime import environment

pytest.importorskip("rclpy")

LISTENER = str(Path(__file__).parents[1] / "helpers" / "listener.py")
NAMED = (  # a plain program in the environment that our nodes make themselves
    "import os, sys; from forest_msgs_py.runtime.environment import prepare_environment; "
    "prepare_environment(); os.execv(sys.executable, [sys.executable, *sys.argv[1:]])"
)
OURS, PEER, STRANGER = "10.78.0.1", "10.78.0.2", "10.78.0.3"
HEARS_S, NOTHING_S = "20", "3"


@pytest.fixture
def three():
    with hosts.hosts("ours", "peer", "stranger") as at:
        hosts.switch(at, [f"{OURS}/32", f"{PEER}/24", f"{STRANGER}/24"])
        yield at


@pytest.mark.parametrize("answered", [PEER, "10.78.0.0/24"], ids=["route_to_the_peer", "route_to_everyone"])
def test_the_named_host_hears_us_and_another_one_only_where_a_route_leads_back_to_it(
    answered, three, domain_id, start_process, wait_until
):
    ours, peer, stranger = three
    hosts.ip("-n", ours, "route", "add", answered, "dev", "link0", "src", OURS)

    def start(host, *words, **network):
        given = {**os.environ, "PYTHONPATH": str(Path(LISTENER).parent), **network}
        del given["FASTRTPS_DEFAULT_PROFILES_FILE"]
        return start_process(hosts.on(host, sys.executable, *words), python=False, env=given)

    talker = start(ours, "-m", "talker", FOREST_NETWORK=PEER)
    wait_until(lambda: "up" in talker.text())
    open_network = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    heard = {
        "peer": start(peer, "-c", NAMED, LISTENER, HEARS_S, FOREST_NETWORK=OURS),
        "caller": start(stranger, LISTENER, NOTHING_S, **open_network, ROS_STATIC_PEERS=OURS),
        "anyone": start(stranger, LISTENER, NOTHING_S, **open_network),
    }
    codes = {who: process.ended() for who, process in heard.items()}
    assert codes == {"peer": 0, "caller": int(answered == PEER), "anyone": 1}
    assert talker.stop() == 0, talker.text()


@pytest.fixture
def network(monkeypatch):
    """Chooses a network for this process, and those that it forks."""
    for name in ("ROS_STATIC_PEERS", "FASTRTPS_DEFAULT_PROFILES_FILE"):
        monkeypatch.setenv(name, "")  # so that the test's end restores it
        monkeypatch.delenv(name)
    return lambda text: monkeypatch.setenv("FOREST_NETWORK", text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("127.0.0.1", "127.0.0.1 is this host; allowed: open, or addresses or names of other hosts"),
        ("opne.invalid", "'opne.invalid' is no host that is known here; allowed: open, or addresses"),
        ("127.0.0.1,,", "'' is no host that is known here"),
        ("255.255.255.255", "no way leads to 255.255.255.255"),
    ],
)
def test_a_network_that_cannot_be_had_is_told_in_one_sentence(text, words, network):
    network(text)
    with pytest.raises(environment.NetworkError) as told:
        environment.prepare_environment()
    assert str(told.value).startswith(f"FOREST_NETWORK: {words}")
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in os.environ


def test_what_differs_between_hosts_stands_once_in_the_profile_of_one_host():
    text = environment.LOOPBACK_PROFILE.read_text("utf-8")
    for local, _ in ((environment.LOOPBACK, ""), *environment.NETWORK_TIMES):
        assert text.count(local) == 1, local


@pytest.mark.parametrize(("module", "code"), [("talker", 2), ("forest_bringup.graph", 1)])
def test_no_program_starts_in_a_network_that_cannot_be_had(module, code, network, domain_id, start_process):
    network("127.0.0.1")
    process = start_process(["-m", module])
    assert process.ended() == code
    assert "FOREST_NETWORK: 127.0.0.1 is this host" in process.text()
    assert "Traceback" not in process.text()
