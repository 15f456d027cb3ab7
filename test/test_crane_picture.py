"""docs/pictures/crane.svg is what scripts/crane_picture.py draws from the machine file."""

import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_the_committed_picture_is_what_the_script_draws(tmp_path, monkeypatch):
    drawn = tmp_path / "crane.svg"
    monkeypatch.setattr("sys.argv", ["crane_picture.py", str(drawn)])
    runpy.run_path(str(ROOT / "scripts" / "crane_picture.py"), run_name="__main__")
    committed = ROOT / "docs" / "pictures" / "crane.svg"
    assert drawn.read_text("utf-8") == committed.read_text("utf-8"), "run scripts/crane_picture.py"
