"""What tests of forest_control's nodes share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest


@pytest.fixture
def start_node(start_process: Callable[..., Any]) -> Callable[..., Any]:
    """Starts a node of forest_control by its module's name; further arguments are ``--ros-args``."""

    def start(module: str, *ros_args: str) -> Any:
        return start_process(["-m", f"forest_control.{module}", "--ros-args", *ros_args])

    return start
