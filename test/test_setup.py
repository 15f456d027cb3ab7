"""What scripts/setup.sh installs, and when: only who tests waits for what tests need."""

import ast
import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
OWN = {path.name for path in ROOT.glob("src/forest_*")}
NAMED = {"evdev": "evdev-binary", "foxglove": "foxglove-sdk", "yaml": "pyyaml"}
OPTIONAL = {
    "sympy",
    "pyarrow",
    "dask",
    "distributed",
    "gymnasium",
    "launch",
    "launch_ros",
}  # what needs one says so
toml = pytest.importorskip("tomllib" if sys.version_info >= (3, 11) else "tomli")
EXTRAS = toml.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
LOCKS = [
    ("requirements.lock", "requirements-test.lock"),
    ("requirements-jazzy.lock", "requirements-jazzy-test.lock"),
]


def locked(lock: str) -> set[str]:
    """Names of the distributions that a lock holds."""
    return {
        canonicalize_name(name)
        for name in re.findall(r"^([\w.-]+)==", (ROOT / lock).read_text("utf-8"), re.MULTILINE)
    }


@pytest.mark.parametrize(("run", "test"), LOCKS)
def test_what_only_tests_need_is_in_their_lock_alone(run, test):
    wanted = {canonicalize_name(Requirement(line).name) for line in EXTRAS["test"]} - {"forest-crane"}
    assert wanted <= locked(test)
    assert not locked(run) & locked(test)


def versions(lock: str) -> dict[str, set[str]]:
    """Versions that a lock holds of each distribution; several where Python decides."""
    found: dict[str, set[str]] = {}
    for name, version in re.findall(r"^([\w.-]+)==(\S+)", (ROOT / lock).read_text("utf-8"), re.MULTILINE):
        found.setdefault(canonicalize_name(name), set()).add(version)
    return found


@pytest.mark.parametrize("part", ["", "-test", "-dev"])
def test_the_tools_that_build_the_pages_go_beside_the_other_parts(part):
    others, docs = versions(f"requirements{part}.lock"), versions("requirements-docs.lock")
    assert {name: docs[name] for name in docs if name in others} == {
        name: others[name] for name in others if name in docs
    }


@pytest.mark.parametrize(
    ("script", "part"),
    [
        ("demo", "run"),
        ("graph", "run"),
        ("bags", "run"),
        ("test", "test"),
        ("check", "dev"),
        ("docs", "docs"),
    ],
)
def test_a_script_asks_for_its_part(script, part):
    text = (ROOT / "scripts" / f"{script}.sh").read_text("utf-8")
    assert re.findall(r"^source .*/setup\.sh\" ?(.*)$", text, re.MULTILINE) == [part]


def test_our_modules_import_what_running_installs():
    imported = set()
    for path in ROOT.glob("src/*/forest_*/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                imported.add((node.module or "").partition(".")[0])
    brought = {name.removeprefix("ros-").removeprefix("jazzy-") for name in locked("requirements.lock")}
    others = imported - set(sys.stdlib_module_names) - OWN - OPTIONAL
    assert {canonicalize_name(NAMED.get(name, name)) for name in others} <= brought
    assert "llvmlite" in others


def wheel(folder: Path, name: str) -> str:
    """Make a wheel with one module; return its line in a lock."""
    path, info = folder / f"{name}-1-py3-none-any.whl", f"{name}-1.dist-info"
    files = {
        f"{name}.py": "",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    with zipfile.ZipFile(path, "w") as archive:
        for file, text in files.items():
            archive.writestr(file, text)
        archive.writestr(f"{info}/RECORD", "".join(f"{file},,\n" for file in (*files, f"{info}/RECORD")))
    return f"{name}==1 --hash=sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}\n"


BACKEND = """
import shutil
def build_editable(directory, config_settings=None, metadata_directory=None):
    shutil.copy("wheels/checkout-1-py3-none-any.whl", directory)
    return "checkout-1-py3-none-any.whl"
"""


@pytest.fixture
def checkout(tmp_path):
    """A checkout whose locks name one small wheel each, from a folder, so that nothing is fetched."""
    (tmp_path / "scripts").mkdir()
    shutil.copy(ROOT / "scripts" / "setup.sh", tmp_path / "scripts")
    (tmp_path / "wheels").mkdir()
    for part in ("", "-jazzy", "-test", "-jazzy-test", "-dev", "-docs"):
        (tmp_path / f"requirements{part}.lock").write_text(
            wheel(tmp_path / "wheels", f"part{part.replace('-', '_')}")
        )
    wheel(tmp_path / "wheels", "checkout")
    (tmp_path / "backend.py").write_text(BACKEND)
    (tmp_path / "pyproject.toml").write_text(
        '[build-system]\nrequires = []\nbuild-backend = "backend"\nbackend-path = ["."]\n'
        '[project]\nname = "checkout"\nversion = "1"\n'
    )
    return tmp_path


def test_each_part_is_installed_when_it_is_asked_for_and_once(checkout):
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "ROS_"))}
    told = {"PYTHON": sys.executable, "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(checkout / "wheels")}

    def setup(*part):
        command = ["bash", str(checkout / "scripts" / "setup.sh"), *part]
        return subprocess.run(
            command, env={**kept, **told}, capture_output=True, text=True, check=True
        ).stderr

    def there():
        return {path.stem for path in checkout.glob(".venv/lib/python3*/site-packages/*part*.py")}

    assert "Done." in setup()
    assert there() == {"part"}
    made = (checkout / ".venv" / ".python").stat().st_ino
    assert "what only the tests need" in setup("test")
    assert there() == {"part", "part_test"}
    assert setup("test") == setup() == ""
    setup("dev")
    assert there() == {"part", "part_test", "part_dev"}
    setup("docs")
    assert there() == {"part", "part_test", "part_dev", "part_docs"}
    assert (checkout / ".venv" / ".python").stat().st_ino == made
    (checkout / "requirements-test.lock").write_text(wheel(checkout / "wheels", "part_more"))
    assert setup() == setup("dev") == ""  # what the tests need is no business of the others
    setup("test")
    assert there() == {"part", "part_test", "part_dev", "part_docs", "part_more"}


@pytest.mark.parametrize(("arguments", "code"), [("--help", 0), ("--seeds", 2)])
def test_without_figures_the_page_of_the_faults_stays(tmp_path, arguments, code):
    for folder in ("scripts", "docs/explanation", "bin"):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(ROOT / "scripts/faults.sh", tmp_path / "scripts")
    (tmp_path / "scripts/setup.sh").write_text(f"root={tmp_path} venv={tmp_path}\n", encoding="utf-8")
    page = tmp_path / "docs/explanation/faults.md"
    page.write_text("bounds", encoding="utf-8")
    study = f"#!/bin/sh\necho usage\nexit {code}\n"  # as forest-study ends
    for name, text in (("forest-study", study), ("python", "#!/bin/sh\n")):
        (tmp_path / "bin" / name).write_text(text, encoding="utf-8")
        (tmp_path / "bin" / name).chmod(0o755)
    ended = subprocess.run(["bash", tmp_path / "scripts/faults.sh", arguments], capture_output=True)
    assert ended.returncode == code
    assert page.read_text("utf-8") == "bounds"


@pytest.mark.parametrize("seconds", ["0", "abc", "-5"])
def test_fuzzing_without_an_end_is_refused(tmp_path, seconds):
    (tmp_path / "scripts").mkdir()
    shutil.copy(ROOT / "scripts/fuzz.sh", tmp_path / "scripts")
    stub = f'root={tmp_path} venv={tmp_path}\ndie() {{ echo "$*" >&2; exit 1; }}\n'
    (tmp_path / "scripts/setup.sh").write_text(stub, encoding="utf-8")
    command = ["bash", tmp_path / "scripts/fuzz.sh", seconds]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 1
    assert ended.stderr == f"SECONDS '{seconds}'; allowed: whole, 1 or more\n"
