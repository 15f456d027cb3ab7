"""`scripts/station.sh`: which nodes start, and what a person is told."""

import os
import signal
import socket
import urllib.request
import webbrowser

import pytest

from forest_station.station import parse_options, show_line, station_nodes

ADDRESS = "http://127.0.0.1:8080/"


def test_it_starts_the_graph_with_the_simulator_and_the_station_which_is_stopped_first():
    nodes = station_nodes(parse_options([]))
    assert [node.name for node in nodes] == ["station", "cycle", "controller", "valve_driver", "simulator"]
    assert [node.name for node in nodes if not node.needed] == ["cycle"]


def test_joining_it_starts_the_station_alone():
    assert [node.name for node in station_nodes(parse_options(["--join"]))] == ["station"]


def test_the_options_of_the_graph_go_to_its_nodes():
    options = parse_options(
        ["--scheme", "joint", "--profile", "fine", "--machine", "loader", "--port", "9000", "--cycles", "/c"]
    )
    station, cycle, controller, *_ = station_nodes(options)
    assert 'directory:="/c"' in cycle.arguments
    assert 'scheme:="joint"' in controller.arguments
    assert 'profile:="fine"' in controller.arguments
    assert 'machine:="loader"' in station.arguments
    assert "port:=9000" in station.arguments


@pytest.mark.parametrize(
    ("display", "opens", "opened"), [(":0", True, [ADDRESS]), ("", True, []), (":0", False, [])]
)
def test_the_page_is_opened_where_there_is_a_display(monkeypatch, capsys, display, opens, opened):
    found = []
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(webbrowser, "open", found.append)
    show_line("[INFO] something else", opens)
    show_line(f"the page is at {ADDRESS}", opens)
    assert found == opened
    assert ADDRESS in capsys.readouterr().out


def test_one_command_starts_graph_and_page_and_ctrl_c_ends_both(start_process, wait_until, domain_id):
    pytest.importorskip("rclpy")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
        taken = start_process(["-m", "forest_station.station", "--join", "--no-browser", "--port", str(port)])
        assert taken.ended() == 1  # bound, though nobody listens
        assert "cannot be had" in taken.text()
        assert "never awaited" not in taken.text()
    command = ["-m", "forest_station.station", "--no-browser", "--port", str(port)]
    station = start_process(command, env=dict(os.environ))  # all anew, as a user does
    address = f"http://127.0.0.1:{port}/"
    wait_until(lambda: f"the page is at {address}" in station.text())
    with urllib.request.urlopen(address) as answer:
        assert b"<title>" in answer.read()
    assert station.stop(signal.SIGINT) == 0, station.text()
    assert station.text().endswith("stopped\n")
