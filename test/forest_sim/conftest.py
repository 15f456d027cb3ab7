"""What tests of the simulator node share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture
def start_simulator(start_process: Callable[..., Any]) -> Callable[..., Any]:
    """Starts a simulator node; arguments are ``--ros-args``."""

    def start(*ros_args: str) -> Any:
        return start_process(["-m", "forest_sim.simulator_node", "--ros-args", *ros_args])

    return start
