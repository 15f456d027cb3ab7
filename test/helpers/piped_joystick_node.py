"""`joystick_node` whose only input device is the named pipe of the first argument."""

import sys
from functools import partial
from pathlib import Path
from unittest import mock

from input_events import fifo_listing

from forest_control import joystick_node
from forest_control.operator.input_devices import InputDevices


def main() -> None:
    """Run the node."""
    listing = fifo_listing(Path(sys.argv.pop(1)))
    with mock.patch.object(joystick_node, "InputDevices", partial(InputDevices, listing=listing)):
        joystick_node.main()
