"""The graph under fire: real processes on real DDS, killed in the middle of motion."""

import math
import signal
import time

import pytest
from graph_processes import NODES, alive, kill, nodes_of
from stall import Stall

from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.node import subscription

# What the default machine's parts make the simulator tell.
PARTS = {
    "simulator": {
        f"simulator with {part}"
        for part in ("a hanging head", "a driven pump", "a tank line", "elastic links")
    }
}
ZERO_WITHIN = 0.2  # [s] from the death of any node to the last voltage that is not zero


@pytest.fixture(scope="module")
def rocking(tmp_path_factory):
    """Levers that rock the swing for longer than any test takes; the thesis' session lasts ten seconds."""
    path = tmp_path_factory.mktemp("levers") / "rocking.csv"
    rows = [f"{k / 10:.1f},{0.4 * math.sin(0.1 * math.pi * k):.4f},0,0" for k in range(6000)]
    path.write_text("\n".join(["time_s,swing,boom,stick", *rows, ""]))
    return str(path)


@pytest.fixture
def moving_graph(start_graph, valves, wait_until, tmp_path, rocking):
    """A graph with every node, in the middle of a session."""
    graph = start_graph("--joystick", rocking, "--record", str(tmp_path / "bag"))
    # Driver and guard: whoever dies before the listener has met both is not heard at the end.
    speakers = valves.ear.get_publisher_count

    def moving():
        assert graph.poll() is None, graph.text()
        return valves.opened > valves.shut and speakers() == 2

    wait_until(moving, executor=valves.executor)
    return graph


@pytest.mark.parametrize("victim", [name for name in NODES if name != "recorder"])
def test_killing_any_node_but_the_recorder_shuts_the_valves_and_ends_the_graph_with_its_name(
    moving_graph, valves, wait_until, victim
):
    nodes = nodes_of(moving_graph)
    assert set(nodes) == set(NODES)
    stall = Stall(moving_graph.pid, *nodes.values())
    died = time.monotonic()
    kill(nodes[victim], signal.SIGKILL)
    wait_until(lambda: stall.look() and moving_graph.poll() is not None, executor=valves.executor)
    assert moving_graph.returncode == 1
    assert f"graph: {victim} was killed by SIGKILL" in moving_graph.text()
    wait_until(lambda: valves.shut > max(valves.opened, died), executor=valves.executor)
    assert valves.opened - died - stall.seconds(until=valves.opened) < ZERO_WITHIN
    assert not [name for name, pid in nodes.items() if alive(pid)]


def test_the_graph_goes_on_without_the_recorder_and_says_so(moving_graph, valves, wait_until):
    nodes = nodes_of(moving_graph)
    kill(nodes["recorder"], signal.SIGKILL)
    wait_until(lambda: "the graph goes on" in moving_graph.text(), executor=valves.executor)
    seen, opened = valves.count, valves.opened
    wait_until(lambda: valves.count > seen + 100 and valves.opened > opened, executor=valves.executor)
    assert moving_graph.poll() is None
    kill(moving_graph.pid, signal.SIGTERM)
    wait_until(lambda: moving_graph.poll() is not None, executor=valves.executor)
    assert moving_graph.returncode == 1
    assert moving_graph.text().count("recorder was killed by SIGKILL") == 1
    assert not [name for name, pid in nodes.items() if alive(pid)]


def test_a_terminal_that_is_closed_stops_every_node_and_is_a_good_end(moving_graph, valves, wait_until):
    nodes = nodes_of(moving_graph)
    kill(moving_graph.pid, signal.SIGHUP)
    wait_until(lambda: moving_graph.poll() is not None, executor=valves.executor)
    assert moving_graph.returncode == 0, moving_graph.text()
    assert "stopped" in moving_graph.text()
    wait_until(lambda: valves.shut > valves.opened, executor=valves.executor)
    assert not [name for name, pid in nodes.items() if alive(pid)]


def test_no_node_outlives_a_supervisor_that_is_killed(moving_graph, valves, wait_until):
    nodes = nodes_of(moving_graph)
    kill(moving_graph.pid, signal.SIGKILL)
    wait_until(lambda: not any(alive(pid) for pid in nodes.values()), executor=valves.executor)
    wait_until(lambda: valves.shut > valves.opened, executor=valves.executor)


def test_a_graph_whose_joystick_source_has_played_to_its_end_runs_until_it_is_stopped(
    start_graph, valves, wait_until, levers
):
    graph = start_graph("--joystick", str(levers))
    wait_until(lambda: "played to its end; Ctrl-C stops" in graph.text(), executor=valves.executor)
    seen = valves.count
    wait_until(lambda: valves.count > seen + 100, executor=valves.executor)
    assert graph.poll() is None
    nodes = nodes_of(graph)
    kill(graph.pid, signal.SIGINT)
    wait_until(lambda: graph.poll() is not None, executor=valves.executor)
    assert graph.returncode == 0, graph.text()
    assert nodes
    assert not [name for name, pid in nodes.items() if alive(pid)]


def test_every_node_that_is_not_hidden_offers_its_parameters_and_without_a_joystick_one_is_waited_for(
    start_graph, valves, wait_until
):
    graph, node = start_graph(), valves.node
    names = {"controller", "valve_driver", "simulator"}
    wait_until(lambda: names <= set(node.get_node_names()), executor=valves.executor)
    wait_until(lambda: "waiting for a joystick on /joy" in graph.text(), executor=valves.executor)
    visible = {name for name in node.get_node_names() if not name.startswith("_")} - {node.get_name()}
    assert visible == names
    for name in visible:
        offered = {service for service, _ in node.get_service_names_and_types_by_node(name, "/")}
        assert {f"/{name}/list_parameters", f"/{name}/get_parameters"} <= offered


def test_a_second_graph_is_refused_and_the_first_goes_on_but_another_namespace_is_another_graph(
    start_graph, start_process, valves, wait_until, tmp_path
):
    first = start_graph()
    wait_until(lambda: valves.count > 10, executor=valves.executor)
    second = start_graph()
    assert second.ended() == 1
    assert "a graph is already running in ROS domain" in second.text()
    demo = start_process(["-m", "forest_study.demo.demo", "--out", str(tmp_path / "out")])
    assert demo.ended() == 1
    assert not (tmp_path / "out").exists()
    other, names = start_graph("--namespace", "crane_2"), valves.node
    wait_until(lambda: names.count_publishers("/crane_2/joint_states") == 1, executor=valves.executor)
    assert names.count_publishers("/joint_states") == 1
    assert first.poll() is None
    assert other.poll() is None


def test_a_node_of_ours_that_runs_alone_also_keeps_a_graph_out(
    start_graph, start_process, valves, wait_until
):
    start_process(["-m", "forest_control.valve_driver_node"])
    wait_until(lambda: valves.count > 0, executor=valves.executor)
    refused = start_graph()
    assert refused.ended() == 1
    assert "node valve_driver" in refused.text()


def test_shadow_computes_commands_and_publishes_no_voltage(start_graph, valves, wait_until, rocking):
    start_graph("--shadow", "--joystick", rocking)
    node = valves.node
    heard = []
    subscription(node, topics.VALVE_COMMANDS, lambda message: heard.append(max(map(abs, message.data[2:]))))
    wait_until(lambda: heard and max(heard) > 0.1, executor=valves.executor)
    assert valves.count == 0
    assert node.count_publishers("/valve_voltages") == 0


def test_without_simulator_there_is_no_machine_of_ours_and_the_controller_describes_the_robot(
    start_graph, valves, wait_until
):
    graph, heard = start_graph("--no-simulator"), []
    subscription(valves.node, topics.ROBOT_DESCRIPTION, heard.append)
    wait_until(lambda: valves.count > 5 and heard, executor=valves.executor)
    assert set(nodes_of(graph)) == {"controller", "valve_driver"}
    assert valves.node.count_publishers("/joint_states") == 0
    assert heard[0].data.startswith("<?xml")


def test_nodes_speak_and_listen_as_the_topic_table_says(start_graph, valves, wait_until, rocking):
    start_graph("--joystick", rocking)
    node = valves.node
    speakers, listeners = (
        node.get_publisher_names_and_types_by_node,
        node.get_subscriber_names_and_types_by_node,
    )
    for ours in ("joystick", "controller", "valve_driver", "simulator"):
        for ask, role in ((speakers, "publishers"), (listeners, "subscribers")):
            names = {ours, f"{ours} (live)", *PARTS.get(ours, ())}
            rows = (t for t in topics.TOPICS if names & set(getattr(t, role)))
            expected = {(f"/{t.name.lstrip('/')}", t.type) for t in rows}

            def told(ask=ask, ours=ours):
                known = (
                    {(name, types[0]) for name, types in ask(ours, "/")}
                    if ours in node.get_node_names()
                    else set()
                )
                return {pair for pair in known if pair[0] not in ("/rosout", "/parameter_events")}

            wait_until(lambda: told() == expected, executor=valves.executor)  # noqa: B023  called at once


def test_a_node_that_cannot_start_is_named_with_its_reason(start_graph, tmp_path):
    missing = tmp_path / "no_such_machine.yaml"
    graph = start_graph("--machine", str(missing))
    assert graph.ended() == 1
    assert "no_such_machine.yaml" in graph.text().splitlines()[-1]
    assert "exit code 2" in graph.text()


def test_a_driver_that_hangs_still_ends_in_zero_voltage(moving_graph, valves, wait_until):
    nodes = nodes_of(moving_graph)
    kill(nodes["valve_driver"], signal.SIGSTOP)
    wait_until(lambda: not valves.open, executor=valves.executor)
    kill(moving_graph.pid, signal.SIGTERM)
    wait_until(lambda: moving_graph.poll() is not None, executor=valves.executor)
    wait_until(lambda: valves.shut > valves.opened, executor=valves.executor)
    assert not [name for name, pid in nodes.items() if alive(pid)]
