"""YAML from files that somebody else wrote: whatever is wrong with one, it is told as a `yaml.YAMLError`."""

from typing import Any

import yaml


def parsed(text: str) -> Any:
    """Return what stands in a text.

    Raises:
        yaml.YAMLError: it is not YAML, is nested too deeply, or holds a date or a number that is none.
    """
    try:
        return yaml.safe_load(text)
    except RecursionError as error:
        raise yaml.YAMLError("nested too deeply") from error
    except (ValueError, OverflowError) as error:
        raise yaml.YAMLError(str(error)) from error
