"""`forest-control cycle`: what a person reads of cycles, and does to their files."""

import pytest

from forest_control.cli.main import main
from forest_control.taught.cycle import Cycle, Pose
from forest_control.taught.cycle_file import load_cycle, save_cycle


@pytest.fixture
def folder(tmp_path):
    save_cycle(Cycle("stack", (Pose("up", (5.0, 1.0, 1.0), 0.3),), "over the bunk"), tmp_path)
    save_cycle(Cycle("afar", (Pose("out", (50.0, 1.0, 1.0), 0.3),)), tmp_path)
    return tmp_path


def test_the_list_names_length_duration_and_what_is_out_of_reach(folder, capsys):
    assert main(["cycle", "list", "--directory", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["afar", "reach-grasp", "stack", "transport"]
    assert "refused: segment 'out': at" in lines[0]
    assert "1 segments" in lines[2]
    assert lines[2].endswith("over the bunk")


def test_a_check_tells_each_segment_and_fails_with_one_sentence(folder, capsys):
    assert main(["cycle", "check", "reach-grasp", "--directory", str(folder)]) == 0
    assert "grapple close, until confirmed" in capsys.readouterr().out
    assert main(["cycle", "check", "afar", "--directory", str(folder)]) == 1
    assert capsys.readouterr().err.startswith("forest-control: segment 'out'")


def test_a_cycle_is_renamed_but_not_onto_another(folder, capsys):
    before = load_cycle("stack", folder)
    assert main(["cycle", "rename", "stack", "pile", "--directory", str(folder)]) == 0
    assert load_cycle("pile", folder) == before._replace(name="pile")
    assert not (folder / "stack.yaml").exists()
    assert main(["cycle", "rename", "pile", "afar", "--directory", str(folder)]) == 1
    assert "there is one" in capsys.readouterr().err


def test_a_shipped_cycle_is_copied_under_a_name_of_the_users(folder, capsys):
    assert main(["cycle", "rename", "transport", "parked", "--directory", str(folder)]) == 0
    assert capsys.readouterr().out == "transport is shipped and stays; parked is a copy of it\n"
    assert load_cycle("parked", folder).segments == load_cycle("transport", folder).segments
