"""The frame of every node: how it starts, how it ends, and with which exit code."""

import os
import re
import signal
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from rclpy.executors import SingleThreadedExecutor

from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.runtime import environment, node
from forest_msgs_py.runtime.stop_signals import heeded

HELPERS = Path(__file__).resolve().parents[2] / "helpers"


@pytest.fixture
def talker(domain_id, start_process):
    return lambda *arguments: start_process(["-m", "talker", "--ros-args", *arguments])


@pytest.mark.parametrize("number", heeded())
def test_last_words_are_heard_before_the_node_goes(talker, ros_context, make_node, wait_until, number):
    process = talker()
    listener = make_node("listener")
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(listener)
    heard = []
    ear = node.subscription(listener, topics.VALVE_VOLTAGES, heard.append)
    # Each side finds the other in its own time: what a writer says before its reader knows it is lost.
    wait_until(lambda: "matched" in process.text() and ear.get_publisher_count(), executor=executor)
    process.send_signal(number)
    wait_until(lambda: heard, executor=executor)
    assert process.stop(number) == 0
    assert messages.read_float_array(topics.VALVE_VOLTAGES, heard[0], 1).values == (0.0, 0.0, 0.0)
    assert process.text().split("\n") == ["up", "matched", "last words", ""]
    executor.shutdown()


def test_repeated_signals_do_not_interrupt_the_last_words(talker, wait_until):
    process = talker()
    wait_until(lambda: "up" in process.text())
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT, signal.SIGINT):
        process.send_signal(number)
    assert process.stop() == 0
    assert process.text().count("last words") == 1
    assert "Traceback" not in process.text()


def test_a_node_that_is_aborted_tells_where_it_was(domain_id, start_process, wait_until):
    variables = {**os.environ, "PYTHONPATH": str(HELPERS)}
    del variables["PYTHONFAULTHANDLER"]
    process = start_process(["-m", "talker"], env=variables)
    wait_until(lambda: "up" in process.text())
    assert process.stop(signal.SIGABRT) == -signal.SIGABRT
    assert "in run_node" in process.text()


def test_a_collection_leaves_alone_what_was_made_at_the_start(talker):
    process = talker("-p", "fault:=done")
    assert process.ended() == 0
    frozen, others = map(int, re.search(r"frozen: (\d+) others: (\d+)", process.text()).groups())
    assert others < frozen / 20


def test_a_signal_that_comes_while_the_process_ends_does_not_change_its_exit_code(talker, wait_until):
    process = talker("-p", "fault:=done")
    wait_until(lambda: "last words" in process.text())
    wait_until(lambda: process.poll() is not None or process.send_signal(signal.SIGTERM))
    assert process.returncode == 0


def test_a_bug_in_a_callback_ends_the_node_with_traceback_and_last_words(talker):
    process = talker("-p", "fault:=bug")
    assert process.ended() == 1
    assert "ZeroDivisionError: a bug" in process.text()
    assert process.text().index("last words") > 0


def test_a_failure_is_one_line_and_exit_code_1(talker):
    process = talker("-p", "fault:=failure")
    assert process.ended() == 1
    assert "talker: pump is gone\n" in process.text()
    assert "Traceback" not in process.text()


def test_a_node_that_is_done_ends_with_0(talker):
    process = talker("-p", "fault:=done")
    assert process.ended() == 0
    assert "last words" in process.text()


def test_a_node_that_the_middleware_does_not_let_go_ends_all_the_same(talker):
    process = talker("-p", "fault:=done", "-p", "hangs:=true")
    assert process.ended() == -signal.SIGALRM
    assert process.text().endswith("last words\n")  # no threads, which an operator would read


@pytest.mark.parametrize(
    ("end", "code", "words"),
    [
        ("bug", 1, "ZeroDivisionError: a bug"),
        ("failure", 1, "talker: pump is gone\n"),
        ("done", 0, "last words"),
        ("return", 0, "loop ended"),
    ],
)
def test_a_loop_of_its_own_ends_the_node_as_a_callback_does(talker, end, code, words):
    process = talker("-p", f"loop:={end}")
    assert process.ended() == code
    assert words in process.text()
    assert process.text().count("last words") == 1


def test_a_loop_of_its_own_ends_before_the_last_words(talker, wait_until):
    process = talker("-p", "loop:=wait")
    wait_until(lambda: "up" in process.text())
    assert process.stop() == 0
    assert process.text().index("loop ended") < process.text().index("last words")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("-p", "fault:=fire"), "talker: parameter 'fault' is 'fire'; allowed: one of , bug, failure, done"),
        (("-p",), "talker: failed to initialize rcl"),
        (("--fire",), "talker: unknown ROS arguments ['--fire']; allowed: --ros-args"),
        (("--", "fire"), "talker: unknown argument 'fire'; allowed: --ros-args"),
    ],
)
def test_a_wrong_start_is_one_clear_line_and_exit_code_2(talker, arguments, words):
    process = talker(*arguments)
    assert process.ended() == 2
    assert words in process.text()
    assert "Traceback" not in process.text()


def test_asked_for_help_a_node_says_what_it_is_and_does_not_start(capsys):
    assert node.run_node(environment.prepare_environment, ["node", "--help"]) == 0
    assert capsys.readouterr().out.startswith(environment.__doc__.strip())


def test_names_follow_a_namespace_and_a_remap(talker, make_node, wait_until):
    talker("-r", "__ns:=/crane_1", "-r", "joint_states:=joints")
    listener = make_node("listener")
    for name in ("/crane_1/joints", "/crane_1/valve_voltages"):
        wait_until(lambda name=name: listener.count_publishers(name) == 1)
    assert listener.count_publishers("/joint_states") == 0


def test_the_network_is_closed_unless_opened_on_purpose(monkeypatch):
    def prepared(**given):
        names = ("FOREST_NETWORK", "RMW_IMPLEMENTATION", "ROS_AUTOMATIC_DISCOVERY_RANGE")
        for name in (*names, "FASTRTPS_DEFAULT_PROFILES_FILE"):
            monkeypatch.setenv(name, "")  # so that the test's end restores it
            monkeypatch.delenv(name)
        for name, value in given.items():
            monkeypatch.setenv(name, value)
        environment.prepare_environment()
        return os.environ

    closed = prepared()
    assert closed["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert Path(closed["FASTRTPS_DEFAULT_PROFILES_FILE"]).is_file()
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in prepared(RMW_IMPLEMENTATION="rmw_cyclonedds_cpp")
    assert prepared(ROS_AUTOMATIC_DISCOVERY_RANGE="SUBNET")["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE" not in prepared(FOREST_NETWORK="open")


def test_a_parameter_that_the_node_does_not_have_is_told(talker):
    process = talker("-p", "falt:=bug", "-p", "fault:=done")
    assert process.ended() == 0
    assert "parameter 'falt' is not one of this node's and does nothing; there is 'fault'" in process.text()
    assert "parameter 'fault'" not in process.text()
