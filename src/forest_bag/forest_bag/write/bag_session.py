"""What a recorder does between start and stop: takes, splits, the memory of the last seconds.

========  ==================================================================================================
symbol    meaning
========  ==================================================================================================
take      what is recorded between a start and a stop: one bag. The first is `output`, then `output_2`, ...
ring      with `snapshot_ns`: the messages of the last seconds; they come into the bag when one asks for them
========  ==================================================================================================

No ROS in here. Transient-local messages and context outlive a take: each of them gets all.
"""

from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from forest_bag.storage.metadata import OfferedTopic
from forest_bag.write.bag_split import Attached, Contents, Layout
from forest_bag.write.bag_writer import BagWriter
from forest_bag.write.transient_local import Sample


class Session:
    """Records into one bag after the other.

    Args:
        output: directory of the first take; it is made with `start`.
        layout: of the bags.
        snapshot_ns: 0, or how much the ring holds [ns].
    """

    def __init__(self, output: str | Path, layout: Layout, snapshot_ns: int = 0) -> None:
        self.lost: dict[str, int] = {}  # in this take, by topic
        self.written = 0  # messages in the bag that was closed last
        self._output = Path(output).absolute()
        self._layout, self._snapshot_ns = layout, snapshot_ns
        self._takes = 0
        self._writer: BagWriter | None = None
        self._contents = Contents()
        self._ring: deque[Sample] = deque()

    @property
    def recording(self) -> bool:
        """Whether a take is open."""
        return self._writer is not None

    @property
    def directory(self) -> Path:
        """Of the present take, or of the last one."""
        takes = max(1, self._takes)
        return self._output if takes == 1 else self._output.with_name(f"{self._output.name}_{takes}")

    @property
    def message_count(self) -> int:
        """Messages in this take."""
        return self._writer.message_count if self._writer is not None else 0

    @property
    def topic_count(self) -> int:
        """Topics known so far."""
        return len(self._contents.topics)

    @property
    def size(self) -> int:
        """Bytes of this take."""
        return self._writer.size if self._writer is not None else 0

    @property
    def waiting(self) -> int:
        """Messages in the ring."""
        return len(self._ring)

    def start(self) -> Path:
        """Begin a take; return its directory.

        Raises:
            OSError: its directory exists, or cannot be made.
        """
        if self._writer is None:
            self._takes += 1
            self._writer = BagWriter(self.directory, self._layout, self._contents)
            self.lost = self._writer.lost
        return self.directory

    def stop(self) -> None:
        """Close the take; nothing happens if none is open.

        Raises:
            OSError: the disk is full; the bag is closed nevertheless.
        """
        writer, self._writer = self._writer, None
        self._forget_ring()
        if writer is not None:
            try:
                writer.close()
            finally:
                self.written = writer.written

    def add_topic(self, name: str, type_name: str, qos: Sequence[Mapping[str, Any]], type_hash: str) -> bool:
        """Learn of a topic, or of a further publisher of it, as `BagWriter.add_topic`."""
        if self._writer is not None:
            return self._writer.add_topic(name, type_name, qos, type_hash)
        self._contents.add(OfferedTopic(name, type_name, qos, type_hash))
        return True

    def attach(self, file: Attached) -> None:
        """Put a file into the bag, if it is not there already.

        Raises:
            OSError: the disk is full.
        """
        if file.name in self._contents.context:
            return
        if self._writer is None:
            self._contents.context[file.name] = file
        else:
            self._writer.attach(file)

    def note(self, name: str, values: dict[str, str]) -> None:
        """Put a metadata record into the bag.

        Raises:
            OSError: the disk is full.
        """
        if self._writer is None:
            self._contents.context[name] = values
        else:
            self._writer.note(name, values)

    def missed(self, name: str, messages: int) -> None:
        """Count messages that were lost before they came here."""
        if messages and name in self.lost:
            self.lost[name] += messages

    def write(self, name: str, data: bytes, log_ns: int, publish_ns: int, sequence: int = 0) -> None:
        """Store one message's bytes, in the bag or in the ring.

        Raises:
            OSError: the disk is full.
        """
        if self._writer is None:
            self._contents.transient_local.keep(Sample(name, data, log_ns, publish_ns, sequence))
        elif not self._snapshot_ns:
            self._writer.write(name, data, log_ns, publish_ns, sequence)
        else:
            self._ring.append(Sample(name, data, log_ns, publish_ns, sequence))
            while self._ring[0].log_ns < log_ns - self._snapshot_ns:
                self._contents.transient_local.keep(self._ring.popleft())

    def flush(self) -> None:
        """Have what was written survive a kill, and soon a power cut.

        Raises:
            OSError: the disk is full.
        """
        if self._writer is not None:
            self._writer.flush()

    def split(self) -> None:
        """Begin the next file.

        Raises:
            OSError: the disk is full.
        """
        if self._writer is not None:
            self._writer.split()

    def snapshot(self) -> int:
        """Write what the ring holds into a file of its own; return the number of messages.

        Raises:
            OSError: the disk is full.
        """
        if self._writer is None:
            return 0
        count = len(self._ring)
        while self._ring:
            self._writer.write(*self._ring.popleft())
        self._writer.split()
        return count

    def _forget_ring(self) -> None:
        while self._ring:
            self._contents.transient_local.keep(self._ring.popleft())
