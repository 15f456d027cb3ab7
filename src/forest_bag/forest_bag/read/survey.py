"""What is in a bag: counted in one pass, in memory that does not grow with its length.

===============  ===========================================================================================
symbol           meaning
===============  ===========================================================================================
period           median time between a topic's first 1000 messages, by log time
gap              a time between two messages of at least `GAP_PERIODS` periods, on a topic with a steady rate
lost             messages missing in the publishers' sequence numbers, as the recorder counted them
===============  ===========================================================================================
"""

import statistics
import struct
from dataclasses import dataclass, field

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.metadata import recorded_losses
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.interfaces.qos_profiles import described
from forest_msgs_py.interfaces.topics import EVENTS, find
from forest_msgs_py.runtime.sequences import SequenceGaps
from forest_msgs_py.types import NS_PER_S

LEARNED = 1000  # intervals
GAP_PERIODS = 5.0
STEADY = 0.5  # of a topic's intervals lie within a factor 2 of the period, or it has no rate to miss
MOST_EVENTS = 1000


@dataclass
class TopicInfo:
    """One topic; times in ns."""

    type: str
    qos: list[str] = field(default_factory=list)
    type_hash: str = ""
    publishers: int = 1
    count: int = 0
    bytes: int = 0
    first_ns: int = 0
    last_ns: int = 0
    longest_ns: int = 0
    longest_at_ns: int = 0
    lost: int = 0
    period_ns: float = 0.0
    gaps: int = 0
    _intervals: list[int] = field(default_factory=list)
    _sequences: SequenceGaps = field(default_factory=SequenceGaps)

    @property
    def rate_hz(self) -> float:
        """Mean rate; 0 for fewer than two messages."""
        span = self.last_ns - self.first_ns
        return (self.count - 1) * NS_PER_S / span if span > 0 else 0.0

    def add(self, message: RawMessage) -> None:
        """Take in the next message."""
        if self.count:
            interval = message.log_ns - self.last_ns
            if interval > self.longest_ns:
                self.longest_ns, self.longest_at_ns = interval, self.last_ns
            if self.period_ns:
                self.gaps += interval >= GAP_PERIODS * self.period_ns
            elif len(self._intervals) < LEARNED:
                self._intervals.append(interval)
                if len(self._intervals) == LEARNED:
                    self.learn()
        else:
            self.first_ns = message.log_ns
        self.count += 1
        self.bytes += len(message.data)
        self.last_ns = message.log_ns
        self._sequences.observe(message.sequence, lambda: self.publishers)
        self.lost = self._sequences.lost

    def learn(self) -> None:
        """Find the period, if there is one, and the gaps until now."""
        if self.period_ns or len(self._intervals) < 3:
            return
        period = statistics.median(self._intervals)
        steady = sum(0.5 * period <= interval <= 2.0 * period for interval in self._intervals)
        if period > 0 and steady >= STEADY * len(self._intervals):
            self.period_ns = period
            self.gaps = sum(interval >= GAP_PERIODS * period for interval in self._intervals)


@dataclass
class Survey:
    """A bag."""

    topics: dict[str, TopicInfo]
    events: list[tuple[int, str]]  # log time, text


def survey(reader: BagReader) -> Survey:
    """Count everything.

    Args:
        reader: the open bag; what is damaged is noted there.
    """
    found = Survey(topic_infos(reader), [])
    events = {name for name in found.topics if find(name) == EVENTS}
    for message in reader.messages():
        name = message.channel.topic
        found.topics[name].add(message)
        if name in events and len(found.events) < MOST_EVENTS:
            found.events.append((message.log_ns, string_text(message.data)))
    for topic in found.topics.values():
        topic.learn()
    use_recorded_losses(found.topics, reader)
    return found


def topic_infos(reader: BagReader) -> dict[str, TopicInfo]:
    """Return what a bag's files say of its topics, by name; no message is counted yet."""
    infos = {}
    for name, channels in reader.channels.items():
        profiles = described(channels[0].qos)
        types = ", ".join(sorted({channel.type for channel in channels}))
        infos[name] = TopicInfo(types, sorted(set(profiles)), channels[0].type_hash, max(1, len(profiles)))
    return infos


def use_recorded_losses(infos: dict[str, TopicInfo], reader: BagReader) -> None:
    """Let the recorder's own counts of lost messages count, where it has told them."""
    for name, count in recorded_losses(reader.information).items():
        if name in infos:
            infos[name].lost = count


def string_text(data: bytes) -> str:
    """Return the text of a std_msgs/String in little-endian CDR."""
    if len(data) < 8:
        return ""
    (length,) = struct.unpack_from("<I", data, 4)
    return data[8 : 8 + length].rstrip(b"\0").decode("utf-8", "replace")
