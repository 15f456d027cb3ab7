"""The joystick node's command line beside ROS's arguments."""

import argparse
from collections.abc import Sequence

from forest_control.config.joystick_file import AUTO


def ros_arguments(arguments: Sequence[str], description: str) -> list[str]:
    """Return a command line with `--device [DEVICE]` as the parameter that it stands for."""
    parser = argparse.ArgumentParser(prog="joystick_node", description=description, allow_abbrev=False)
    parser.add_argument(
        "--device",
        nargs="?",
        const=AUTO,
        metavar="DEVICE|FILE.yaml",
        help="read a device below /dev/input, or those of a mapping file; no value: the only gamepad",
    )
    given, others = parser.parse_known_args(arguments)
    named = ["--ros-args", "-p", f"device:={given.device}", "--"] if given.device else []
    return [*named, *others]
