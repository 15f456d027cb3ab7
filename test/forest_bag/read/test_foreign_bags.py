"""Odd and damaged bags of other people get a sentence and an exit code from every verb, never a traceback."""

import random
import shutil
import sqlite3

import pytest
import zstandard

pytest.importorskip("rclpy")

from std_msgs.msg import String

from forest_bag.cli.main import main
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.serialization.cdr import to_cdr

N = 30
PERIOD = 5_000_000
TEXT = to_cdr(String(data="hello"))


@pytest.fixture
def bag(make_bag):
    """Numbers on two topics, and a text."""
    stamps = [PERIOD * step for step in range(1, N + 1)]
    return make_bag(
        {
            topics.FLOWS: [(t, messages.float_array(topics.FLOWS, t, (1.0, 2.0))) for t in stamps],
            topics.JOINT_STATES: [
                (t, messages.joint_state(topics.JOINTS, t, (1.0, 2.0, 3.0))) for t in stamps
            ],
            topics.EVENTS: [(PERIOD, String(data="begin"))],
        },
    )


def database(path, rows, topic=(1, "/a", "std_msgs/msg/String", "cdr")):
    """A file of rosbag2's; rows are id, topic_id, timestamp, data."""
    path.unlink(missing_ok=True)
    file = sqlite3.connect(path)
    file.execute("CREATE TABLE topics (id, name, type, serialization_format)")
    file.execute("CREATE TABLE messages (id, topic_id, timestamp, data)")
    file.execute("INSERT INTO topics VALUES (?, ?, ?, ?)", topic)
    file.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rows)
    file.commit()
    file.close()
    return path


def told(capsys, *arguments):
    """Exit code, standard output and standard error of a verb."""
    code = main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_messages_that_name_an_absent_topic_are_a_sentence_in_every_verb(tmp_path, capsys):
    clock = to_cdr(topics.message_class(topics.CLOCK)())
    rows = [(1, 1, 5, clock), (2, 3, 6, clock)]
    file = database(tmp_path / "odd.db3", rows, (1, "/clock", topics.CLOCK.type, "cdr"))
    code, out, _ = told(capsys, "info", file)
    assert code == 1
    assert "1 of its messages name topic_id 3, which is not in its table of topics" in out
    assert "messages   1, lost 0" in out
    for verb in (("compare", file, file), ("play", file)):
        code, _, err = told(capsys, *verb)
        assert code == 2
        assert err.count("\n") == 1
        assert "topic_id 3" in err
    code, out, err = told(capsys, "to-csv", file)
    assert code == 0
    assert "the bag is damaged: the table has what is whole of it" in err
    assert len(out.splitlines()) == 2


def test_a_file_that_was_compressed_and_cut_off_is_named_as_the_user_knows_it(tmp_path, capsys, bag):
    whole = {"a.mcap.zstd": bag / "bag_0.mcap", "a.db3.zstd": database(tmp_path / "a.db3", [(1, 1, 5, TEXT)])}
    for name, plain in whole.items():
        file = tmp_path / name
        data = zstandard.compress(plain.read_bytes())
        file.write_bytes(data)
        assert f"file       {name} " in told(capsys, "info", file)[1]
        file.write_bytes(data[: len(data) // 2])
        code, out, _ = told(capsys, "info", file)
        assert code == 1
        problems = [line for line in out.splitlines() if line.startswith("problem")]
        assert problems
        assert all(f"{file} is" in line for line in problems), problems
        code, _, err = told(capsys, "play", file)
        assert code == 2
        assert err.startswith(f"forest-bag: {file} is ")


@pytest.mark.parametrize(
    "name", ["a.db3", "a.mcap.zstd", "empty.mcap", "nowhere.mcap", "magic.mcap", "folder"]
)
def test_recover_is_advised_only_where_it_can_help_and_says_why_not(tmp_path, capsys, bag, name):
    path, whole = tmp_path / name, (bag / "bag_0.mcap").read_bytes()
    if name == "a.db3":
        database(path, [(1, 3, 5, TEXT)])
    elif name == "folder":
        path.mkdir()
        (path / "a.db3").write_bytes(b"SQLite format 3\0")
        (path / "metadata.yaml").write_text("rosbag2_bagfile_information: {relative_file_paths: [b.db3]}")
    elif name != "nowhere.mcap":
        content = {"a.mcap.zstd": zstandard.compress(whole)[:-20], "empty.mcap": b"", "magic.mcap": whole[:8]}
        path.write_bytes(content[name])
    for verb in (("play", path), ("compare", path, bag)):
        code, _, err = told(capsys, *verb)
        assert code == 2
        assert "forest-bag recover" not in err
    code, _, err = told(capsys, "recover", path, "-o", tmp_path / "out")
    assert code == 1
    assert err.startswith(f"forest-bag: {path}")
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_recover_of_what_holds_no_message_saves_the_rest_but_fails(tmp_path, capsys):
    from forest_bag.write.bag_split import Attached
    from forest_bag.write.bag_writer import BagWriter

    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/a", "std_msgs/msg/String", [], "")
    writer.attach(Attached("machine.yaml", "application/yaml", b"name: c180", 5))
    writer.close()
    code, _, err = told(capsys, "recover", tmp_path / "bag", "-o", tmp_path / "out")
    assert code == 1
    assert (
        f"no message of {tmp_path / 'bag'} can be read; {tmp_path / 'out'} holds what else there was" in err
    )
    assert "attached   machine.yaml" in told(capsys, "info", tmp_path / "out")[1]


def test_what_the_bag_leaves_open_of_qos_is_told_as_unknown(tmp_path, capsys):
    from forest_bag.write.bag_writer import BagWriter

    writer = BagWriter(tmp_path / "bag")
    forever = {"sec": 9223372036, "nsec": 854775807}
    live = {"history": "unknown", "depth": 0, "reliability": "reliable", "durability": "transient_local"}
    writer.add_topic("/live", "std_msgs/msg/String", [live | {"lifespan": forever}], "")
    untold = {"depth": 7, "durability": "unknown", "lifespan": forever}
    writer.add_topic("/untold", "std_msgs/msg/String", [untold], "")
    writer.close()
    lines = told(capsys, "info", tmp_path / "bag")[1].splitlines()
    assert [line.split("; ")[-1].split("  ")[-1] for line in lines if line.startswith("topic")] == [
        "reliable, latched, depth unknown",
        "reliability unknown, durability unknown, depth 7",
    ]


def test_a_message_that_is_none_of_its_type_is_an_empty_row(make_bag, capsys):
    good = [(t, messages.float_array(topics.FLOWS, t, (1.0, 2.0))) for t in (1, 2, 3)]
    senseless = messages.float_array(topics.FLOWS, 5, (3.0, 4.0))
    senseless.data[0] = float("nan")  # its stamp
    odd = make_bag({topics.FLOWS: [*good, (4, to_cdr(good[0][1])[:30]), (5, senseless)]}, "odd")
    code, out, err = told(capsys, "to-csv", odd)
    assert code == 0
    assert "/hydraulics/flows: 1 messages are not of its type, their rows are empty" in err
    rows = [line.split(",") for line in out.splitlines()[1:]]
    assert [(row[0], row[2:]) for row in rows] == [
        *((str(t), ["1.0", "2.0"]) for t in (1, 2, 3)),
        ("4", ["", ""]),
        ("5", ["3.0", "4.0"]),
    ]
    assert told(capsys, "compare", odd, make_bag({topics.FLOWS: good}, "good"))[0] == 1


METADATA = (
    *("5", "{relative_file_paths: 5}", "{relative_file_paths: [1, null, '..', {}]}", "{custom_data: [1]}"),
    *("{custom_data: {1: 2, 'lost_messages:/events': some}}", "{compression_mode: 5}", "[", "{a: [}"),
)


def odd_file(generator, folder, whole):
    """A path with something that a person might have."""
    kind = generator.randrange(4)
    if kind == 0:
        bag = folder / "bag"
        shutil.rmtree(bag, ignore_errors=True)
        bag.mkdir()
        (bag / "bag_0.mcap").write_bytes(whole)
        (bag / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {generator.choice(METADATA)}")
        return bag
    wild = (
        None,
        1.5,
        "text",
        b"blob",
        -1,
        2**62,
        "",
        "/",
        "std_msgs",
        "std_msgs/msg/Nope",
        "../a/msg/B",
        TEXT,
    )
    if kind == 1:
        rows = [[n, 1, n * 1000, TEXT] for n in range(20)]
        for row in generator.sample(rows, 3):
            row[generator.randrange(4)] = generator.choice(wild)
        topic = [1, "/a", "std_msgs/msg/String", "cdr"]
        topic[generator.randrange(4)] = generator.choice(wild)
        return database(folder / "a.db3", rows, topic)
    data = bytearray(whole if kind == 2 else database(folder / "b.db3", [(1, 1, 1, TEXT)]).read_bytes())
    for _ in range(generator.randrange(6)):
        data[generator.randrange(len(data))] = generator.randrange(256)
    del data[generator.randrange(len(data)) :]
    data[-12:-8] = bytes(4)  # of a summary: no checksum, so that it is believed
    path = folder / ("c.mcap" if kind == 2 else "c.db3")
    path.write_bytes(data)
    return path


def test_no_file_makes_a_verb_fail_otherwise_than_with_a_sentence(bag, tmp_path, capsys):
    generator, whole = random.Random(12), (bag / "bag_0.mcap").read_bytes()
    codes = set()
    for number in range(12):
        path, out = odd_file(generator, tmp_path, whole), tmp_path / f"out_{number}"
        for verb in (
            *(("info", path), ("info", "--json", path), ("compare", path, bag), ("to-csv", path)),
            *(("compare", path, bag, "--align", "start"), ("recover", path, "-o", out)),
        ):
            code, _, err = told(capsys, *verb)
            codes.add(code)
            assert all(line.startswith("forest-bag: ") for line in err.splitlines()), err
    assert codes == {0, 1, 2}
