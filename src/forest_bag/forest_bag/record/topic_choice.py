"""Which topics a recorder records."""

import re
from collections.abc import Callable, Sequence

from forest_msgs_py.interfaces.topics import TOPICS, find

_PLAIN_NAME = re.compile(r"[\w/~]+")


class ChoiceError(ValueError):
    """A choice that cannot be made; the text names it."""


class TopicChoice:
    """Decides by name.

    Args:
        resolve: makes a name absolute, as the node sees it.
        namespace: of the recorder.
        topics: only these, if there are any.
        regex: or those that contain this, if it is not empty.
        excluded: never these: names, or regular expressions that a name contains.
        everything: without topics and regex, record all namespaces, not only the recorder's.
    """

    def __init__(
        self,
        resolve: Callable[[str], str],
        namespace: str,
        topics: Sequence[str] = (),
        regex: str = "",
        excluded: Sequence[str] = (),
        everything: bool = False,
    ) -> None:
        self._topics = {resolve(name) for name in topics if name}
        self._regex = compiled(regex) if regex else None
        self._excluded = {resolve(name) for name in excluded if name and _PLAIN_NAME.fullmatch(name)}
        self._patterns = [compiled(text) for text in excluded if not _PLAIN_NAME.fullmatch(text or "a")]
        self._within = "/" if everything else namespace.rstrip("/") + "/"

    def wants(self, name: str, _types: Sequence[str] = ()) -> bool:
        """Whether a topic (resolved name) is to be recorded."""
        if name in self._excluded or any(pattern.search(name) for pattern in self._patterns):
            return False
        if name in self._topics:
            return True
        if any(part.startswith("_") for part in name.split("/")):
            return False
        if self._topics or self._regex is not None:
            return self._regex is not None and bool(self._regex.search(name))
        row = find(name)
        if row is not None and not row.recorded:
            return False
        return name.startswith(self._within) or name in {row.name for row in TOPICS}


def compiled(regex: str) -> re.Pattern[str]:
    """Return a regular expression.

    Raises:
        ChoiceError: it is none.
    """
    try:
        return re.compile(regex)
    except re.error as error:
        raise ChoiceError(f"{regex!r} is not a regular expression: {error}") from error
