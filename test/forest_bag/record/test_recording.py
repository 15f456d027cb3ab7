"""A recording flushes by the clock, and a full disk ends it once, with one sentence, whoever meets it."""

import errno

import pytest

pytest.importorskip("rclpy")

from forest_bag.record.recording import Recording, Refusal
from forest_bag.storage.bag_files import bag_files
from forest_bag.storage.mcap_recovery import RecordRecovery
from forest_bag.write.bag_session import Session
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import FLUSH_PERIOD_S
from forest_msgs_py.introspection.graph_listener import ReceivedMessage
from forest_msgs_py.runtime.node import NodeFailure

OFFER = [{"durability": "volatile", "depth": 1, "lifespan": {"sec": 0}}]


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr("forest_bag.record.recording.time.monotonic", clock)
    return clock


@pytest.fixture
def waiting():
    """What has arrived."""
    return []


@pytest.fixture
def said():
    """What was logged."""
    return []


@pytest.fixture
def recording(clock, waiting, said, tmp_path):
    session = Session(tmp_path / "bag", Layout(durable=True))
    session.add_topic("/depth", "std_msgs/msg/Float64", OFFER, "")
    session.start()

    def take():
        taken = waiting[:]
        waiting.clear()
        return taken

    yield Recording(session, take, said.append)
    session.stop()


def heard(step, missed=0):
    return ReceivedMessage(step, "/depth", b"12345678", step, step + 1, missed)


def on_disk(directory):
    return sum(
        hasattr(record, "sequence") for file in bag_files(directory) for record in RecordRecovery(file)
    )


def test_what_is_older_than_two_tenths_of_a_second_is_on_the_disk(recording, clock, waiting, tmp_path):
    """With a turn every 10 ms, as the node has them."""
    assert FLUSH_PERIOD_S + 0.01 < 0.2
    ages = []
    for step in range(100):
        waiting.append(heard(step))
        clock.now += 0.01
        recording.turn()
        ages.append((step + 1 - on_disk(tmp_path / "bag")) * 0.01)
    assert max(ages) <= FLUSH_PERIOD_S + 0.01


def test_it_is_said_that_it_records_when_the_first_message_is_on_the_disk(
    recording, clock, waiting, said, tmp_path
):
    """And not for what the recorder hears of itself."""
    recording.session.add_topic("/rosout", "rcl_interfaces/msg/Log", OFFER, "")
    recording.turn()
    waiting.append(heard(0)._replace(name="/rosout"))
    clock.now += 0.01
    recording.turn()
    assert (said, on_disk(tmp_path / "bag")) == ([], 0)
    waiting.append(heard(1))
    clock.now += 0.01
    recording.turn()
    assert said == [f"recording to {tmp_path / 'bag'}"]
    assert on_disk(tmp_path / "bag") == 2
    waiting.append(heard(2))
    clock.now += 0.01
    recording.turn()
    assert (len(said), on_disk(tmp_path / "bag")) == (1, 2)


def test_losses_are_told_by_topic(recording, waiting):
    waiting.extend([heard(1), heard(5, missed=3)])
    assert "recorded 2 messages, 1 topics, lost 3, 3 of /depth: " in recording.stop()


def test_a_full_disk_ends_it_once_with_the_path_and_the_bag_closed(
    recording, clock, waiting, tmp_path, monkeypatch
):
    waiting.extend(heard(step) for step in range(20))
    recording.turn()
    clock.now += 1.0
    recording.turn()

    def full(_descriptor, _data):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr("forest_bag.storage.append_file.os.write", full)
        waiting.append(heard(99))
        clock.now += 1.0
        words = rf"cannot write the bag in {tmp_path}/bag: No space left on device; it ends after 20 messages"
        with pytest.raises(NodeFailure, match=words):
            recording.turn()
    with pytest.raises(NodeFailure, match=words):
        recording.turn()
    with pytest.raises(Refusal, match="not recording"):
        recording.split()
    recording.end()
    assert on_disk(tmp_path / "bag") == 20
