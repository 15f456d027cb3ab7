"""What a launch file says: read as text, or by ROS's own launch, where that is installed."""

import ast
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from forest_bringup.supervisor import NodeSpec

SOURCES = Path(__file__).resolve().parents[2] / "src"


def arguments_of(file: Path) -> set[str]:
    """The launch arguments of a file, as the options of a program are written."""
    found: dict[str, tuple[str, ...]] = {}
    for statement in ast.parse(file.read_text("utf-8")).body:
        if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
            found[statement.targets[0].id] = ast.literal_eval(statement.value)
    return {name.replace("_", "-") for name in found["VALUES"] + found["FLAGS"]}


def options_of(parse: Callable[[list[str]], object], capsys: pytest.CaptureFixture[str]) -> set[str]:
    """The options of a program, by its help."""
    with pytest.raises(SystemExit):
        parse(["--help"])
    return set(re.findall(r"--([a-z-]+)", capsys.readouterr().out)) - {"help"}


def is_installed(spec: NodeSpec) -> bool:
    """Whether a node is an executable of its package."""
    package, executable = spec.module.split(".")
    installed = (SOURCES / package / "setup.py").read_text("utf-8")
    return f'"{executable} = {package}.{executable}:main"' in installed


def launched(file: Path, given: dict[str, str]) -> list[str]:
    """The executables that ROS's launch would start; without launch the test is skipped."""
    launch: Any = pytest.importorskip("launch")
    pytest.importorskip("launch_ros")
    source = launch.launch_description_sources.PythonLaunchDescriptionSource(str(file))
    context = launch.LaunchContext()
    description = source.get_launch_description(context)
    for argument in description.get_launch_arguments():
        default = "".join(part.text for part in argument.default_value)
        context.launch_configurations[argument.name] = given.get(argument.name, default)
    return [node.node_executable for node in description.entities[-1].execute(context)]
