"""What a node says about its inputs and its own state: a throttled warning, and a diagnostic on /diagnostics.

A node notes for each of its parts what is wrong with it, or "" when it is well. The first note of a sort of
trouble is logged, and again if it comes back after `QUIET`; /diagnostics gets all parts when one of them
changes between well and unwell, and once a second, ten times a second at most. Its periods are counted in
stamps, so that a run repeats.

======  ====================================================================================================
level   meaning
======  ====================================================================================================
OK      the part works
WARN    it works, but a person should know: it waits for somebody, cannot hear somebody, or clips a command
ERROR   something is wrong with it, and the node has drawn the consequence
======  ====================================================================================================

STALE is not said: it is what a display makes of a node that has fallen silent.
"""

import re
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.runtime.node import publisher
from forest_msgs_py.types import NS_PER_S

WELL = "well"
QUIET = 5.0  # [s] after which trouble that comes back is logged again; what stands is not
DIGIT, MOST_SORTS = re.compile(r"\d"), 8  # of trouble, logged within that time
LONGEST = 400  # characters of what is wrong: somebody's message may hold a million numbers
SOONEST_NS = NS_PER_S // 10  # between two diagnostics: what comes and goes with each message costs no more
PATIENCE_NS = 2 * NS_PER_S  # for which a graph may be starting, before the log says who is waited for
LOGGED = -1  # of what is waited for: the log has said it

Values = Callable[[], Mapping[str, Any]]


class Source(Protocol):
    """Something that a part hears or does, as an `InputStatus`."""

    def waiting(self) -> str:
        """Return who is waited for; "" for nobody."""

    def unheard(self) -> str:
        """Return who is not heard, and why; "" for nobody."""

    def values(self) -> Mapping[str, Any]:
        """Return values by their names, which tell the units."""


class Diagnostics:
    """Keeps the notes of one node.

    Args:
        node: whose diagnostics these are.
        parts: what can fail, in the order in which it is told.
        consequence: what the node does about trouble; begins every warning.
        said: publisher of /diagnostics, if the node has one of its own clock.
        lesser: parts whose trouble has another consequence, which it names itself.
    """

    def __init__(
        self, node: Node, parts: tuple[str, ...], consequence: str, said: Any = None, *lesser: str
    ) -> None:
        self._node, self._consequence, self._lesser = node, consequence, lesser
        self._problems, self._cautions = dict.fromkeys(parts, ""), dict.fromkeys(parts, "")
        self._troubles = dict.fromkeys(parts, 0)
        self._sources: dict[str, list[Source]] = {part: [] for part in parts}
        self._values: dict[str, list[Values]] = {part: [] for part in parts}
        self._logged: dict[tuple[str, str], float] = {}  # when, by part and sort of trouble
        self._standing: dict[str, int] = {}  # since when [ns] a source has said something, or `LOGGED`
        self._publisher = publisher(node, topics.DIAGNOSTICS) if said is None else said
        self._changed, self._published = True, -NS_PER_S

    def watch(self, part: str, *sources: Source, values: Values | None = None) -> None:
        """Tell of a part what its sources say, and what a function gives: values by names with units.

        They are asked when a diagnostic is published, and only then.
        """
        self._sources[part] += sources
        self._values[part] += [values] if values is not None else []

    def note(self, part: str, problem: str) -> None:
        """Note what is wrong with a part, "" for nothing."""
        problem = problem if len(problem) <= LONGEST else f"{problem[:LONGEST]}..."
        if bool(problem) != bool(self._problems[part]):
            self._changed = True
            self._troubles[part] += bool(problem)
        if problem and self._is_news(part, problem):
            self._node.get_logger().warning(
                problem if part in self._lesser else f"{self._consequence}: {problem}"
            )
        self._problems[part] = problem

    def note_all(self, problems: Mapping[str, str]) -> None:
        """Note what is wrong with each of some parts."""
        for part, problem in problems.items():
            self.note(part, problem)

    def warn(self, part: str, caution: str) -> None:
        """Note what a person should know of a part that works all the same, "" for nothing."""
        if bool(caution) != bool(self._cautions[part]):
            self._changed = True
        if caution and self._is_news(part, caution):
            self._node.get_logger().warning(caution)
        self._cautions[part] = caution

    def news(self) -> None:
        """Have `publish` tell soon: what a source or a value says has changed."""
        self._changed = True

    def _is_news(self, part: str, problem: str) -> bool:
        """Tell whether a trouble, not yet noted, is of a sort that neither stands nor was just logged."""
        now, sort = time.monotonic(), _sort(part, problem)
        standing = {_sort(*told) for told in (*self._problems.items(), *self._cautions.items())}
        self._logged = {
            one: when for one, when in self._logged.items() if one in standing or now - when < QUIET
        }
        if sort in self._logged or len(self._logged) >= MOST_SORTS:
            return False
        self._logged[sort] = now
        return True

    def publish(self, stamp_ns: int) -> None:
        """Tell, if there is news or the last time is a second ago; news that follow news wait a little."""
        if abs(stamp_ns - self._published) >= (SOONEST_NS if self._changed else NS_PER_S):
            self._changed, self._published = False, stamp_ns
            self._publisher.publish(self._message(stamp_ns))

    def _message(self, stamp_ns: int) -> Any:
        message = DiagnosticArray()
        message.header.stamp = ns_to_stamp(stamp_ns)
        name = self._node.get_fully_qualified_name().lstrip("/")
        waiting = self._answers(lambda source: source.waiting())
        unheard = self._answers(lambda source: source.unheard())
        self._log_what_stands(_all(waiting), _all(unheard), stamp_ns)
        for part, problem in self._problems.items():
            caution = "; ".join(filter(None, (self._cautions[part], *waiting[part], *unheard[part])))
            level = DiagnosticStatus.WARN if caution else DiagnosticStatus.OK
            if problem:  # who is not heard, or whose clock is another, is the cause of many a silence
                level, caution = DiagnosticStatus.ERROR, "; ".join((problem, *unheard[part]))
            status = DiagnosticStatus(level=level, name=f"{name}: {part}", message=caution or WELL)
            status.hardware_id = name
            status.values = [KeyValue(key=key, value=_text(value)) for key, value in self._told(part).items()]
            message.status.append(status)
        return message

    def _answers(self, ask: Callable[[Source], str]) -> dict[str, list[str]]:
        """Return by part what its sources answer, but for ""."""
        return {part: [text for one in some if (text := ask(one))] for part, some in self._sources.items()}

    def _log_what_stands(self, waiting: Sequence[str], unheard: Sequence[str], stamp_ns: int) -> None:
        """Log once what has been waited for, or not heard, for a while: a graph needs one to start."""
        self._standing = {text: self._standing.get(text, stamp_ns) for text in (*waiting, *unheard)}
        for text, since in self._standing.items():
            if since == LOGGED or stamp_ns - since < PATIENCE_NS:
                continue
            self._standing[text] = LOGGED
            if text in waiting:  # rclpy takes one severity from one line
                self._node.get_logger().info(text)
            else:
                self._node.get_logger().warning(text)

    def _told(self, part: str) -> dict[str, Any]:
        """Return a part's values by their names."""
        found: dict[str, Any] = {}
        for one in self._sources[part]:
            found |= one.values()
        for values in self._values[part]:
            found |= values()
        return found | {"troubles since start": self._troubles[part]}


def _sort(part: str, problem: str) -> tuple[str, str]:
    """Return the sort of a trouble: its part, and its text up to the first number."""
    return part, DIGIT.split(problem, maxsplit=1)[0]


def _all(texts: Mapping[str, Sequence[str]]) -> list[str]:
    return [text for some in texts.values() for text in some]


def _text(value: Any) -> str:
    """Return a value as people read it: true or false, four digits of a number, several with commas."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (tuple, list)):
        return ", ".join(map(_text, value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)
