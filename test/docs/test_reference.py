"""The pages of docs/reference are what the code says."""

import re
import sys
from pathlib import Path

import pytest

from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.joystick_watch import Joystick

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import reference_pages

REFERENCE = ROOT / "docs" / "reference"


@pytest.mark.parametrize("page", reference_pages.MADE)
def test_a_page_is_what_the_code_makes(page):
    made = reference_pages.MADE[page]()
    assert (REFERENCE / page).read_text("utf-8") == made, "run: python scripts/reference_pages.py"


def test_every_program_and_its_commands_are_there():
    page = (REFERENCE / "command-lines.md").read_text("utf-8")
    for heading in ("scripts/demo.sh", "forest-bag record", "forest-ident experiment", "forest-sim modes"):
        assert re.search(rf"^##+ {heading}$", page, re.MULTILINE), heading
    assert "| `--stuck-spools AXES` |" in page


@pytest.mark.parametrize(("title", "codes"), [("Limits", Limit), ("Joystick", Joystick)])
def test_the_status_codes_are_those_of_the_code(title, codes):
    page = (REFERENCE / "codes.md").read_text("utf-8")
    section = page.partition(f"## {title}\n")[2].partition("\n## ")[0]
    told = re.findall(r"^\| (\d) \| (\w+) \|", section, re.MULTILINE)
    assert told == [(str(code.value), code.name.lower()) for code in codes]


def test_every_package_has_its_page_of_the_api():
    packages = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    assert {path.stem for path in (REFERENCE / "api").glob("*.md")} == packages
    for name in packages:
        assert f"::: {name}\n" in (REFERENCE / "api" / f"{name}.md").read_text("utf-8")
