"""Claims about `forest-bag convert`: other readers find in its bags what was in those it read."""

import sqlite3

import pytest
import yaml
from foreign_readers import by_mcap, by_rosbags
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from forest_bag.cli import main
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.metadata import OfferedTopic
from forest_bag.write.bag_split import Attached, Layout
from forest_bag.write.bag_writer import BagWriter

NEVER = {"sec": 9223372036, "nsec": 854775807}
S = 10**9
DEPTH, TEXT = "std_msgs/msg/Float64", "std_msgs/msg/String"


def offer(durability="volatile", depth=10):
    return {
        **dict.fromkeys(("deadline", "lifespan", "liveliness_lease_duration"), NEVER),
        "history": "keep_last",
        "depth": depth,
        "reliability": "reliable",
        "durability": durability,
        "liveliness": "automatic",
        "avoid_ros_namespace_conventions": False,
    }


def number(value):
    """CDR of a std_msgs/Float64 whose bytes tell which one it is."""
    return b"\x00\x01\x00\x00" + value.to_bytes(8, "little")


def write(directory, topics, begin=S, seconds=10, layout=None, attached=b"name: c180"):
    """A bag with a message of each topic every 0.1 s; its description comes first."""
    bag = BagWriter(directory, layout or Layout())
    bag.add_topic("/robot_description", TEXT, [offer("transient_local", 1)], "RIHS01_t")
    for name in topics:
        bag.add_topic(name, DEPTH, [offer()], "RIHS01_d")
    bag.attach(Attached("machine.yaml", "application/yaml", attached, 5))
    bag.note("versions", {"python": "3"})
    bag.write("/robot_description", b"\x00\x01\x00\x00\x09\x00\x00\x00<robot/>\x00", begin, begin, 1)
    for step in range(10 * seconds):
        for place, name in enumerate(topics):
            time = begin + step * S // 10 + place
            bag.write(name, number(time), time, time - 3, step + 1)
    bag.lost["/a"] = 2
    bag.close()
    return directory


@pytest.fixture
def bag(tmp_path):
    return write(tmp_path / "bag", ["/a", "/b"])


@pytest.fixture
def convert(tmp_path, capsys):
    """Converts; gives the exit code, and what was printed."""

    def run(inputs, *outputs, text=None):
        options = tmp_path / "out.yaml"
        options.write_text(text or yaml.safe_dump({"output_bags": list(outputs)}))
        words = [word for path in inputs for word in ("-i", str(path))]
        return main.main(["convert", *words, "-o", str(options)]), capsys.readouterr()

    return run


def output(tmp_path, name="out", **options):
    return {"uri": str(tmp_path / name), **({"all_topics": True} | options)}


def test_everything_of_a_bag_is_kept(bag, tmp_path, convert):
    assert convert([bag], output(tmp_path)) == (
        0,
        (f"{tmp_path / 'out'}: 201 messages of 3 topics in 1 file\n", ""),
    )
    old, new = bag / "bag_0.mcap", tmp_path / "out" / "out_0.mcap"
    assert by_mcap(new) == by_mcap(old)
    assert by_rosbags(tmp_path / "out") == by_rosbags(bag)
    with old.open("rb") as before, new.open("rb") as after:
        a, b = make_reader(before), make_reader(after)
        assert list(a.iter_attachments()) == list(b.iter_attachments())
        assert {m.name: m.metadata for m in b.iter_metadata()}["versions"] == {"python": "3"}
        schemas = [{s.name: (s.encoding, s.data) for s in r.get_summary().schemas.values()} for r in (a, b)]
        assert schemas[0] == schemas[1]
        channels = [{c.topic: c.metadata for c in r.get_summary().channels.values()} for r in (a, b)]
        assert channels[0] == channels[1]
    with BagReader(tmp_path / "out") as reader:
        assert reader.information["custom_data"]["lost_messages:/a"] == "2"


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("mode", ["", "file", "message"])
def test_every_storage_and_compression_is_read_by_others_and_comes_back_as_it_was(
    bag, tmp_path, convert, storage, mode
):
    options = {"storage_id": storage, "compression_mode": mode, "compression_format": "zstd" if mode else ""}
    code, printed = convert([bag], output(tmp_path, "there", **options))
    assert code == 0
    assert ("attachments are left out" in printed.out) == (storage == "sqlite3")
    assert by_rosbags(tmp_path / "there") == by_rosbags(bag)
    with Reader(tmp_path / "there") as reader:
        told = {c.topic: (c.msgtype, c.digest, len(c.ext.offered_qos_profiles)) for c in reader.connections}
    assert told["/a"] == (DEPTH, "RIHS01_d", 1)
    assert convert([tmp_path / "there"], output(tmp_path, "back"))[0] == 0
    assert by_rosbags(tmp_path / "back") == by_rosbags(bag)
    kept = {row[0]: row[2] for row in by_mcap(tmp_path / "back" / "back_0.mcap")}
    assert kept == {row[0]: row[2] for row in by_mcap(bag / "bag_0.mcap")}


def test_a_database_is_as_rosbag2_of_jazzy_makes_it(bag, tmp_path, convert):
    convert([bag], output(tmp_path, storage_id="sqlite3"))
    database = sqlite3.connect(tmp_path / "out" / "out_0.db3")
    assert database.execute("SELECT schema_version FROM schema").fetchone() == (4,)
    rows = database.execute("SELECT topic_type, encoding FROM message_definitions").fetchall()
    assert (DEPTH, "ros2msg") in rows
    ((version, text),) = database.execute("SELECT metadata_version, metadata FROM metadata").fetchall()
    assert (version, yaml.safe_load(text)["message_count"]) == (9, 201)
    database.close()
    about = yaml.safe_load((tmp_path / "out" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert about["storage_identifier"] == "sqlite3"


def test_bags_are_merged_by_time(tmp_path, convert):
    a = write(tmp_path / "a", ["/a"])
    b = write(tmp_path / "b", ["/a", "/b"], begin=5 * S + 7, attached=b"name: other")
    assert convert([a, b], output(tmp_path))[0] == 0
    merged = by_rosbags(tmp_path / "out")
    assert sorted(merged) == sorted(by_rosbags(a) + by_rosbags(b))
    assert [row[1] for row in merged] == sorted(row[1] for row in merged)
    with (tmp_path / "out" / "out_0.mcap").open("rb") as stream:
        attached = {a.name: a.data for a in make_reader(stream).iter_attachments()}
    assert attached == {"machine.yaml": b"name: c180", "b/machine.yaml": b"name: other"}
    with BagReader(tmp_path / "out") as reader:
        assert reader.information["custom_data"]["lost_messages:/a"] == "4"


@pytest.mark.parametrize(
    ("options", "topics"),
    [
        ({"all": True}, {"/a", "/b", "/robot_description"}),
        ({"topics": ["/a"], "all_topics": False}, {"/a"}),
        ({"topic_types": [TEXT], "all_topics": False}, {"/robot_description"}),
        ({"regex": "^/b$", "topics": ["/a"], "all_topics": False}, {"/a", "/b"}),
        ({"exclude_topics": ["/a"]}, {"/b", "/robot_description"}),
        ({"exclude_topic_types": [DEPTH]}, {"/robot_description"}),
        ({"exclude_regex": "desc"}, {"/a", "/b"}),
        ({"exclude": "a|desc"}, {"/b"}),
    ],
)
def test_topics_are_chosen_by_rosbag2s_words(bag, tmp_path, convert, options, topics):
    assert convert([bag], output(tmp_path, **options))[0] == 0
    kept = by_rosbags(tmp_path / "out")
    assert {row[0] for row in kept} == topics
    assert kept == [row for row in by_rosbags(bag) if row[0] in topics]


def test_services_are_chosen_by_their_names(tmp_path, convert):
    event = "/add/_service_event"
    bag = write(tmp_path / "bag", ["/a", event])
    assert convert([bag], output(tmp_path, "topics"))[0] == 0
    assert {row[0] for row in by_rosbags(tmp_path / "topics")} == {"/a", "/robot_description"}
    only = output(tmp_path, "services", all_topics=False, services=["/add"])
    assert convert([bag], only, output(tmp_path, "all", all_topics=False, all_services=True))[0] == 0
    for name in ("services", "all"):
        assert {row[0] for row in by_rosbags(tmp_path / name)} == {event}


def test_first_and_last_log_time_count(bag, tmp_path, convert):
    assert convert([bag], output(tmp_path, start_time_ns=S, end_time_ns=2 * S))[0] == 0
    assert by_rosbags(tmp_path / "out") == [row for row in by_rosbags(bag) if S <= row[1] <= 2 * S]


def test_a_longest_duration_and_a_largest_size_split_and_repeat_nothing(bag, tmp_path, convert):
    slow = output(tmp_path, "slow", max_bagfile_duration=2.5)
    small = output(tmp_path, "small", max_bagfile_size=4000, storage_preset_profile="none")
    database = output(tmp_path, "database", max_bagfile_size=6000, storage_id="sqlite3")
    assert convert([bag], slow, small, database)[0] == 0
    for name, suffix in (("slow", "mcap"), ("small", "mcap"), ("database", "db3")):
        files = list((tmp_path / name).glob(f"*.{suffix}"))
        assert len(files) >= 2
        assert by_rosbags(tmp_path / name) == by_rosbags(bag)
    for file in (tmp_path / "slow").glob("*.mcap"):
        times = [row[1] for row in by_mcap(file)]
        assert max(times) - min(times) < 2.5 * S


def test_a_type_that_is_not_installed_keeps_its_definition(tmp_path, convert):
    strange = BagWriter(tmp_path / "bag")
    strange.add_offer(OfferedTopic("/s", "odd_msgs/msg/Odd", [], "", "cdr", ("ros2msg", "float64 odd\n")))
    strange.write("/s", number(1), 1, 1, 1)
    strange.close()
    convert([tmp_path / "bag"], output(tmp_path, "there", storage_id="sqlite3"))
    convert([tmp_path / "there"], output(tmp_path, "back"))
    with (tmp_path / "back" / "back_0.mcap").open("rb") as stream:
        (schema,) = make_reader(stream).get_summary().schemas.values()
    assert (schema.name, schema.encoding, schema.data) == ("odd_msgs/msg/Odd", "ros2msg", b"float64 odd\n")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"all_topics": False}, "output_bags[0] chooses no topic; allowed: all_topics: true, topics"),
        ({"topics": ["/c"], "all_topics": False}, "no topic of"),
        ({"uri": ""}, "output_bags[0] has no uri; allowed: a directory to be made"),
        ({"storage_id": "hdf5"}, "storage_id is 'hdf5'; allowed: mcap, sqlite3, or nothing"),
        (
            {"compression_mode": "file", "compression_format": "lz4"},
            "compression_format is 'lz4'; allowed: zstd",
        ),
        ({"compression_mode": "chunk"}, "compression_mode is 'chunk'; allowed: none, file, message"),
        ({"storage_preset_profile": "best"}, "allowed: none, fastwrite, zstd_fast, zstd_small, resilient"),
        ({"rmw_serialization_format": "json"}, "rmw_serialization_format is 'json'; allowed: cdr"),
        ({"topics": "/a"}, "topics is '/a'; allowed: a list of texts"),
        ({"topics": [1]}, "topics is [1]; allowed: a list of texts"),
        ({"all_topics": 1}, "all_topics is 1; allowed: true or false"),
        ({"max_bagfile_size": 1.5}, "max_bagfile_size is 1.5; allowed: a whole number of 0 or more"),
        ({"max_bagfile_size": True}, "max_bagfile_size is True; allowed"),
        ({"max_bagfile_duration": -1}, "max_bagfile_duration is -1; allowed: a number of 0 or more"),
        ({"regex": "("}, "regex is '(', which is no regular expression"),
        ({"speed": 1}, "unknown key 'speed'; allowed: uri, storage_id"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_made(bag, tmp_path, convert, options, said):
    code, printed = convert([bag], output(tmp_path, **options))
    assert code == 1
    assert said in printed.err
    assert printed.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["", "- 1", "output_bags: 3", "output_bags: []", "a: ["])
def test_a_file_that_names_no_output_is_refused(bag, convert, text):
    code, printed = convert([bag], text=text or " ")
    assert code == 1
    assert "out.yaml" in printed.err


def test_an_output_that_exists_or_is_named_twice_is_refused(bag, tmp_path, convert):
    for outputs in ([{"uri": str(bag), "all": True}], [output(tmp_path), output(tmp_path)]):
        code, printed = convert([bag], *outputs)
        assert code == 1
        assert "exists, or is named twice; allowed: directories to be made" in printed.err
    assert len(by_rosbags(bag)) == 201


def test_a_topic_of_two_types_is_refused(tmp_path, convert):
    a, b = BagWriter(tmp_path / "a"), BagWriter(tmp_path / "b")
    for bag, kind in ((a, DEPTH), (b, TEXT)):
        bag.add_topic("/a", kind, [], "")
        bag.write("/a", number(1), 1, 1, 1)
        bag.close()
    code, printed = convert([tmp_path / "a", tmp_path / "b"], output(tmp_path))
    assert code == 1
    assert (
        "/a has several types: std_msgs/msg/Float64 (cdr), std_msgs/msg/String (cdr); allowed: one"
        in printed.err
    )


def test_a_damaged_bag_leaves_no_half_output(bag, tmp_path, convert):
    file = bag / "bag_0.mcap"
    data = bytearray(file.read_bytes())
    data[len(data) // 4] ^= 0xFF  # in a chunk: the index is whole
    file.write_bytes(data)
    code, printed = convert([bag], output(tmp_path))
    assert code == 1
    assert "is damaged" in printed.err
    assert not (tmp_path / "out").exists()


def test_a_storage_id_behind_an_input_is_accepted(bag, tmp_path, capsys):
    options = tmp_path / "out.yaml"
    options.write_text(yaml.safe_dump({"output_bags": [output(tmp_path)]}))
    assert main.main(["convert", "-i", str(bag), "mcap", "-o", str(options)]) == 0
    assert main.main(["convert", "-i", str(bag), "x", "-o", str(options)]) == 1
    assert "allowed: a bag, and perhaps mcap or sqlite3" in capsys.readouterr().err
