"""`forest-bag recover` says what it found, and in one sentence what is wrong."""

import pytest

from forest_bag.cli import main
from forest_bag.write.bag_writer import BagWriter

ONE = b"\x00\x01\x00\x00" + bytes(6) + b"\xf0\x3f"  # std_msgs/Float64 1.0 as little-endian CDR


@pytest.fixture
def bag(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    writer.add_topic("/depth", "std_msgs/msg/Float64", [], "")
    for step in range(10):
        writer.write("/depth", ONE, step, step, step + 1)
    writer.close()
    return tmp_path / "bag"


def test_each_file_and_the_sum_are_told(bag, capsys):
    file = bag / "bag_0.mcap"
    end = file.read_bytes().index(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    file.write_bytes(file.read_bytes()[: end + 3])
    assert main.main(["recover", str(bag)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        f"bag_0.mcap: 3 bytes not readable, the first of them at byte {end} -> bag_recovered_0.mcap",
        f"recovered 10 messages of 1 topics: {bag}_recovered",
    ]


def test_a_single_whole_file_is_fine_too(bag, tmp_path, capsys):
    assert main.main(["recover", str(bag / "bag_0.mcap"), "-o", str(tmp_path / "out")]) == 0
    assert "bag_0.mcap: whole -> out_0.mcap" in capsys.readouterr().out


def test_an_output_that_exists_and_a_bag_that_does_not_are_refused(bag, tmp_path, capsys):
    assert main.main(["recover", str(bag), "-o", str(tmp_path)]) == 1
    assert capsys.readouterr().err == (
        f"forest-bag: {tmp_path} exists; allowed: a directory to be made (-o DIR)\n"
    )
    assert main.main(["recover", str(tmp_path / "nowhere")]) == 1
    assert "nowhere does not exist; allowed: a bag's directory or an .mcap file" in capsys.readouterr().err
    assert main.main(["recover", str(tmp_path)]) == 1
    assert "holds no .mcap file" in capsys.readouterr().err
