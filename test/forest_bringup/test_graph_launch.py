"""The launch file offers what `scripts/graph.sh` offers; ROS's own launch is on no package index."""

import ast
import re
from pathlib import Path

import pytest

from forest_bringup.graph import graph_nodes, parse_options

SOURCES = Path(__file__).resolve().parents[2] / "src"
FILE = SOURCES / "forest_bringup" / "launch" / "graph.launch.py"
WHOLE = ["--joystick", "thesis", "--foxglove", "8765", "--record", "bag"]


def constant(name):
    for statement in ast.parse(FILE.read_text("utf-8")).body:
        if isinstance(statement, ast.Assign) and statement.targets[0].id == name:
            return ast.literal_eval(statement.value)
    raise KeyError(name)


def test_the_arguments_are_the_options_of_graph_sh(capsys):
    with pytest.raises(SystemExit):
        parse_options(["--help"])
    options = set(re.findall(r"--([a-z-]+)", capsys.readouterr().out)) - {"help"}
    assert {name.replace("_", "-") for name in constant("VALUES") + constant("FLAGS")} == options


@pytest.mark.parametrize("spec", graph_nodes(parse_options(WHOLE)), ids=lambda spec: spec.name)
def test_each_node_is_an_executable_of_its_package(spec):
    package, executable = spec.module.split(".")
    installed = (SOURCES / package / "setup.py").read_text("utf-8")
    assert f'"{executable} = {package}.{executable}:main"' in installed


def test_launch_starts_the_nodes_of_graph_sh():
    launch = pytest.importorskip("launch")
    pytest.importorskip("launch_ros")
    source = launch.launch_description_sources.PythonLaunchDescriptionSource(str(FILE))
    context = launch.LaunchContext()
    description = source.get_launch_description(context)
    for argument in description.get_launch_arguments():
        context.launch_configurations[argument.name] = {
            "joystick": "thesis",
            "foxglove": "8765",
            "record": "bag",
        }.get(argument.name, "".join(part.text for part in argument.default_value))
    nodes = description.entities[-1].execute(context)
    assert [node.node_executable for node in nodes] == [
        spec.module.split(".")[1] for spec in graph_nodes(parse_options(WHOLE))
    ]
