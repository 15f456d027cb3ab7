"""Claims about the player's services under rosbag2's names; its messages are stood for by their fields.

The package with the real ones is on no package index: that rclpy offers them is not tested here
(docs/how-to/open-in-rviz-foxglove-plotjuggler.md, "Tried").
"""

import threading
from types import SimpleNamespace

import pytest

from forest_bag.play.playback import Plan, Player
from forest_bag.play.rosbag2_services import rosbag2_services
from forest_bag.storage.raw_messages import Channel, RawMessage

S = 10**9
START = 5 * S


class Bag:
    """Ten messages, one a second, and where they go."""

    def __init__(self):
        self.sent = []

    def messages(self, start_ns):
        messages = [RawMessage(START + n * S, 0, 0, Channel("/a", "a"), b"") for n in range(10)]
        yield from (message for message in messages if message.log_ns >= start_ns)

    def transient_local(self, _position_ns, _renew):
        return []

    def publish(self, message):
        self.sent.append((message.log_ns - START) // S)


@pytest.fixture
def player():
    bag = Bag()
    player = Player(bag, bag, Plan(START, START + 9 * S, paused=True))
    player.bag = bag
    running = threading.Thread(target=player.run)
    running.start()
    while not player._running:
        running.join(0.001)
    yield player
    player.stop()
    running.join()


@pytest.fixture
def ask(player):
    """Calls a service by name with the request's fields; gives the response's."""
    services = rosbag2_services(player, (START, START + 9 * S), player.set_rate)

    def call(name, **request):
        kind, answer = services[name]
        assert kind == "".join(word.capitalize() for word in name.split("_"))
        response = SimpleNamespace()
        assert answer(SimpleNamespace(**request), response) is response
        return vars(response)

    return call


def test_every_service_of_rosbag2s_player_is_there(player):
    assert set(rosbag2_services(player, (0, 1), player.set_rate)) == {
        *("pause", "resume", "toggle_paused", "is_paused", "get_rate", "set_rate"),
        *("play", "play_next", "burst", "seek", "stop"),
    }


def test_another_playback_is_refused_as_rosbag2_refuses_it_while_one_runs(player, ask):
    assert ask("play") == {"success": False}
    assert player.bag.sent == []


def test_pausing(player, ask):
    assert ask("is_paused") == {"paused": True}
    assert ask("resume") == {}
    assert ask("is_paused") == {"paused": False}
    assert ask("play_next") == {"success": False}
    assert ask("burst", num_messages=3) == {"actually_burst": 0}
    assert ask("toggle_paused") == {}
    assert ask("is_paused") == {"paused": True}
    assert ask("pause") == {}
    assert player.paused


def test_a_rate_must_be_positive(player, ask):
    assert ask("get_rate") == {"rate": 1.0}
    assert ask("set_rate", rate=2.5) == {"success": True}
    for wrong in (0.0, -1.0, float("nan"), 1e9):
        assert ask("set_rate", rate=wrong) == {"success": False}
    assert ask("get_rate") == {"rate": 2.5}


def test_bursts_and_seeks_within_the_bag(player, ask):
    assert ask("burst", num_messages=2) == {"actually_burst": 2}
    assert ask("seek", time=SimpleNamespace(sec=12, nanosec=1)) == {"success": True}
    assert ask("seek", time=SimpleNamespace(sec=1, nanosec=0)) == {"success": False}
    assert ask("burst", num_messages=0) == {"actually_burst": 2}
    assert player.bag.sent == [0, 1, 8, 9]


def test_stop_ends_it(player, ask):
    assert ask("stop") == {}
    while player._running:
        threading.Event().wait(0.001)
