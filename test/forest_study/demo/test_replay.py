"""Claims about replays: nodes fed with the same say the same; others do not, and it is said where."""

import argparse

import pytest

pytest.importorskip("rclpy")

from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_study import cli
from forest_study.demo import replay


def replayed(bag, start_process, tmp_path, *options):
    """Replay a bag in a process of its own; return it."""
    return start_process(
        ["-m", "forest_study.cli", "replay", str(bag), *options, "--out", str(tmp_path / "out")]
    )


def test_the_controller_alone_repeats_its_output_to_the_last_bit(
    lockstep_bag, domain_id, start_process, tmp_path
):
    done = replayed(lockstep_bag, start_process, tmp_path)
    assert done.ended() == 0, done.text()
    assert "are the same" in done.text()


def test_a_changed_gain_shows_as_a_difference_with_its_place(
    lockstep_bag, domain_id, start_process, tmp_path
):
    changed = ("--set", "controller.position_gain=[2.6, 5.0, 5.0]")
    done = replayed(lockstep_bag, start_process, tmp_path, "--nodes", "controller", "valve_driver", *changed)
    assert done.ended() == 1
    lines = done.text().splitlines()
    differing = [line for line in lines if line.startswith("/") and line.split()[-1] not in ("0", "differ")]
    assert {line.split()[0] for line in differing} == {
        "/valve_commands",
        "/valve_driver/status",
        "/valve_voltages",
    }


def refused(arguments, tmp_path, capsys):
    assert cli.main(["replay", *map(str, arguments), "--out", str(tmp_path / "out")]) == 1
    return capsys.readouterr().err


def test_what_is_no_bag_of_lockstep_is_refused(tmp_path, capsys):
    assert "is no bag" in refused([__file__], tmp_path, capsys)
    writer = BagWriter(tmp_path / "live")
    writer.add_topic("/joy", topics.JOY.type, [offered_qos(topics.JOY)], "")
    writer.write("/joy", b"", 1_700_000_000_000_000_000, 0)
    writer.close()
    assert "was not recorded in lockstep" in refused([tmp_path / "live"], tmp_path, capsys)


def test_a_change_of_a_parameter_that_the_node_does_not_have_is_refused(lockstep_bag, tmp_path, capsys):
    said = refused([lockstep_bag, "--set", "controller.tip_sped=1"], tmp_path, capsys)
    assert "the bag's controller has no parameter 'tip_sped'; allowed: anti_sway" in said
    assert said.count("\n") == 1


def test_a_change_of_a_node_that_is_not_run_is_refused(lockstep_bag, tmp_path, capsys):
    said = refused(
        [lockstep_bag, "--nodes", "valve_driver", "--set", "controller.scheme=joint"], tmp_path, capsys
    )
    assert "--set controller: this node is not run; allowed: valve_driver, or --nodes controller" in said


@pytest.mark.parametrize("text", ["controller", "controller.gain", "pump.gain=1", ".gain=1", "controller.=1"])
def test_a_change_that_names_no_nodes_parameter_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match=r"allowed: NODE\.PARAMETER=VALUE"):
        replay.change(text)
