"""YAML from files that somebody else wrote: whatever is wrong with one, it is told as a `yaml.YAMLError`."""

from pathlib import Path
from typing import Any

import yaml

LARGEST = 1_000_000  # [byte] of a text: what people write has some thousand, and a million take two seconds
MOST_VALUES = 1_000_000  # [1] for which a text may stand: aliases of aliases stand for any number of them


def read_yaml(file: Path) -> Any:
    """Return what stands in a file, of which no more is read than may stand there.

    Raises:
        yaml.YAMLError: as of `parsed`.
        UnicodeDecodeError: it is no text.
        OSError: it cannot be read.
    """
    with file.open("rb") as stream:
        data = stream.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise yaml.YAMLError(f"more than the {LARGEST} bytes that are allowed")
    return parsed(data.decode("utf-8"))


def parsed(text: str, most: int = LARGEST) -> Any:
    """Return what stands in a text.

    Args:
        text: of somebody else.
        most: characters that it may have.

    Raises:
        yaml.YAMLError: it is not YAML, is too long or nested too deeply, holds a date or a number that is
            none, a key that stands twice in its mapping, or aliases that stand for too much.
    """
    if len(text) > most:
        raise yaml.YAMLError(f"more than the {most} characters that are allowed")
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        if _values(node, {}) > MOST_VALUES:
            raise yaml.YAMLError(f"its aliases stand for more than {MOST_VALUES} values, or for themselves")
        return loader.construct_document(node)
    except RecursionError as error:
        raise yaml.YAMLError("nested too deeply") from error
    except (ValueError, OverflowError) as error:
        raise yaml.YAMLError(str(error)) from error
    finally:
        loader.dispose()


def _values(node: yaml.Node, known: dict[int, int]) -> int:
    """Return for how many values a node stands, its aliases followed; too many for one that holds itself."""
    if id(node) not in known:
        known[id(node)] = MOST_VALUES + 1
        if isinstance(node, yaml.MappingNode):
            _refuse_twice(node)
        parts = node.value if isinstance(node, yaml.SequenceNode | yaml.MappingNode) else ()
        nodes = [part for pair in parts for part in pair] if isinstance(node, yaml.MappingNode) else parts
        known[id(node)] = 1 + sum(_values(part, known) for part in nodes)
    return known[id(node)]


def _refuse_twice(mapping: yaml.MappingNode) -> None:
    """Raise YAMLError if a key stands twice: only the last would count."""
    seen: set[tuple[str, str]] = set()
    for key in [key for key, _ in mapping.value if isinstance(key, yaml.ScalarNode)]:
        if (key.tag, key.value) in seen:  # 1 and "1" are two
            raise yaml.YAMLError(f"line {key.start_mark.line + 1}: {key.value!r} stands there twice")
        seen.add((key.tag, key.value))
