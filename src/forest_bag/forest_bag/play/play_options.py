"""What `forest-bag play` is asked for, and what of a bag that means."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from forest_bag.play.playback import Plan
from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.bag_files import BagError
from forest_msgs_py.interfaces.qos_profiles import Qos, for_replay, offered
from forest_msgs_py.interfaces.topics import CLOCK
from forest_msgs_py.types import NS_PER_S

NAME = re.compile(r"(~/|/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)  # as ROS allows them


class PlayOptions(NamedTuple):
    """The verb's flags; times in s of bag time, `delay` of wall time."""

    bags: tuple[Path, ...]
    rate: float = 1.0
    loop: bool = False
    start_offset: float = 0.0
    duration: float | None = None
    topics: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    clock: float = 0.0  # [Hz]; 0: none
    paused: bool = False
    wait_for_subscribers: bool = False
    delay: float = 0.5
    stats: bool = False
    burst: int | None = None  # messages to be played at once, before a pause; 0: all
    overrides: Mapping[str, Qos] = {}  # of the bags' topics, in place of the recorded QoS


class Selection(NamedTuple):
    """Topics to be played, by their names in the bag."""

    names: dict[str, str]  # under which they are published
    types: dict[str, str]
    profiles: dict[str, Qos]
    hashes: dict[str, str]  # of the types as they were recorded; "" where the bag does not tell
    warnings: tuple[str, ...]


def select(reader: MergedBags, options: PlayOptions, is_installed: Callable[[str], bool]) -> Selection:
    """Choose the topics.

    Args:
        reader: the open bags.
        options: what is asked for.
        is_installed: whether a message type is.

    Raises:
        BagError: a topic that is named is not in the bag, or nothing is left to play.
    """
    channels = reader.channels
    asked = (*options.topics, *options.exclude, *(old for old, _ in options.remaps))
    missing = sorted({name for name in asked if name not in channels})
    if missing:
        raise BagError(f"no topic {', '.join(missing)} in the bag; it holds {', '.join(channels) or 'none'}")
    remaps, warnings = dict(options.remaps), []
    found = Selection(names={}, types={}, profiles={}, hashes={}, warnings=())
    for topic, kinds in channels.items():
        if topic in options.exclude or (options.topics and topic not in options.topics):
            continue
        problem = _problem(topic, {(kind.type, kind.encoding) for kind in kinds}, options, is_installed)
        if problem:
            warnings.append(f"{topic} is not played: {problem}")
            continue
        found.names[topic] = remaps.get(topic, topic)
        found.types[topic] = kinds[0].type
        found.hashes[topic] = kinds[0].type_hash
        recorded = for_replay([profile for kind in kinds for profile in offered(kind.qos)])
        found.profiles[topic] = options.overrides.get(topic, recorded)
    if not found.names:
        raise BagError("; ".join([f"nothing to play in {reader.path}", *warnings]))
    return found._replace(warnings=tuple(warnings))


def as_fast_as_possible(options: PlayOptions) -> bool:
    """Whether messages are sent without regard to their times, so that readers must be waited for."""
    return options.rate == 0.0 or options.burst is not None


def plan(reader: MergedBags, options: PlayOptions) -> Plan:
    """Turn the flags into bag times.

    Raises:
        BagError: the bag ends before it is to be begun.
    """
    first, last = reader.span
    start = first + round(options.start_offset * NS_PER_S)
    end = last if options.duration is None else min(last, start + round(options.duration * NS_PER_S))
    if start > last:
        length = (last - first) / NS_PER_S
        raise BagError(
            f"--start-offset is {options.start_offset:g}; allowed: 0 .. {length:g} s, the bag's length"
        )
    period = round(NS_PER_S / options.clock) if options.clock else 0
    return Plan(
        start_ns=start,
        end_ns=end,
        rate=options.rate,
        loop=options.loop,
        paused=options.paused or options.burst is not None,
        clock_period_ns=period,
    )


def _problem(
    topic: str, kinds: set[tuple[str, str]], options: PlayOptions, is_installed: Callable[[str], bool]
) -> str:
    """Say why a topic cannot be played; "" if it can."""
    name = dict(options.remaps).get(topic, topic)
    if not NAME.fullmatch(name):
        return f"{name!r} is no name of a topic; allowed: letters, digits and _ between slashes (-m OLD:=NEW)"
    if topic == CLOCK.name and options.clock:
        return "--clock publishes it"
    if len(kinds) > 1:
        return f"it has several types ({', '.join(sorted(kind for kind, _ in kinds))})"
    type_name, encoding = next(iter(kinds))
    if encoding != "cdr":
        return f"it is encoded as {encoding or 'nothing'}; allowed: cdr"
    return "" if is_installed(type_name) else f"its type {type_name or 'nobody'} is not installed here"
