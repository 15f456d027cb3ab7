"""Many recorded messages of one topic at once, where they differ in nothing but stamp and numbers.

The counterpart of `forest_msgs_py.serialization.batch_encoder`: a record of one session has the
same sensors throughout, so
that its messages are copies of the first one with other numbers; those are taken from their places in all
messages together, a hundred times faster than message by message.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from forest_bag.read.flatten import Row
from forest_description.types import Floats
from forest_msgs_py.interfaces.topics import FLOAT_ARRAY, JOINT_STATE, Topic
from forest_msgs_py.serialization.batch_encoder import Encoder

FEW = 8  # messages, for which looking at them one by one is as fast


def decoded(kind: Topic, messages: Sequence[bytes], first: Row) -> tuple[NDArray[np.int64], Floats] | None:
    """Return stamps [N] and numbers [N, k] of all messages; None if these differ in more, or cannot.

    Args:
        kind: row of the topic table.
        messages: CDR bytes.
        first: what the first message says, taken apart.
    """
    if kind.type not in (FLOAT_ARRAY, JOINT_STATE) or len(messages) < FEW or first.stamp_ns is None:
        return None
    labels = _names(kind, first)
    if not labels:
        return None
    try:
        encoder = Encoder(kind._replace(labels=labels, units=("",) * len(labels)))
    except (AssertionError, ValueError):
        return None
    return encoder.decode(messages)


def _names(kind: Topic, first: Row) -> tuple[str, ...]:
    """Return the labels that a message carries; none if it does not carry positions, speeds and efforts."""
    if kind.type == FLOAT_ARRAY:
        return first.labels
    names = tuple(label.removesuffix(".position") for label in first.labels if label.endswith(".position"))
    return names if len(first.labels) == 3 * len(names) else ()
