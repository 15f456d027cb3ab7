"""A file of mcap's own writer is read alike by its index and, cut off before its end, record by record."""

import pytest
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from forest_bag.storage.mcap_reader import McapPieces
from forest_bag.storage.mcap_records import records
from forest_bag.storage.raw_messages import Attachment, Channel, Damaged, full_type

TIMES = [[30, 10, 20], [5, 60], [40]]


def written(path, **options):
    """Three chunks on two channels, an attachment and a metadata record."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=1 << 20, compression=CompressionType.LZ4, **options)
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/String", "ros2msg", "string dätä".encode())
        about = {"offered_qos_profiles": "- depth: 1", "topic_type_hash": "RIHS01_0"}
        a = writer.register_channel("/a", "cdr", schema, about)
        b = writer.register_channel("/b", "json", 0, {})
        for chunk in TIMES:
            for time in chunk:
                writer.add_message(b if time == 60 else a, time, b"%d" % time, time - 1, time + 1)
            if options.get("use_chunking", True):
                writer._Writer__finalize_chunk()
        writer.add_attachment(5, 6, "machine.yaml", "application/yaml", b"name: c180")
        writer.add_metadata("versions", {"python": "3"})
        writer.finish()
    return path


def cut(path):
    """The file up to the end of its data, as a killed recorder leaves it."""
    data = path.read_bytes()
    end = next(begin - 9 for opcode, begin, _ in records(data, 8) if opcode == Opcode.DATA_END)
    (path.parent / "cut.mcap").write_bytes(data[:end])
    return path.parent / "cut.mcap"


@pytest.fixture(params=["whole", "cut"])
def read(request, tmp_path):
    path = written(tmp_path / "whole.mcap")
    path = cut(path) if request.param == "cut" else path
    reader = McapPieces(path, path)
    yield reader
    reader.close()


def test_channels_are_told_with_type_definition_and_qos(read):
    assert list(read.channels.values()) == [
        Channel("/a", "std_msgs/msg/String", "cdr", "- depth: 1", "RIHS01_0", "string dätä", "ros2msg"),
        Channel("/b", "", "json"),
    ]


def test_pieces_are_the_chunks_with_their_times_and_channels(read):
    assert [(piece.first_ns, piece.last_ns, piece.channels) for piece in read.pieces] == [
        (10, 30, frozenset({1})),
        (5, 60, frozenset({1, 2})),
        (40, 40, frozenset({1})),
    ]
    assert read.pieces[0].channels is read.pieces[2].channels  # of a day's chunks many are alike
    one, two = list(read.channels.values())
    assert [
        [(m.log_ns, m.publish_ns, m.sequence, m.channel, m.data) for m in read.read(piece)]
        for piece in read.pieces
    ] == [
        [(time, time - 1, time + 1, two if time == 60 else one, b"%d" % time) for time in chunk]
        for chunk in TIMES
    ]
    read.check()


def test_attachments_and_metadata_are_read_once(read):
    assert read.attachments == [Attachment("machine.yaml", b"name: c180", "application/yaml", 6)]
    assert read.metadata == [("versions", {"python": "3"})]


def test_a_file_without_its_end_says_so_and_a_whole_one_nothing(tmp_path):
    path = written(tmp_path / "whole.mcap")
    whole, part = (McapPieces(file, file) for file in (path, cut(path)))
    assert (whole.complete, whole.problems) == (True, [])
    assert part.complete is False
    assert part.problems == ["it has no end: the recorder was killed, or is still at work"]
    for reader in (whole, part):
        reader.close()


@pytest.mark.parametrize("is_cut", [False, True])
def test_a_damaged_attachment_is_told_and_the_file_is_not_complete(tmp_path, is_cut):
    path = written(tmp_path / "whole.mcap")
    path = cut(path) if is_cut else path
    data = path.read_bytes()
    at = next(begin - 9 for opcode, begin, _ in records(data, 8) if opcode == Opcode.ATTACHMENT)
    path.write_bytes(data.replace(b"name: c180", b"name: c181"))
    reader = McapPieces(path, path)
    assert reader.problems == [f"a record at byte {at} is damaged: the attachment's checksum is wrong"]
    assert (reader.complete, reader.attachments) == (False, [])
    assert len(reader.pieces) == len(TIMES)
    reader.close()


def test_the_checksum_of_the_data_section_is_tested_where_a_writer_kept_one(tmp_path):
    for name, options in (("with", {"enable_data_crcs": True}), ("without", {"enable_data_crcs": False})):
        path = written(tmp_path / f"{name}.mcap", use_chunking=False, **options)
        data = path.read_bytes()
        for spoilt in (False, True):
            if spoilt:
                path.write_bytes(data.replace(b"60", b"61"))
            reader = McapPieces(path, path)
            if spoilt and options["enable_data_crcs"]:
                with pytest.raises(Damaged, match="the checksum of its data section is wrong"):
                    reader.check()
            else:
                reader.check()
            reader.close()


@pytest.mark.parametrize(
    ("name", "encoding", "full"),
    [
        ("std_msgs/String", "cdr", "std_msgs/msg/String"),
        ("std_msgs/msg/String", "cdr", "std_msgs/msg/String"),
        ("std_msgs/String", "json", "std_msgs/String"),
        ("String", "cdr", "String"),
        ("", "cdr", ""),
    ],
)
def test_a_type_of_dashing_gets_the_word_that_came_later(name, encoding, full):
    assert full_type(name, encoding) == full
