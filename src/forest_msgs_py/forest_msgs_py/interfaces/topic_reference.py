"""The table of topics as docs/reference/topics.md shows it."""

from forest_msgs_py.interfaces.topic_qos import queue_depth
from forest_msgs_py.interfaces.topics import TOPICS, Topic


def _fields(topic: Topic) -> str:
    """Labels with units; a unit shared by all labels is named once."""
    if len(set(topic.units)) == 1:
        return f"{', '.join(topic.labels)} [{topic.units[0]}]"
    return (
        "; ".join(f"{label} [{unit}]" for label, unit in zip(topic.labels, topic.units, strict=True)) or "-"
    )


def _row(topic: Topic) -> str:
    quality = f"reliable, {'latched' if topic.transient_local else 'volatile'}, depth {queue_depth(topic)}"
    quality += "; read best-effort" if topic.sensed else ""
    people = (", ".join(topic.publishers) or "-", ", ".join(topic.subscribers) or "-")
    rate = f"{topic.rate_hz:g} Hz" if topic.rate_hz else "on change"
    cells = (f"`{topic.name}`", topic.type, _fields(topic), rate, quality, "yes" if topic.recorded else "no")
    return f"| {' | '.join((*cells, *people, topic.doc))} |"


def markdown() -> str:
    """The table as docs/reference/topics.md holds it."""
    head = ("topic", "type", "values [unit]", "rate", "QoS", "recorded", "published by", "read by", "content")
    return "\n".join(
        (
            "# Topics",
            "",
            "Made by `python -m forest_msgs_py.interfaces.topic_reference`; a test compares.",
            "Names without a leading slash are relative: a namespace moves them. A Float64MultiArray carries",
            "`data = [sec, nanosec, values...]`, `layout.data_offset` 2 and the labels, comma-separated, in",
            "`layout.dim[0].label`; with `data_offset` 0 the values stand alone and count as of now.",
            "A sensor that is not there, or has lost its sample, is absent from the labels (a joint from the",
            "names), never NaN; a message of which nothing is left is not sent.",
            "",
            "**QoS.** Our publishers are reliable. What sensors and joysticks say is read best-effort, so",
            "that drivers which publish best-effort are heard, too; `emergency_stop` is read in every way.",
            "On the other topics a publisher that offers less than is asked for is not heard: the node that",
            "does not hear it names it on `/diagnostics` (WARN) and in its log.",
            "",
            "**Emergency stop.** Controller and valve driver each latch `emergency_stopped` from their start",
            "on. Who joins gets the last word of each; the machine stands as long as one of them says true.",
            "",
            "**Diagnostics.** OK: the part works. WARN: it works, but it waits for somebody, cannot hear",
            "somebody, or clips a command. ERROR: something is wrong, and the node stands still or does",
            "without. The values are ages, rates since the last time, counts, and the limits in force.",
            "",
            "**Poses.** `tip/pose` is the URDF's frame `tip` in `base_link`: x along the stick, y level to",
            "the left. A pose whose orientation nobody knows, as of an imported log, has an all-zero",
            "quaternion.",
            "",
            f"| {' | '.join(head)} |",
            f"|{'---|' * len(head)}",
            *(_row(topic) for topic in TOPICS),
        )
    )


if __name__ == "__main__":
    print(markdown())
