"""Lines and branches of the safety code that its own tests run: the modules and tests of modules.yaml.

python test/mutation/covered.py [MODULE...]    stems of modules; exit code 1 under `LEAST`
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
LEAST = "100"  # [%] of lines and branches


def main() -> int:
    """Run the tests and print the table; return the exit code."""
    known = yaml.safe_load((HERE / "modules.yaml").read_text("utf-8"))
    chosen = [module for module in known if not sys.argv[1:] or Path(module).stem in sys.argv[1:]]
    tests = sorted({str(ROOT / "test" / test) for module in chosen for test in known[module]})
    modules = ",".join(str(ROOT / "src" / module) for module in chosen)
    with tempfile.TemporaryDirectory() as folder:
        python, data = (sys.executable, "-m"), f"--data-file={folder}/coverage"
        asked = ("run", "--branch", data, f"--include={modules}", "-m", "pytest", "-q", *tests)
        code = subprocess.call([*python, "coverage", *asked], cwd=ROOT)
        report = ("report", "--show-missing", data, f"--fail-under={LEAST}")
        return subprocess.call([*python, "coverage", *report], cwd=ROOT) or code


if __name__ == "__main__":
    sys.exit(main())
