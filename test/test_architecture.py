"""The rules that no single package can keep: who may know ROS, and that the manifests tell the truth."""

import ast
import re
import sys
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(path.parent.name for path in ROOT.glob("src/*/package.xml"))
SHELLS = {("forest_bag", "timeseries"), ("forest_bringup", "graph_monitor")}
ROOMS = {("forest_station", "graph")}
ROS = {
    "ament_index_python",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "rcl_interfaces",
    "rclpy",
    "rosgraph_msgs",
    "rosidl_runtime_py",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "visualization_msgs",
}


parsed = cache(ast.parse)


@cache
def imported(source: str) -> frozenset[str]:
    """Top-level names of every module that a source imports, inside functions too; five claims ask."""
    names = set()
    for node in ast.walk(parsed(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module or "")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            names |= {arg.value for arg in node.args if isinstance(arg, ast.Constant)}
    return frozenset(name.partition(".")[0] for name in names)


def may_know_ros(package: str, path: Path) -> bool:
    """The nodes, the package of messages, the reader of any message, the graph's monitor, a room."""
    if (package, path.parent.name) in ROOMS:
        return True
    return package == "forest_msgs_py" or path.stem.endswith("_node") or (package, path.stem) in SHELLS


def modules(package: str) -> list[Path]:
    return sorted((ROOT / "src" / package / package).rglob("*.py"))


@pytest.mark.parametrize("shell", sorted(ROOT.glob("src/*/*/*_node.py")), ids=lambda path: path.stem)
def test_a_shell_has_no_more_than_120_lines(shell):
    assert shell.read_text("utf-8").count("\n") <= 120


OF_NAMED_TUPLES = {"_asdict", "_field_defaults", "_fields", "_make", "_replace"}


def private_names(source: str, package: str) -> set[str]:
    """Private names of our other packages that a source imports, or takes from what it imports."""
    foreign, found, taken = set(), set(), set()
    for node in ast.walk(parsed(source)):
        if isinstance(node, ast.ImportFrom):
            home = (node.module or "").split(".")
            if home[0] in PACKAGES and home[0] != package:
                foreign |= {alias.asname or alias.name for alias in node.names}
                found |= {*home, *(alias.name for alias in node.names)}
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            taken.add((node.value.id, node.attr))
    found |= {name for owner, name in taken if owner in foreign}
    return {name for name in found - OF_NAMED_TUPLES if re.match("_[^_]", name)}


@pytest.mark.parametrize("package", PACKAGES)
def test_no_private_name_is_taken_from_another_package(package):
    assert {
        path: names for path in modules(package) if (names := private_names(path.read_text("utf-8"), package))
    } == {}


@pytest.mark.parametrize(
    "source",
    ["from forest_sim.a import _b", "from forest_sim._a import b", "from forest_sim import a\na._b()"],
)
def test_a_private_name_of_another_package_is_seen(source):
    assert private_names(source, "forest_study")
    assert not private_names(source, "forest_sim")


def imported_by(package: str) -> set[str]:
    return set().union(*(imported(path.read_text("utf-8")) for path in modules(package)))


def started_by(package: str) -> set[str]:
    """The packages whose nodes it starts, by their modules' names."""
    found = (re.findall(r'"(forest_\w+)\.\w+_node"', path.read_text("utf-8")) for path in modules(package))
    return set().union(*found)


@pytest.mark.parametrize(
    "source",
    [
        "import rclpy",
        "from rclpy.node import Node",
        "def f():\n    import rclpy.qos",
        "import_module('rclpy')",
    ],
)
def test_every_way_to_import_is_seen(source):
    assert "rclpy" in imported(source)


def test_a_similar_name_is_not_ros():
    assert not imported("from . import rclpy\nimport rclpyish") & ROS


@pytest.mark.parametrize("package", PACKAGES)
def test_ros_is_imported_only_by_nodes_messages_and_monitor(package):
    offenders = [
        f"{path.relative_to(ROOT)} imports {', '.join(sorted(names))}"
        for path in modules(package)
        if not may_know_ros(package, path) and (names := imported(path.read_text("utf-8")) & ROS)
    ]
    assert modules(package)
    assert not offenders


def test_the_description_needs_only_numpy_and_yaml():
    assert imported_by("forest_description") - set(sys.stdlib_module_names) <= {
        "forest_description",
        "numpy",
        "yaml",
    }


@pytest.mark.parametrize("package", PACKAGES)
def test_scipy_loads_its_parts_where_they_are_used(package):
    """`import scipy` alone does that: `scipy.stats` takes a second, before any command has begun."""
    part = re.compile(r"^\s*(from|import) scipy\.|^\s*from scipy import", re.MULTILINE)
    assert [path for path in modules(package) if part.search(path.read_text("utf-8"))] == []


def test_only_the_derivation_of_equations_needs_sympy():
    users = {
        path.stem
        for package in PACKAGES
        for path in modules(package)
        if "sympy" in imported(path.read_text("utf-8"))
    }
    assert users == {"graph_run", "merging", "notation", "page", "quadratic", "state_equations", "symbols"}


def test_no_simulation_imports_the_derivation_of_equations():
    """An installation without the extra ``graphs`` must run every node."""
    derivation = re.compile(
        r"^\s*from forest_sim\.linear_graph(\.| import )"
        r"(graph_run|merging|quadratic|state_equations|symbols|notation|page)\b",
        re.MULTILINE,
    )
    users = {
        path.stem
        for package in PACKAGES
        for path in modules(package)
        if derivation.search(path.read_text("utf-8"))
    }
    printed = {"page_text"}  # in the examples that the page shows
    assert users - printed == {"graph_run", "merging", "notation", "page", "quadratic", "state_equations"}


@pytest.mark.parametrize("package", PACKAGES)
def test_the_manifest_names_every_ros_and_own_package_that_is_imported(package):
    manifest = ET.parse(ROOT / "src" / package / "package.xml").getroot()
    declared = {element.text for element in manifest.iter("exec_depend")}
    assert imported_by(package) & (ROS | set(PACKAGES)) - {package} <= declared


@pytest.mark.parametrize("package", PACKAGES)
def test_the_manifest_names_no_own_package_that_is_not_used(package):
    """One too many may close a circle, in which colcon finds no order."""
    manifest = ET.parse(ROOT / "src" / package / "package.xml").getroot()
    declared = {element.text for element in manifest.iter("exec_depend")} & set(PACKAGES)
    assert declared == (imported_by(package) | started_by(package)) & set(PACKAGES) - {package}


def test_colcon_and_pip_install_the_same_executables():
    pip = dict(
        re.findall(
            r'^([\w-]+) = "([\w.]+:main)"$', (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE
        )
    )
    colcon = {}
    for package in PACKAGES:
        colcon |= re.findall(
            r'"([\w-]+) = ([\w.]+:main)"', (ROOT / "src" / package / "setup.py").read_text("utf-8")
        )
    assert len(pip) == 22
    assert colcon == pip


@pytest.mark.parametrize("package", PACKAGES)
def test_all_manifests_carry_one_version(package):
    found = re.search(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    assert found
    manifest = ET.parse(ROOT / "src" / package / "package.xml").getroot()
    assert manifest.findtext("version") == found[1]
    assert f'version="{found[1]}"' in (ROOT / "src" / package / "setup.py").read_text("utf-8")
