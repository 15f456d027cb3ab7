"""Whose profile a joystick source is played to.

| source | the controller's profile |
|---|---|
| `--profile NAME or FILE` | this |
| the thesis' input | `exact`: its levers are numbers, not sticks |
| a bag's joystick | what was in force when the bag was recorded, so that it repeats |
| a CSV of levers, or a joystick that is there | `default` |
"""

import argparse
from pathlib import Path
from typing import Any

import yaml

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_control.config.profile_file import KEYS, load_profile
from forest_control.config.setting_file import SettingFileError
from forest_control.operator.joystick_bag import is_bag
from forest_msgs_py.interfaces.yaml_text import parsed

OPERATORS = "operator's profile (default: exact for thesis, the recorded one for a bag, else default)"


def add_profile_option(parser: argparse.ArgumentParser, text: str = OPERATORS) -> None:
    """Add `--profile`, with its help."""
    parser.add_argument("--profile", type=_profile, metavar="NAME|FILE", help=text)


def _profile(text: str) -> str:
    """Return the name of a shipped profile, or a file's absolute path.

    Raises:
        argparse.ArgumentTypeError: neither, or something in it is not allowed.
    """
    name = str(Path(text).resolve()) if Path(text).suffix else text
    try:
        load_profile(name)
    except SettingFileError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return name


def profile_for(source: str | None, given: str | None) -> dict[str, Any]:
    """Return the controller's parameters that are its operator's.

    Args:
        source: of the joystick: `thesis`, the path of a CSV file or a bag; None: it is there.
        given: what the user asks for.
    """
    if given is not None:
        return {"profile": given}
    if source == "thesis":
        return {"profile": "exact"}
    return recorded_profile(Path(source)) if source and is_bag(Path(source)) else {}


def recorded_profile(bag: Path) -> dict[str, Any]:
    """Return a profile as the parameters attached to a bag tell it; {} where none are."""
    try:
        with BagReader(bag) as reader:
            attached = [a.data for file in reader.files for a in file.attachments if _told(a.name)]
        tree = parsed(attached[0].decode()) if attached else None
    except (BagError, OSError, UnicodeDecodeError, yaml.YAMLError):
        return {}
    node = next(iter(tree.values()), None) if isinstance(tree, dict) else None
    told = node.get("ros__parameters") if isinstance(node, dict) else None
    return {key: told[key] for key in KEYS if key in told} if isinstance(told, dict) else {}


def _told(name: str) -> bool:
    return name.endswith("/controller.yaml")
