"""Bags with known numbers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from forest_msgs_py.bag_writer import BagWriter
from forest_msgs_py.topics import Topic, offered_qos

Logged = Sequence[tuple[int, Any]]  # log time [ns], message or bytes


@pytest.fixture
def make_bag(tmp_path: Path) -> Iterator[Callable[..., Path]]:
    """Writes messages (or bytes) by topic into a bag of a name, and gives its directory."""
    pytest.importorskip("rclpy")
    from forest_msgs_py.cdr import to_cdr

    def make(name: str, content: dict[Topic, Logged], closed: bool = True) -> Path:
        writer = opened.enter_context(contextlib.closing(BagWriter(tmp_path / name)))
        for topic in content:
            writer.add_topic(resolved(topic), topic.type, [offered_qos(topic)], "")
        rows = [(time, topic, message) for topic, logged in content.items() for time, message in logged]
        for number, (time, topic, message) in enumerate(sorted(rows, key=lambda row: row[0]), 1):
            data = message if isinstance(message, bytes) else to_cdr(message)
            writer.write(resolved(topic), data, time, time, number)
        if closed:
            writer.close()
        else:
            writer.flush()
        return writer.directory

    with contextlib.ExitStack() as opened:
        yield make


def resolved(topic: Topic) -> str:
    """The topic's name in a bag without a namespace."""
    return topic.name if topic.name.startswith("/") else f"/{topic.name}"
