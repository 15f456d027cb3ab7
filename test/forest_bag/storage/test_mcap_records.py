"""Records of an MCAP file, to the byte at which they end."""

import struct
import zlib

import pytest
from mcap.opcode import Opcode

from forest_bag.storage import mcap_records
from forest_bag.storage.mcap_records import attachment, footer, records, whole_records

MAGIC = b"\x89MCAP0\r\n"


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def test_records_end_before_the_first_that_is_not_whole():
    data = record(7, b"abc") + record(9, b"")
    assert list(records(data)) == [(7, 9, 12), (9, 21, 21)]
    assert list(records(data, 12)) == [(9, 21, 21)]
    assert list(records(data, stop=20)) == [(7, 9, 12)]
    assert list(records(data, stop=11)) == []
    assert list(records(data + record(0, b"") + record(7, b""))) == [(7, 9, 12), (9, 21, 21)]
    assert list(whole_records(data)) == list(records(data))
    assert list(whole_records(b"")) == []
    with pytest.raises(ValueError, match="begins at its byte 21 is no record"):
        list(whole_records(data + b"\x07"))
    assert [*records(record(Opcode.MESSAGE, bytes(22)))] == [(Opcode.MESSAGE, 9, 31)]
    with pytest.raises(ValueError, match="message at byte 0 has a length of 21 bytes"):
        list(records(record(Opcode.MESSAGE, bytes(21))))


def test_a_footer_tells_where_the_summary_begins_and_never_behind_itself():
    def file(start, checksum=5):
        return b"before" + record(Opcode.FOOTER, struct.pack("<QQI", start, 0, checksum)) + MAGIC

    assert footer(file(3)) == (6, 3, 5)
    assert footer(file(0)) == (6, 6, 5)
    assert footer(file(6)) == (6, 6, 5)
    with pytest.raises(ValueError, match="points behind itself"):
        footer(file(7))
    for wrong in (file(3)[:-1], file(3)[7:], b"before" + record(3, bytes(20)) + MAGIC, b""):
        with pytest.raises(ValueError, match="no footer"):
            footer(wrong)
    assert footer(file(0)[6:]) == (0, 0, 5)


def test_an_attachment_counts_with_its_checksum_or_with_none():
    text = [struct.pack("<I", len(part)) + part for part in (b"name", b"text/plain")]
    body = struct.pack("<QQ", 1, 2) + b"".join(text) + struct.pack("<Q", 3) + b"abc"
    for checksum in (0, zlib.crc32(body)):
        assert attachment(body + struct.pack("<I", checksum)).data == b"abc"
    with pytest.raises(ValueError, match="checksum is wrong"):
        attachment(body + struct.pack("<I", 1))
    with pytest.raises(ValueError, match="do not add up"):
        attachment(body + struct.pack("<I", 0) + b"more")
    assert mcap_records.parsed(Opcode.ATTACHMENT, body + bytes(4)).name == "name"
    assert mcap_records.parsed(Opcode.DATA_END, b"") is None
    schema = struct.pack("<H", 1) + text[0] + text[1] + struct.pack("<I", 0)
    assert mcap_records.parsed(Opcode.SCHEMA, schema + b"more").name == "name"
    with pytest.raises(ValueError, match="lengths within the record"):
        mcap_records.parsed(Opcode.SCHEMA, schema + b"more", exact=True)
