"""Pictures that scripts draw from the machine file and the controller's functions."""

import runpy
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_the_committed_picture_is_what_the_script_draws(tmp_path, monkeypatch):
    drawn = tmp_path / "crane.svg"
    monkeypatch.setattr("sys.argv", ["crane_picture.py", str(drawn)])
    runpy.run_path(str(ROOT / "scripts" / "crane_picture.py"), run_name="__main__")
    committed = ROOT / "docs" / "pictures" / "crane.svg"
    assert drawn.read_text("utf-8") == committed.read_text("utf-8"), "run scripts/crane_picture.py"


def test_what_an_operator_sets_is_drawn(tmp_path, monkeypatch):
    drawn = tmp_path / "operator.png"
    monkeypatch.setattr("sys.argv", ["operator_pictures.py", str(drawn)])
    runpy.run_path(str(ROOT / "scripts" / "operator_pictures.py"), run_name="__main__")
    assert drawn.stat().st_size > 20_000
