"""Claims about scripts/graph.sh: which nodes its options start, and with what."""

import argparse
import contextlib

import pytest

from forest_bringup import graph, graph_command
from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import Stopped


class Started:
    """Stands where the supervisor would start the processes, and keeps what it was told."""

    def __init__(self):
        self.nodes, self.until, self.ends, self.exit_codes = {}, [], [Stopped()], {"controller": 0}

    def __call__(self, nodes, namespace, logs, may_publish, on_log_line):
        self.nodes = {node.name: node for node in nodes}
        self.namespace, self.logs, self.may_publish = namespace, logs, may_publish
        on_log_line("a line of a node")
        return contextlib.nullcontext(self)

    def run(self, until=None):
        self.until.append(until)
        if end := self.ends.pop(0):
            raise end


@pytest.fixture
def started(monkeypatch):
    told = Started()
    monkeypatch.setattr(graph_command, "Supervisor", told)
    return told


def parameters(node):
    """What stands behind each `-p` of a node."""
    words = node.arguments
    assert words[::2] == ("-p",) * (len(words) // 2)
    return dict(word.split(":=", 1) for word in words[1::2])


def test_without_options_machine_and_control_run_and_joy_is_the_users(started, capsys):
    assert graph.main([]) == 0
    assert list(started.nodes) == ["controller", "valve_driver", "simulator"]
    assert (started.namespace, started.may_publish, started.until) == ("/", True, [None])
    assert parameters(started.nodes["controller"]) == {
        "machine": '"c180"',
        "scheme": '"coordinated"',
        "publish_description": "false",
    }
    assert parameters(started.nodes["valve_driver"]) == {"machine": '"c180"', "shadow": "false"}
    assert parameters(started.nodes["simulator"]) == {"machine": '"c180"'}
    told = capsys.readouterr().out
    assert told.startswith(
        f"starting controller, valve_driver, simulator; logs in {started.logs}; Ctrl-C stops\n"
    )
    assert "a line of a node\n" in told
    assert told.endswith("stopped\n")


def test_every_option_reaches_its_nodes(started, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "levers.csv").touch()
    options = [
        "--machine",
        "loader",
        "--scheme",
        "joint",
        "--namespace",
        "crane/",
        "--joystick",
        "levers.csv",
    ]
    assert graph.main([*options, "--record", "bag", "--shadow", "--foxglove", "8765"]) == 0
    nodes = started.nodes
    assert list(nodes) == [
        "joystick",
        "controller",
        "valve_driver",
        "simulator",
        "viewer",
        "foxglove",
        "recorder",
    ]
    assert (started.namespace, started.may_publish) == ("/crane", False)
    assert started.until[0] == "joystick"
    assert parameters(nodes["joystick"]) == {
        "source": f'"{tmp_path}/levers.csv"',
        "duration": "0.0",
        "wait_for_subscribers": "1",
        "faults": '""',
        "interpolate": "true",
    }
    assert parameters(nodes["controller"])["scheme"] == '"joint"'
    assert {
        parameters(nodes[name])["machine"] for name in ("controller", "valve_driver", "simulator", "viewer")
    } == {'"loader"'}
    assert parameters(nodes["valve_driver"])["shadow"] == "true"
    assert parameters(nodes["recorder"]) == {"output": f'"{tmp_path}/bag"'}
    assert [name for name, node in nodes.items() if not node.needed] == ["viewer", "foxglove", "recorder"]
    assert parameters(nodes["foxglove"]) == {"port": "8765"}


def test_a_monitor_looks_on_where_it_is_asked_for(started):
    assert graph.main(["--monitor", "--machine", "loader"]) == 0
    assert list(started.nodes) == ["controller", "valve_driver", "simulator", "monitor"]
    assert parameters(started.nodes["monitor"]) == {"machine": '"loader"'}


def test_without_a_simulator_the_controller_describes_the_machine(started):
    assert graph.main(["--no-simulator"]) == 0
    assert list(started.nodes) == ["controller", "valve_driver"]
    assert parameters(started.nodes["controller"])["publish_description"] == "true"


def test_a_part_of_the_graph_starts_here_and_only_the_one_with_the_driver_says_zero(started, tmp_path):
    record = ["--record", str(tmp_path / "bag")]
    assert graph.main(["--only", "valve_driver,simulator,recorder", *record]) == 0
    assert (list(started.nodes), started.may_publish) == (["valve_driver", "simulator", "recorder"], True)
    started.ends = [Stopped()]
    assert graph.main(["--only", "controller"]) == 0
    assert (list(started.nodes), started.may_publish) == (["controller"], False)


def test_a_command_of_all_nodes_may_say_zero_unless_it_is_told_otherwise(started):
    assert graph_command.run_command("replay", [], "/", on_log_line=print) == 0
    assert started.may_publish


def test_a_part_that_the_graph_does_not_have_is_refused(started, capsys):
    assert graph.main(["--only", "simulator,recorder,nobody"]) == 2
    told = "graph: --only 'recorder' is no node of this graph; allowed: controller, valve_driver, simulator\n"
    assert capsys.readouterr().err == told
    assert not started.nodes


def test_a_bag_that_exists_is_told_before_anything_starts_here_that_records(started, tmp_path, capsys):
    assert graph.main(["--record", str(tmp_path)]) == 2
    told = f"graph: {tmp_path} exists already; choose another --record or remove it\n"
    assert capsys.readouterr().err == told
    assert not started.nodes
    assert graph.main(["--record", str(tmp_path), "--only", "controller"]) == 0
    assert list(started.nodes) == ["controller"]


def test_each_node_runs_its_module():
    nodes = [graph.joystick("thesis", 3.5, 2, "lost"), *graph.control("c180", "joint", False, False)]
    assert [(node.name, node.module, node.needed) for node in nodes] == [
        ("joystick", "forest_control.joystick_node", True),
        ("controller", "forest_control.controller_node", True),
        ("valve_driver", "forest_control.valve_driver_node", True),
    ]
    assert parameters(nodes[0]) == {
        "source": '"thesis"',
        "duration": "3.5",
        "wait_for_subscribers": "2",
        "faults": '"lost"',
        "interpolate": "true",
    }
    assert graph.simulator("c180").module == "forest_sim.simulator_node"
    monitor = graph.monitor("c180")
    assert (monitor.module, monitor.needed) == ("forest_ident.monitor_node", False)  # the crane works on


def test_a_machine_file_is_named_by_its_whole_path_and_a_shipped_machine_by_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert graph.machine_arguments("mine.yaml") == ("-p", f'machine:="{tmp_path}/mine.yaml"')
    assert graph.machine_arguments("loader") == ("-p", 'machine:="loader"')


@pytest.mark.parametrize(
    ("text", "name"),
    [("/", "/"), ("", "/"), ("crane", "/crane"), ("/crane/", "/crane"), ("a/_b2", "/a/_b2"), ("_", "/_")],
)
def test_a_namespace_has_its_leading_slash(text, name):
    assert graph.ros_namespace(text) == name


@pytest.mark.parametrize("text", ["1crane", "a//b", "a b", "crane/1", "kran-1", "krän", "a/b!"])
def test_what_is_no_namespace_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not a ROS namespace: letters, digits and _"):
        graph.ros_namespace(text)


def test_a_source_is_the_thesis_or_something_that_exists(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bag").mkdir()
    assert graph.source_path("thesis") == "thesis"
    assert graph.source_path("bag") == str(tmp_path / "bag")
    with pytest.raises(
        argparse.ArgumentTypeError, match="'absent' is neither 'thesis' nor a CSV file or bag"
    ):
        graph.source_path("absent")


@pytest.mark.parametrize("error", [GraphError("a node ended"), OSError("a node ended")])
def test_a_failure_is_one_sentence_and_code_one(started, capsys, error):
    started.ends = [error]
    assert graph.main([]) == 1
    assert capsys.readouterr().err == "graph: a node ended\n"


def test_a_node_that_ended_badly_shows_in_the_exit_code(started):
    started.exit_codes = {"controller": 0, "recorder": -9}
    assert graph.main([]) == 1


def test_a_session_that_has_played_to_its_end_is_told_and_ends_well(started, capsys):
    started.ends = [None, Stopped()]
    assert graph.main(["--joystick", "thesis"]) == 0
    assert "the joystick source has played to its end" in capsys.readouterr().out


def test_taught_work_is_a_node_that_the_others_do_without(started, tmp_path):
    assert graph.main(["--cycles", str(tmp_path), "--machine", "loader", "--joystick", "device"]) == 0
    assert list(started.nodes)[:3] == ["cycle", "joystick", "controller"]  # what asks for motion ends first
    cycle = started.nodes["cycle"]
    assert parameters(cycle) == {"machine": '"loader"', "directory": f'"{tmp_path}"'}
    assert not cycle.needed


def test_a_programs_velocity_is_a_node_that_the_others_do_without(started):
    assert graph.main(["--twist"]) == 0
    assert list(started.nodes)[:2] == ["twist", "controller"]
    assert not started.nodes["twist"].needed


@pytest.mark.parametrize(
    ("given", "device"), [("device", "auto"), ("/dev/input/event7", "/dev/input/event7"), ("two.yaml", None)]
)
def test_a_joystick_may_be_a_device_and_the_graph_does_not_wait_for_its_end(
    started, tmp_path, monkeypatch, given, device
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.yaml").touch()
    assert graph.main(["--joystick", given]) == 0
    assert parameters(started.nodes["joystick"]) == {"device": f'"{device or tmp_path / given}"'}
    assert started.nodes["joystick"].urgent
    assert started.until == [None]
    assert "profile" not in parameters(started.nodes["controller"])


@pytest.mark.parametrize("port", [1, 65535])
def test_a_port_is_one_of_tcps(port):
    assert graph.parse_options(["--foxglove", str(port)]).foxglove == port


@pytest.mark.parametrize("port", ["0", "65536", "-1", "1.5", "x"])
def test_what_is_no_port_is_refused(port, capsys):
    with pytest.raises(SystemExit):
        graph.parse_options([f"--foxglove={port}"])
    assert f"'{port}' is not a port; allowed: 1 to 65535" in capsys.readouterr().err
