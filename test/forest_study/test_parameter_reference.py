"""The page of parameters tells what the nodes declare: each node is made, and asked."""

import gc
import importlib
import re
import sys
from pathlib import Path

import pytest

rclpy = pytest.importorskip("rclpy")

from rclpy.signals import SignalHandlerOptions

from forest_bag.play.play_options import PlayOptions
from forest_bag.player_node import PlayerNode
from forest_study.parameter_reference import NODES, node_rows, page

BAG = Path(__file__).resolve().parents[2] / "bags" / "coordinated"
ROS_OWN = {"use_sim_time", "start_type_description_service"}
FREE = {"rate", "seek"}  # the player checks these itself: its descriptors allow whole numbers, too
MADE = {
    "simulator": "forest_sim.simulator_node.SimulatorNode",
    "commander": "forest_sim.commander_node.CommanderNode",
    "joystick": "forest_control.joystick_node.JoystickNode",
    "controller": "forest_control.controller_node.ControllerNode",
    "valve_driver": "forest_control.valve_driver_node.ValveDriverNode",
    "recorder": "forest_bag.recorder_node.RecorderNode",
    "player": "",
    "step_player": "forest_bag.step_player_node.StepPlayerNode",
    "experiment_operator": "forest_ident.experiment_operator_node.ExperimentOperatorNode",
    "online_identification": "forest_ident.online_node.OnlineIdentificationNode",
    "monitor": "forest_ident.monitor_node.MonitorNode",
    "delay": "forest_study.delay_node.DelayNode",
    "cycle": "forest_control.cycle_node.CycleNode",
    "twist": "forest_control.twist_node.TwistNode",
    "viewer": "forest_viewers.viewer_node.ViewerNode",
    "foxglove": "forest_viewers.foxglove_node.FoxgloveNode",
    "station": "forest_station.station_node.StationNode",
}


@pytest.fixture
def made(request, domain_id, tmp_path):
    """A node by its name, with what it cannot do without."""
    voltages = tmp_path / "voltages.csv"
    voltages.write_text("time,swing,boom,stick\n0,0,0,0\n")
    needed = {
        "commander": {"input": voltages},
        "recorder": {"output": tmp_path / "bag"},
        "step_player": {"lockstep": "true", "bag": BAG},
        "experiment_operator": {"lockstep": "true"},
        "foxglove": {"port": 0},
    }
    words = (f"{name}:={value}" for name, value in needed.get(request.param, {}).items())
    rclpy.init(
        args=["--ros-args", *(word for value in words for word in ("-p", value))],
        domain_id=domain_id,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    switch_interval = sys.getswitchinterval()
    try:
        if request.param == "player":
            node = PlayerNode(PlayOptions(bags=(BAG,), delay=1e6))
        else:
            module, _, name = MADE[request.param].rpartition(".")
            node = getattr(importlib.import_module(module), name)()
        yield node
        if request.param in ("player", "recorder"):
            node.stop()
        node.destroy_node()
    finally:
        rclpy.shutdown()
        sys.setswitchinterval(switch_interval)  # the player's
        gc.unfreeze()


@pytest.mark.parametrize("made", MADE, indirect=True)
def test_a_node_declares_what_the_page_tells_of_it(made):
    rows = {row.name: row for row in node_rows(made.get_name())}
    assert set(made.get_parameters_by_prefix("")) - ROS_OWN == set(rows)
    for name, row in rows.items():
        descriptor = made.describe_parameter(name)
        assert descriptor.description == row.description
        assert descriptor.read_only == row.read_only
        if name not in FREE:
            assert descriptor.additional_constraints == f"allowed: {row.allowed}"


def test_the_page_has_every_node_with_its_parameters():
    assert set(NODES) == set(MADE)
    text = page()
    for node in NODES:
        section = text.split(f"## {node}\n")[1].split("\n## ")[0]
        assert re.findall(r"^\| `(\w+)` \|", section, re.MULTILINE) == [row.name for row in node_rows(node)]
    assert "| `tip_speed` | `0.5` | 0.01 .. 3 m/s | yes | tip speed at full deflection [m/s] |" in text
