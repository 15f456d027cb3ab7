"""Bags made of messages with known numbers."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from forest_bag.write.bag_split import Attached
from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import Topic

Logged = Sequence[tuple[int, Any]]  # log time [ns], message or bytes


@pytest.fixture
def make_bag(tmp_path: Path) -> Iterator[Callable[..., Path]]:
    """Writes messages (or bytes) by topic, and files, into a bag; ``closed=False``: as a kill leaves it."""
    pytest.importorskip("rclpy")
    from forest_msgs_py.serialization.cdr import to_cdr

    def make(
        content: dict[Topic, Logged],
        name: str = "bag",
        namespace: str = "",
        closed: bool = True,
        files: Sequence[tuple[str, str]] = (),
    ) -> Path:
        def resolved(topic: Topic) -> str:
            return topic.name if topic.name.startswith("/") else f"{namespace}/{topic.name}"

        writer = opened.enter_context(contextlib.closing(BagWriter(tmp_path / name)))
        for label, text in files:
            writer.attach(Attached(label, "application/yaml", text.encode(), 1))
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
