"""A session's takes, its ring of the last seconds, and what every take is told anew."""

import pytest
from mcap.reader import make_reader

from forest_bag.storage.bag_files import bag_files
from forest_bag.write.bag_session import Session
from forest_bag.write.bag_split import Attached, Layout

FOREVER = {"sec": 9223372036, "nsec": 854775807}
S = 10**9


def offers(durability="volatile"):
    return [{"durability": durability, "depth": 1, "lifespan": FOREVER}]


@pytest.fixture
def session(tmp_path):
    opened = []

    def make(**options):
        session = Session(tmp_path / "bag", Layout(), **options)
        session.add_topic("/robot_description", "std_msgs/msg/String", offers("transient_local"), "")
        session.add_topic("/depth", "std_msgs/msg/Float64", offers(), "")
        opened.append(session)
        return session

    yield make
    for session in opened:
        session.stop()


def told(directory):
    """Topic and sequence of each message, in each file."""
    files = []
    for file in bag_files(directory):
        with file.open("rb") as stream:
            files.append(
                [(channel.topic, m.sequence) for _, channel, m in make_reader(stream).iter_messages()]
            )
    return files


def test_every_take_is_a_bag_of_its_own_with_latched_messages_and_context(session, tmp_path):
    takes = session()
    takes.attach(Attached("machine.yaml", "application/yaml", b"name: c180", 5))
    takes.note("versions", {"python": "3"})
    takes.write("/robot_description", b"urdf", S, S, 1)  # before the start: nobody records yet
    assert takes.start() == tmp_path / "bag"
    takes.write("/depth", b"1", 2 * S, 2 * S, 1)
    takes.stop()
    takes.write("/depth", b"between", 3 * S, 3 * S, 2)
    assert takes.start() == tmp_path / "bag_2"
    takes.write("/depth", b"3", 4 * S, 4 * S, 3)
    takes.stop()
    assert takes.written == 2
    assert told(tmp_path / "bag") == [[("/robot_description", 1), ("/depth", 1)]]
    assert told(tmp_path / "bag_2") == [[("/robot_description", 1), ("/depth", 3)]]
    for name in ("bag/bag_0.mcap", "bag_2/bag_2_0.mcap"):
        with (tmp_path / name).open("rb") as stream:
            reader = make_reader(stream)
            assert [a.name for a in reader.iter_attachments()] == ["machine.yaml"]
            assert next((m.name, m.metadata) for m in reader.iter_metadata()) == ("versions", {"python": "3"})


def test_a_snapshot_holds_the_last_seconds_and_what_was_latched_before(session, tmp_path):
    takes = session(snapshot_ns=2 * S)
    takes.start()
    takes.write("/robot_description", b"urdf", 0, 0, 1)
    for step in range(100):
        takes.write("/depth", b"d", step * S // 10, 0, step)
    assert takes.waiting == 21
    takes.snapshot()
    assert takes.waiting == 0
    for step in range(100, 103):
        takes.write("/depth", b"d", step * S // 10, 0, step)
    takes.snapshot()
    takes.stop()
    first, second = told(tmp_path / "bag")
    assert first == [("/robot_description", 1), *(("/depth", step) for step in range(79, 100))]
    assert second == [("/robot_description", 1), ("/depth", 100), ("/depth", 101), ("/depth", 102)]


def test_the_ring_does_not_grow(session):
    takes = session(snapshot_ns=S)
    takes.start()
    for step in range(10_000):
        takes.write("/depth", b"d", step * S // 100, 0, step)
    assert takes.waiting == 101


def test_losses_belong_to_the_take_in_which_they_happened(session):
    takes = session()
    takes.start()
    takes.missed("/depth", 3)
    assert takes.lost == {"/robot_description": 0, "/depth": 3}
    takes.stop()
    takes.start()
    assert takes.lost == {"/robot_description": 0, "/depth": 0}


def test_nothing_is_written_while_no_take_is_open(session, tmp_path):
    takes = session()
    takes.split()
    takes.flush()
    takes.snapshot()
    takes.stop()
    assert not takes.recording
    assert not (tmp_path / "bag").exists()


def test_a_take_tells_how_much_it_has_and_takes_in_what_is_told_meanwhile(session, tmp_path):
    takes = session()
    assert (takes.recording, takes.message_count, takes.size, takes.topic_count) == (False, 0, 0, 2)
    assert (takes.written, takes.lost, takes.waiting) == (0, {}, 0)
    assert takes.directory == takes.start() == takes.start() == tmp_path / "bag"
    begun = takes.size
    assert takes.add_topic("/odd", "nobodys_msgs/msg/Odd", offers(), "") is False  # nobody knows its type
    for name, content in (("a.yaml", b"a: 1"), ("a.yaml", b"b: 2")):  # the first of a name stays
        takes.attach(Attached(name, "application/yaml", content, 5))
    takes.note("late", {"key": "value"})
    takes.write("/odd", b"bytes", S, S)
    takes.missed("/odd", 2)
    takes.missed("/nobodys", 2)
    assert (takes.recording, takes.message_count, takes.topic_count) == (True, 1, 3)
    assert takes.size > begun > 0
    assert takes.lost == {"/robot_description": 0, "/depth": 0, "/odd": 2}
    takes.stop()
    assert (takes.recording, takes.message_count, takes.size, takes.written) == (False, 0, 0, 1)
    assert told(tmp_path / "bag") == [[("/odd", 0)]]
    with (tmp_path / "bag/bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        assert [(a.name, a.data) for a in reader.iter_attachments()] == [("a.yaml", b"a: 1")]
        assert next((m.name, m.metadata) for m in reader.iter_metadata()) == ("late", {"key": "value"})


def test_a_split_on_demand_begins_the_next_file_and_a_snapshot_of_nothing_is_none(session, tmp_path):
    takes = session(snapshot_ns=S)
    takes.start()
    assert takes.snapshot() == 0
    takes.write("/depth", b"1", S, S, 1)
    assert takes.snapshot() == 1
    takes.write("/depth", b"2", 2 * S, 2 * S, 2)
    takes.stop()  # what waits in the ring is nobody's
    assert told(tmp_path / "bag") == [[("/depth", 1)]]
    plain = Session(tmp_path / "plain", Layout())
    plain.add_topic("/depth", "std_msgs/msg/Float64", offers(), "")
    plain.start()
    for number in (1, 2):
        plain.write("/depth", b"d", number, number, number)
        plain.split()
    plain.stop()
    assert told(tmp_path / "plain") == [[("/depth", 1)], [("/depth", 2)]]
