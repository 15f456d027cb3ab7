"""Bags made of messages with known numbers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces.topics import Topic, message_class

Stamped = tuple[int, Any]  # log time [ns], message


@pytest.fixture
def make_bag(tmp_path: Path) -> Iterator[Callable[..., Path]]:
    """Writes messages by topic into a bag, gives its directory; ``closed=False``: as a kill leaves it."""
    serialization = pytest.importorskip("rclpy.serialization")

    def make(content: dict[Topic, Sequence[Stamped]], namespace: str = "", closed: bool = True) -> Path:
        recorder = opened.enter_context(contextlib.closing(BagWriter(tmp_path / "bag")))
        for topic, messages in content.items():
            name = topic.name if topic.name.startswith("/") else f"{namespace}/{topic.name}"
            recorder.add_topic(name, topic.type, [], "")
            for sequence, (time_ns, message) in enumerate(messages, 1):
                assert isinstance(message, message_class(topic))
                data = serialization.serialize_message(message)
                recorder.write(name, data, time_ns, time_ns, sequence)
        if closed:
            recorder.close()
        else:
            recorder.flush()
        return recorder.directory

    with contextlib.ExitStack() as opened:
        yield make
