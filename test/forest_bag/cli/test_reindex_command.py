"""Claims about `forest-bag reindex`: metadata.yaml is made again as it was, from the files alone."""

import shutil

import pytest
import yaml
from foreign_readers import by_rosbags

from forest_bag.cli import main
from forest_bag.convert.output_options import read_outputs
from forest_bag.convert.rewrite import rewrite
from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.metadata import recorded_losses
from forest_bag.storage.sqlite_file import SqliteFile
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter

ONE = b"\x00\x01\x00\x00" + bytes(6) + b"\xf0\x3f"  # std_msgs/Float64 1.0 as little-endian CDR
S = 10**9


@pytest.fixture
def bag(tmp_path):
    writer = BagWriter(tmp_path / "bag", Layout(max_ns=S))
    for name in ("/a", "/b", "/silent"):
        writer.add_topic(name, "std_msgs/msg/Float64", [], "RIHS01_x")
    for step in range(25):
        writer.write("/a", ONE, S + step * S // 10, 0, step + 1)
        writer.write("/b", ONE, S + step * S // 10 + 1, 0, step + 1)
    writer.lost["/a"] = 3
    writer.close()
    return tmp_path / "bag"


def information(directory):
    return yaml.safe_load((directory / "metadata.yaml").read_text())["rosbag2_bagfile_information"]


@pytest.mark.parametrize("before", ["kept", "gone", "nonsense"])
def test_it_is_as_the_recorder_wrote_it_whatever_became_of_it(bag, capsys, before):
    was, messages = information(bag), by_rosbags(bag)
    if before == "gone":
        (bag / "metadata.yaml").unlink()
    elif before == "nonsense":
        (bag / "metadata.yaml").write_text("relative_file_paths: [")
    assert main.main(["reindex", str(bag)]) == 0
    assert information(bag) == was
    assert by_rosbags(bag) == messages
    assert capsys.readouterr().out == (
        f"{bag}: 50 messages of 3 topics in bag_0.mcap, bag_1.mcap, bag_2.mcap\n"
    )


def test_a_file_that_was_taken_away_is_not_told_any_more(bag):
    (bag / "bag_1.mcap").unlink()
    assert main.main(["reindex", str(bag)]) == 0
    assert information(bag)["message_count"] == 30
    assert len(by_rosbags(bag)) == 30


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
@pytest.mark.parametrize("mode", ["none", "file", "message"])
def test_every_storage_and_compression_is_found_out(bag, tmp_path, storage, mode):
    options = tmp_path / "out.yaml"
    out = {"uri": str(tmp_path / "out"), "all": True, "storage_id": storage, "compression_mode": mode}
    options.write_text(yaml.safe_dump({"output_bags": [out]}))
    with MergedBags([bag]) as source:
        rewrite(source, read_outputs(options))
    was = information(tmp_path / "out")
    if storage == "mcap":  # a database tells losses only in its own metadata, which is not read
        (tmp_path / "out" / "metadata.yaml").unlink()
    assert main.main(["reindex", str(tmp_path / "out")]) == 0
    assert information(tmp_path / "out") == was
    assert by_rosbags(tmp_path / "out") == by_rosbags(bag)


def test_what_is_no_bag_and_what_is_damaged_is_refused_and_left_as_it_is(bag, tmp_path, capsys):
    was = (bag / "metadata.yaml").read_text()
    assert main.main(["reindex", str(bag / "bag_0.mcap")]) == 1
    assert "is no directory; allowed: a bag's directory" in capsys.readouterr().err
    shutil.copytree(bag, tmp_path / "mixed")
    (tmp_path / "mixed" / "x.db3").write_bytes(b"SQLite")
    assert main.main(["reindex", str(tmp_path / "mixed")]) == 1
    assert "x.db3 is cut off: it holds 6 bytes" in capsys.readouterr().err
    (tmp_path / "mixed" / "x.db3").unlink()
    SqliteFile(tmp_path / "mixed" / "x.db3").finish()
    assert main.main(["reindex", str(tmp_path / "mixed")]) == 1
    assert "mixed holds mcap and sqlite3; allowed: files of one kind" in capsys.readouterr().err
    file = bag / "bag_1.mcap"
    file.write_bytes(file.read_bytes()[:-100])
    assert main.main(["reindex", str(bag)]) == 1
    assert "forest-bag recover" in capsys.readouterr().err
    assert (bag / "metadata.yaml").read_text() == was


@pytest.mark.parametrize(
    ("custom", "losses"),
    [
        ({"lost_messages": "9", "lost_messages:/a": "3", "lost_messages:/b": 4}, {"/a": 3, "/b": 4}),
        ({"lost_messages:/a": "many", "lost_messages:/b": "-1", 5: "6"}, {}),
        ("lost_messages:/a", {}),
        (None, {}),
    ],
)
def test_losses_are_what_can_be_understood_of_somebodys_custom_data(custom, losses):
    assert recorded_losses({"custom_data": custom}) == losses
