"""Frames of a bag say what its table says at the same time; they cost what they show, not what it holds."""

import contextlib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from forest_bag.convert.table import joined
from forest_bag.read.bag_reader import BagReader
from forest_bag.read.timeseries import read_bag
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.mcap_reader import McapPieces
from forest_description.machine import load_machine
from forest_station.recordings.replay_bag import ReplayBag
from forest_station.recordings.replay_frames import FRAME, MOST_FRAMES, Window, frames, matrix, window

REFERENCES = [Path("bags") / name for name in ("coordinated", "valves", "fault")]
OWN = load_machine("c180_hoses")
STEP_HZ = 200  # of the reference bags, which are made in lockstep: log times are stamps


@pytest.fixture(scope="module", params=REFERENCES, ids=lambda path: path.name)
def reference(request):
    return request.param


@pytest.fixture(scope="module")
def bag(reference):
    """A reference bag as the page opens it; nothing is kept of what was asked before."""
    with contextlib.closing(ReplayBag(reference, OWN)) as opened:
        yield opened


def parts(data, signals):
    """Headers and values of frames, as the page takes them apart."""
    kind = [
        ("kind", "u1"),
        ("zero", "u1", 3),
        ("number", "<u4"),
        ("time", "<f8"),
        ("values", "<f4", (signals,)),
    ]
    return np.frombuffer(data, dtype=kind)


def test_frames_are_the_table_of_to_csv_at_the_same_times(reference, bag):
    table = joined(read_bag(reference), hold=True)
    step = 1 / STEP_HZ
    whole = window(0.0, bag.seconds + step, STEP_HZ)
    values = matrix(bag, whole)
    steps = np.rint((table.stamps_ns - bag.start_ns) / 1e9 * STEP_HZ).astype(int)
    of_table = {column.name: (column.unit, column.values) for column in table.columns}
    assert len(steps) > 800
    recorded = [name for name in bag.units if not name.startswith("crane/")]
    assert set(of_table) == set(recorded)
    for place, name in enumerate(recorded):
        unit = bag.units[name]
        assert of_table[name][0] == unit
        np.testing.assert_array_equal(values[steps, place], of_table[name][1], name)


@pytest.mark.parametrize("rate", [7.0, 30.0, 200.0])
def test_windows_meet_without_a_seam(bag, rate):
    whole = frames(bag, window(0.0, 4.0, rate))
    cuts = [0.0, 0.71, 0.71, 1.0, 2.3335, 4.0]
    pieces = [frames(bag, window(a, b, rate)) for a, b in pairwise(cuts)]
    assert b"".join(pieces) == whole


def test_frames_are_laid_out_as_the_protocol_says(bag):
    found = parts(frames(bag, window(1.0, 2.0, 30.0)), len(bag.units))
    assert set(found["kind"]) == {FRAME}
    assert not found["zero"].any()
    np.testing.assert_array_equal(found["number"], np.arange(30, 60))
    np.testing.assert_array_equal(found["time"], np.arange(30, 60) / 30.0)
    np.testing.assert_array_equal(found["values"], matrix(bag, Window(30, 60, 30.0)).astype("f4"))


def test_before_its_first_message_a_signal_is_unknown():
    bag = ReplayBag(REFERENCES[0], OWN)
    first = matrix(bag, window(0.0, 0.004, STEP_HZ))
    joints = [place for place, name in enumerate(bag.units) if name.startswith("joint_states/")]
    assert len(joints) == 9
    assert np.isnan(first[0, joints]).all()


@pytest.mark.parametrize(
    "numbers",
    [
        *((0, 1, 0), (0, 1, -1), (0, 1, float("nan")), (0, 1, 201), (0, 1, float("inf"))),
        *(
            (-1, 1, 30),
            (2, 1, 30),
            (0, 601, 1),
            (float("nan"), 1, 30),
            (0, float("inf"), 30),
            (1e300, 1e300, 1),
        ),
        (0, 60, 31),
    ],
)
def test_a_window_that_is_none_or_too_large_is_refused_with_what_is_allowed(numbers):
    with pytest.raises(BagError, match="allowed"):
        window(*map(float, numbers))


def test_a_minute_at_thirty_a_second_is_the_largest_window():
    assert window(0.0, 60.0, 30.0).end == MOST_FRAMES


def test_a_window_behind_the_end_holds_the_last_values():
    bag = ReplayBag(REFERENCES[0], OWN)
    last = matrix(bag, window(100.0, 100.01, 100.0))
    np.testing.assert_array_equal(last[0], matrix(bag, window(bag.seconds, bag.seconds + 0.004, STEP_HZ))[0])


@pytest.mark.parametrize("indexed", [True, False])
def test_a_window_reads_its_own_pieces_and_few_before_it(tmp_path, monkeypatch, indexed):
    """Of 53 chunks; a topic that spoke once, at the start, costs one more and not all between."""
    file = tmp_path / "bag_0.mcap"
    data = (REFERENCES[0] / "coordinated_0.mcap").read_bytes()
    file.write_bytes(data if indexed else data[:-20])
    bag = ReplayBag(file, OWN)
    opened, read = [], McapPieces.read
    monkeypatch.setattr(McapPieces, "read", lambda self, piece: opened.append(piece) or read(self, piece))
    matrix(bag, window(4.0, 4.2, 30.0))
    pieces = bag.reader.files[0].pieces
    assert len(pieces) > 50
    late = [piece for piece in set(opened) if piece.last_ns > bag.start_ns + 3.9e9]
    assert len(set(opened)) < 15
    assert len(late) <= 5


def test_only_what_is_shown_is_decoded(monkeypatch):
    """30 frames of a second in which each topic spoke 200 times: at most 30 messages of each."""
    bag = ReplayBag(REFERENCES[0], OWN)
    counts = {}
    from forest_station.recordings import replay_frames

    real = replay_frames.series_of
    monkeypatch.setattr(
        replay_frames,
        "series_of",
        lambda channel, messages: counts.update({channel.topic: len(messages)}) or real(channel, messages),
    )
    matrix(bag, window(2.0, 3.0, 30.0))
    assert counts["/joint_states"] == 30
    assert max(counts.values()) == 30


def test_the_newest_message_of_a_topic_is_found_from_any_time(reference):
    """Against all messages, one after the other."""
    with BagReader(reference) as reader:
        everything = list(reader.messages())
        for time_ns in (0, 5_000_000, 1_234_567_890, 3_000_000_000, reader.span[1]):
            expected = {m.channel.topic: m for m in everything if m.log_ns <= time_ns}
            assert reader.newest(reader.channels, time_ns) == expected
