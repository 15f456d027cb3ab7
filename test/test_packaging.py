"""What is not Python must be declared twice, for pip and for colcon, or an installed package lacks it.

A checkout never shows it: an editable install reads the source tree itself.
"""

import ast
import importlib
import re
import sys
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(path.parent.name for path in ROOT.glob("src/*/package.xml"))
LEFT_BY_TOOLS = {"__pycache__", ".mypy_cache", ".ruff_cache"}

# Python 3.10 has no reader of TOML of its own; pytest brings one there.
toml = importlib.import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")
SETUPTOOLS = toml.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]


def data_files(package: str) -> set[str]:
    """What lies beside the modules of a package, as paths from the package's folder."""
    folder = ROOT / "src" / package / package
    files = {path.relative_to(folder) for path in folder.rglob("*") if path.is_file()}
    return {path.as_posix() for path in files if path.suffix != ".py" and not LEFT_BY_TOOLS & {*path.parts}}


def declared_to_pip(package: str) -> list[str]:
    patterns = SETUPTOOLS["package-data"]
    return patterns["*"] + patterns.get(package, [])


def declared_to_colcon(package: str) -> list[str]:
    source = (ROOT / "src" / package / "setup.py").read_text("utf-8")
    (patterns,) = re.findall(r"package_data=\{\s*package: (\[.*?\])\s*\}", source, re.DOTALL)
    return ast.literal_eval(patterns)


def matches(file: str, pattern: str) -> bool:
    """As setuptools does: a star does not reach into a folder."""
    parts, patterns = PurePosixPath(file).parts, PurePosixPath(pattern).parts
    return len(parts) == len(patterns) and all(map(fnmatchcase, parts, patterns))


def missing(files: set[str], patterns: list[str]) -> set[str]:
    return {file for file in files if not any(matches(file, pattern) for pattern in patterns)}


def test_an_undeclared_file_is_found():
    files = {"py.typed", "pumps/ideal.yaml", "pumps/old/ideal.yaml", "machines/c180.yaml"}
    assert missing(files, ["py.typed", "pumps/*.yaml", "*.yaml"]) == {
        "pumps/old/ideal.yaml",
        "machines/c180.yaml",
    }


def test_the_machines_and_the_pumps_are_data_files():
    assert "machines/c180.yaml" in data_files("forest_description")
    assert "pumps/load_sensing.yaml" in data_files("forest_sim")


@pytest.mark.parametrize("declared", [declared_to_pip, declared_to_colcon])
@pytest.mark.parametrize("package", PACKAGES)
def test_every_data_file_is_declared(package, declared):
    assert data_files(package)
    assert not missing(data_files(package), declared(package))


@pytest.mark.parametrize("declared", [declared_to_pip, declared_to_colcon])
@pytest.mark.parametrize("package", PACKAGES)
def test_every_declaration_has_files(package, declared):
    for pattern in declared(package):
        assert any(matches(file, pattern) for file in data_files(package)), pattern


@pytest.mark.parametrize("package", PACKAGES)
def test_pip_installs_marker_and_manifest_where_ros_looks(package):
    installed = SETUPTOOLS["data-files"]
    assert installed["share/ament_index/resource_index/packages"] == ["src/*/resource/*"]
    assert (ROOT / "src" / package / "resource" / package).is_file()
    assert installed[f"share/{package}"] == [f"src/{package}/package.xml"]


def test_pip_finds_the_modules_of_every_package():
    assert set(SETUPTOOLS["packages"]["find"]["where"]) == {f"src/{package}" for package in PACKAGES}
