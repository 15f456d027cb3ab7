"""What the supervisor decides, with processes that need no ROS and a guard by hand.

test_supervisor.py has the nodes themselves and the real guard.
"""

import contextlib
import os
import signal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from forest_bringup import supervisor
from forest_bringup.graph_lock import AlreadyRunning, GraphError
from forest_bringup.supervisor import COULD_NOT_START, NodeSpec, Stopped, Supervisor

# Started as `-m NAME --ros-args -r __ns:=... WORDS...`; tells what happens to it in a diary.
NODE = """
import os, pathlib, signal, sys, time
name, words = sys.argv[0].rpartition("/")[2][:-3], sys.argv[4:]
def tell(what):
    with open(os.environ["DIARY"], "a") as diary:
        diary.write(f"{name} {what}\\n")
def end(code):
    tell("ended")
    if "stuck" in words:
        os.kill(os.getpid(), signal.SIGALRM)
    sys.exit(code)
def terminate(*_):
    if "hangs" in words:
        return tell("hangs")
    for word in words:
        if word.startswith("after="):
            while word[6:] + " ended\\n" not in pathlib.Path(os.environ["DIARY"]).read_text():
                time.sleep(0.01)
    end(0)
if "loads" not in words:
    signal.signal(signal.SIGTERM, terminate)
tell("started " + " ".join(sys.argv[1:4]))
for word in words:
    if word.startswith("says="):
        print(word[5:].replace("_", " ").replace("|", "\\n"), flush=True)
if sys.stdin.readline() != "\\n":
    end(0)
tell("released")
for word in words:
    if word.startswith("ends="):
        end(int(word[5:]))
while True:
    time.sleep(10.0)
"""

ENDED_S = 20  # on however busy a machine; usually under 1 s


class GraphMonitor:
    """What the supervisor sees of the graph, and what it says, by hand."""

    def __init__(self):
        self.counts, self.topic, self.zeros, self.on_zero = {}, "", 0, lambda: None
        self.there = True

    def count(self, name):
        return self.counts.get(name, 0)

    def other_publisher(self):
        return self.topic

    def publish_zero(self):
        assert self.there, "said by a guard that has left"
        self.zeros += 1
        self.on_zero()

    def close(self):
        self.there = False


class Clock:
    """Time by hand: it passes only where somebody sleeps."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture(autouse=True)
def limit():
    """A graph that does not end fails its test, rather than hang."""

    def fail(*_):
        pytest.fail(f"did not end within {ENDED_S} s")

    before, left = signal.signal(signal.SIGALRM, fail), signal.alarm(ENDED_S)
    yield
    signal.alarm(left)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def clock(monkeypatch):
    by_hand = Clock()
    monkeypatch.setattr(supervisor, "time", by_hand)
    return by_hand


@pytest.fixture
def diary(tmp_path, monkeypatch):
    """What the nodes have told so far; the limits are short, and no domain is claimed that another uses."""
    path = tmp_path / "diary"
    path.touch()
    monkeypatch.setenv("DIARY", str(path))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "nodes"), prepend=os.pathsep)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(supervisor, "DISCOVERY", 0.02)
    monkeypatch.setattr(supervisor, "ZERO_TIME", 0.03)
    return lambda: path.read_text().splitlines()


@pytest.fixture
def guard(monkeypatch):
    watch = GraphMonitor()

    def join(graph):
        watch.there = True
        graph._stack.callback(watch.close)
        return watch

    monkeypatch.setattr(Supervisor, "_join_ros", join)
    return watch


@pytest.fixture
def graph_of(tmp_path, diary, guard):
    """Makes a supervisor of nodes, told as NAME=WORDS; none of its processes outlives the test."""
    made = []

    def make(options=None, **nodes):
        (tmp_path / "nodes").mkdir(exist_ok=True)
        specs = []
        for name, words in nodes.items():
            (tmp_path / "nodes" / f"{name}.py").write_text(NODE)
            needed = "unneeded" not in words
            specs.append(NodeSpec(name, name, tuple(words.split()), needed))
        made.append(Supervisor(specs, "/crane", tmp_path / "logs" / "log", **(options or {})))
        return made[-1]

    yield make
    for graph in made:
        for process in graph._processes:
            process.popen.kill()
            process.popen.wait()


@pytest.fixture
def told(diary, wait_until):
    """Wait until the nodes have told so many lines that end thus."""

    def wait(what, count=1):
        wait_until(lambda: sum(line.endswith(what) for line in diary()) >= count)

    return wait


def running(graph, told):
    """Enter a graph and wait until each of its nodes has been released."""
    entered = contextlib.ExitStack()
    entered.enter_context(graph)
    told("released", len(graph._specs))
    return entered


def stop_soon(graph, after=1):
    """Progress of `run` that asks for a stop after so many rounds."""
    rounds = []

    def progress():
        rounds.append(1)
        if len(rounds) >= after:
            graph._stop_requested = True

    return progress


def order(diary, what):
    return [line.split()[0] for line in diary() if line.endswith(what)]


def test_the_limits_are_what_the_documents_promise():
    assert supervisor.GRACE == 5.0  # s before a node that hangs is ended
    assert supervisor.LAST_REPORT == 0.5  # s before one that does not say where it hangs is killed
    assert 0.3 <= supervisor.DISCOVERY <= 1.0
    assert supervisor.LOOK_PERIOD <= 1.0
    assert 0.2 <= supervisor.ZERO_TIME <= 0.5
    assert supervisor.LAST_ZERO <= 0.1  # s: as the machine waits for voltages
    assert supervisor.POLL <= 0.01
    assert {signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT} <= {*supervisor.STOP_SIGNALS}


@pytest.mark.parametrize("words", ["ends=0", "ends=3"])
def test_a_needed_node_that_ends_ends_the_graph_at_zero_before_anything_else_is_stopped(
    graph_of, guard, told, diary, words
):
    graph = graph_of(controller=words, simulator="", recorder="unneeded")
    at_first_zero = []
    guard.on_zero = lambda: at_first_zero or at_first_zero.append(order(diary, "ended"))
    with running(graph, told), pytest.raises(GraphError, match="controller ended with exit code"):
        graph.run()
    assert at_first_zero == [["controller"]]
    assert order(diary, "ended") == ["controller", "simulator", "recorder"]
    assert list(graph.exit_codes) == ["controller", "simulator", "recorder"]


def test_zero_is_said_before_the_stop_and_again_when_all_have_ended(graph_of, guard, told, diary):
    graph, said = graph_of(valve_driver="ends=1", simulator=""), []
    guard.on_zero = lambda: said.append(len(order(diary, "ended")))
    with running(graph, told), pytest.raises(GraphError):
        graph.run()
    assert set(said) == {1, 2}


def test_a_driver_that_lives_says_its_zero_before_the_supervisor_does(
    graph_of, guard, told, diary, monkeypatch
):
    monkeypatch.setattr(supervisor, "LAST_ZERO", ENDED_S)
    graph, ended = graph_of(controller="ends=1", valve_driver="", simulator=""), []
    guard.on_zero = lambda: ended or ended.append(order(diary, "ended"))
    with running(graph, told), pytest.raises(GraphError):
        graph.run()
    assert ended == [["controller", "valve_driver"]]


def test_a_driver_that_hangs_does_not_hold_up_the_supervisors_zero(clock, graph_of, guard, told, diary):
    graph, said = graph_of(valve_driver="hangs"), []
    guard.on_zero = lambda: said or said.append(clock.now)
    with running(graph, told):
        graph._publish_zero = guard.publish_zero
        begun = clock.now
        graph._await_driver()
        graph._zero_voltage()
        assert said[0] - begun == pytest.approx(0.1, abs=0.02)
        graph._processes[0].popen.kill()


def test_zero_is_repeated_for_three_tenths_of_a_second(clock, guard, tmp_path):
    graph = Supervisor([], "/crane", tmp_path)
    graph._publish_zero = guard.publish_zero
    graph._zero_voltage()
    assert 25 <= guard.zeros <= 35
    assert clock.now == pytest.approx(1000.3, abs=0.02)


@pytest.mark.parametrize("code", [0, 3])
def test_the_failure_names_the_node_its_end_and_its_last_word_that_is_no_information(graph_of, told, code):
    graph = graph_of(simulator=f"says=[WARN]_warm|[ERROR]_too_hot|[ERROR]_melted|[INFO]_bye ends={code}")
    with running(graph, told), pytest.raises(GraphError) as failed:
        graph.run()
    assert str(failed.value) == f"simulator ended with exit code {code}: [ERROR] melted"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGHUP, signal.SIGABRT, signal.SIGSEGV])
def test_a_node_that_was_killed_is_named_with_the_signal(graph_of, told, number, tmp_path):
    graph, crash = graph_of(simulator="says=[WARN]_warm"), number in (signal.SIGABRT, signal.SIGSEGV)
    where = f"; where it was is at the end of {tmp_path / 'logs/log/simulator.log'}" if crash else ""
    with running(graph, told):
        os.kill(graph._processes[0].popen.pid, number)
        with pytest.raises(GraphError) as failed:
            graph.run()
    assert str(failed.value) == f"simulator was killed by {number.name}{where}"
    assert graph.exit_codes == {"simulator": -number}


def test_a_node_that_is_not_needed_ends_alone_and_is_told_once(graph_of, guard, told, capfd):
    graph = graph_of(simulator="", recorder="unneeded ends=1")
    with running(graph, told):
        graph._processes[1].popen.wait()
        with pytest.raises(Stopped):
            graph.run(progress=stop_soon(graph, 5))
        assert graph._processes[0].popen.poll() is None
    assert guard.zeros == 0
    warning = "warning: recorder ended with exit code 1; the graph goes on without it\n"
    assert capfd.readouterr().err == warning


def test_what_could_not_even_start_ends_the_graph_needed_or_not(graph_of, guard, told):
    graph = graph_of(simulator="", recorder="unneeded ends=2")
    with running(graph, told), pytest.raises(GraphError, match="recorder ended with exit code 2"):
        graph.run()
    assert guard.zeros > 0


def test_the_node_that_is_waited_for_ends_the_run_well_and_only_with_code_zero(graph_of, guard, told):
    graph = graph_of(joystick="ends=0", simulator="")
    with running(graph, told):
        graph._processes[0].popen.wait()
        assert graph.run(until="joystick") is None
        with pytest.raises(Stopped):  # called again, it goes on without that node
            graph.run(progress=stop_soon(graph, 3))
        assert graph._processes[1].popen.poll() is None
    assert guard.zeros == 0
    assert graph.exit_codes == {"joystick": 0, "simulator": 0}


@pytest.mark.parametrize(
    ("until", "words"), [("joystick", "ends=1"), ("simulator", "ends=0"), (None, "ends=0")]
)
def test_any_other_end_of_a_needed_node_is_a_failure(graph_of, told, until, words):
    graph = graph_of(joystick=words, simulator="")
    with running(graph, told), pytest.raises(GraphError, match="joystick"):
        graph.run(until=until)


def test_nodes_are_stopped_in_order_and_those_that_command_at_once_before_the_others(graph_of, told, diary):
    graph = graph_of(
        joystick="after=controller",
        controller="after=valve_driver",
        recorder="",
        valve_driver="",
        simulator="",
    )
    with running(graph, told):
        pass
    assert order(diary, "ended") == ["valve_driver", "controller", "joystick", "recorder", "simulator"]
    assert graph.exit_codes == dict.fromkeys(
        ["joystick", "controller", "recorder", "valve_driver", "simulator"], 0
    )


def test_a_node_that_still_loads_when_it_is_told_to_stop_ends_well(graph_of, told):
    graph = graph_of(simulator="loads")
    with running(graph, told):
        pass
    assert graph.exit_codes == {"simulator": 0}


def test_a_node_that_the_middleware_did_not_let_go_has_ended_well(graph_of, told, capsys):
    graph = graph_of(simulator="stuck ends=0", valve_driver="stuck")
    with running(graph, told):
        graph.run(until="simulator")
    assert graph.exit_codes == {"simulator": 0, "valve_driver": 0}
    assert capsys.readouterr().err == ""


def test_a_node_that_hangs_is_killed_named_and_zero_is_said_after_it(
    graph_of, guard, told, diary, monkeypatch, capsys
):
    monkeypatch.setattr(supervisor, "GRACE", 0.2)
    graph = graph_of(valve_driver="hangs")
    with running(graph, told):
        pass
    assert graph.exit_codes == {"valve_driver": -signal.SIGABRT}
    warning = capsys.readouterr().err
    assert warning.startswith("warning: valve_driver was killed by SIGABRT; where it was is at the end of ")
    assert order(diary, "hangs") == ["valve_driver"]
    assert guard.zeros > 0


def test_a_node_that_is_deaf_to_its_last_question_is_killed(graph_of, told, monkeypatch, capsys):
    monkeypatch.setattr(supervisor, "GRACE", 0.1)
    monkeypatch.setattr(supervisor, "LAST_REPORT", 0.1)
    graph = graph_of(simulator="")
    with running(graph, told):
        os.kill(graph._processes[0].popen.pid, signal.SIGSTOP)
    assert graph.exit_codes == {"simulator": -signal.SIGKILL}
    assert capsys.readouterr().err == "warning: simulator was killed by SIGKILL\n"


def test_after_a_stop_in_which_nothing_hung_nothing_is_said(graph_of, guard, told, capsys):
    with running(graph_of(valve_driver="", simulator=""), told):
        pass
    assert guard.zeros == 0
    assert capsys.readouterr().err == ""


def test_nothing_is_released_and_all_is_stopped_where_a_needed_node_is_there_already(graph_of, guard, diary):
    guard.counts["simulator"] = 1
    graph = graph_of(controller="", simulator="")
    with pytest.raises(AlreadyRunning, match=r"namespace /crane \(node simulator\)"), graph:
        pytest.fail("entered")
    assert not order(diary, "released")
    assert set(graph.exit_codes) == {"controller", "simulator"}
    assert not graph._processes
    assert guard.zeros == 0


def test_a_second_recorder_keeps_nothing_out(graph_of, guard, told):
    guard.counts["recorder"] = 2
    graph = graph_of(simulator="", recorder="unneeded")
    with running(graph, told), pytest.raises(Stopped):
        graph.run(progress=stop_soon(graph))


def test_a_needed_node_that_starts_twice_while_the_graph_runs_ends_it_at_zero(
    graph_of, guard, told, monkeypatch
):
    monkeypatch.setattr(supervisor, "LOOK_PERIOD", 0.0)
    graph = graph_of(controller="", simulator="")

    def progress():
        guard.counts["controller"] = 1 + guard.counts.get("controller", 0)
        assert guard.counts["controller"] <= 2, "two are one too many"

    with running(graph, told), pytest.raises(AlreadyRunning, match="a second node controller"):
        graph.run(progress=progress)
    assert guard.counts["controller"] == 2  # one is our own
    assert guard.zeros > 0
    assert set(graph.exit_codes) == {"controller", "simulator"}


@pytest.mark.parametrize(("alone", "warnings"), [(True, 1), (False, 0)])
def test_a_rival_is_warned_of_once_by_who_is_alone(
    graph_of, guard, told, capfd, monkeypatch, alone, warnings
):
    monkeypatch.setattr(supervisor, "LOOK_PERIOD", 0.0)
    guard.topic = "valve_voltages"
    graph = graph_of({"exclusive": alone}, simulator="")
    with running(graph, told), pytest.raises(Stopped):
        graph.run(progress=stop_soon(graph, 4))
    assert capfd.readouterr().err == "warning: somebody else publishes valve_voltages, too\n" * warnings
    assert guard.zeros == 0


def test_one_graph_alone_in_a_namespace_and_guests_beside_it(graph_of, told):
    first, second = graph_of(simulator=""), graph_of(simulator="")
    guest = graph_of({"exclusive": False}, player="")
    with running(first, told):
        with pytest.raises(AlreadyRunning, match=str(os.getpid())), second:
            pytest.fail("entered")
        assert not second.exit_codes  # not even started
        with guest:
            assert guest._processes
    with second:
        assert second._processes


def test_a_request_to_stop_ends_the_run_and_the_signals_are_as_before(graph_of, told):
    before = {number: signal.getsignal(number) for number in supervisor.STOP_SIGNALS}
    for number in supervisor.STOP_SIGNALS:
        graph = graph_of(simulator="")
        with graph:
            os.kill(os.getpid(), number)
            with pytest.raises(Stopped):
                graph.run()
        assert set(graph.exit_codes) == {"simulator"}
        assert {n: signal.getsignal(n) for n in supervisor.STOP_SIGNALS} == before


def test_a_request_to_stop_is_heard_before_the_next_node_and_while_others_are_looked_for(
    graph_of, guard, diary
):
    graph = graph_of(simulator="", recorder="")
    graph._stop_requested = True
    with pytest.raises(Stopped), graph:
        pytest.fail("entered")
    assert not graph.exit_codes
    graph, asked = graph_of(simulator="", recorder=""), []
    guard.count = lambda name: asked.append(name) or setattr(graph, "_stop_requested", True) or 0
    with pytest.raises(Stopped), graph:
        pytest.fail("entered")
    assert asked == ["simulator", "recorder"]
    assert not order(diary, "released")


def test_a_graph_that_cannot_start_leaves_no_process_no_lock_and_no_signal_handler(
    graph_of, monkeypatch, diary
):
    before = signal.getsignal(signal.SIGTERM)

    def no_ros(self):
        raise GraphError("ROS does not start")

    with monkeypatch.context() as patch:
        patch.setattr(Supervisor, "_join_ros", no_ros)
        graph = graph_of(simulator="")
        with pytest.raises(GraphError, match="ROS does not start"), graph:
            pytest.fail("entered")
    assert not graph._processes
    assert set(graph.exit_codes) == {"simulator"}
    assert signal.getsignal(signal.SIGTERM) is before
    with graph_of(simulator="") as again:
        assert again._processes


def test_a_node_is_told_its_namespace_its_arguments_its_supervisor_and_to_stay_on_this_machine(
    graph_of, told, diary, tmp_path, monkeypatch
):
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    (tmp_path / "nodes").mkdir()
    facts = "os.environ['FOREST_PARENT'], os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'], os.getsid(0)"
    module = f"import os\nprint({facts} == os.getpid(), flush=True)\n" + NODE
    graph = graph_of(simulator="")
    (tmp_path / "nodes" / "simulator.py").write_text(module)
    with running(graph, told):
        assert diary()[0] == "simulator started --ros-args -r __ns:=/crane"
        assert (tmp_path / "logs" / "log" / "simulator.log").read_text() == f"{os.getpid()} LOCALHOST True\n"


def test_what_nodes_log_is_passed_on_also_what_comes_last(graph_of, told):
    heard = []
    graph = graph_of({"on_log_line": heard.append}, simulator="says=one|two")
    with running(graph, told):
        with pytest.raises(Stopped):
            graph.run(progress=stop_soon(graph))
        assert heard == ["one", "two"]
        with graph._processes[0].log.open("a") as log:
            log.write("three\n")
    assert heard == ["one", "two", "three"]


def test_where_the_threads_of_a_crashed_node_were_stays_in_its_log(graph_of, told):
    heard = []
    graph = graph_of({"on_log_line": heard.append}, simulator="says=one|Fatal_Python_error:_Aborted|Thread")
    with running(graph, told):
        with pytest.raises(Stopped):
            graph.run(progress=stop_soon(graph))
        assert heard == ["one"]
        assert "Thread" in graph._processes[0].log.read_text()


def test_only_urgent_nodes_are_hurried(graph_of, monkeypatch):
    hurried = []
    monkeypatch.setattr(supervisor, "raise_priority", hurried.append)
    graph = graph_of(simulator="", recorder="")
    graph._specs = [graph._specs[0]._replace(urgent=True), graph._specs[1]]
    with graph:
        assert hurried == [graph._processes[0].popen.pid]


def test_memory_is_told_of_every_node_that_ran(graph_of, told):
    graph = graph_of(simulator="", recorder="")
    with running(graph, told):
        pass
    assert set(graph.peak_memory_mb) == {"simulator", "recorder"}


@pytest.mark.parametrize("may_publish", [True, False])
def test_the_guard_joins_in_the_graphs_namespace_may_publish_or_not_and_leaves(
    tmp_path, monkeypatch, may_publish
):
    told = []

    class Joined(GraphMonitor):
        def __init__(self, *arguments):
            super().__init__()
            told.append(arguments)

        def close(self):
            told.append("left")

    monkeypatch.setattr("forest_bringup.graph_monitor.GraphMonitor", Joined)
    graph = Supervisor([], "/crane", tmp_path, may_publish)
    assert isinstance(graph._join_ros(), Joined)
    assert told == [("/crane", may_publish)]
    graph._stack.close()
    assert told[1:] == ["left"]


def test_unless_it_is_told_otherwise_a_supervisor_may_publish_and_needs_its_nodes_and_hurries_none(tmp_path):
    assert Supervisor([], "/crane", tmp_path)._may_publish
    assert NodeSpec("name", "module") == ("name", "module", (), True, False)


def test_others_are_looked_for_until_they_have_had_time_to_show_themselves(clock, tmp_path, guard):
    graph, looks = Supervisor([NodeSpec("simulator", "m")], "/crane", tmp_path), []
    graph._monitor = guard
    guard.count = lambda name: looks.append(clock.now) or 0
    graph._refuse_other_graph()
    assert looks[0] == 1000.0
    assert looks[-1] == pytest.approx(1000.6, abs=0.02)
    guard.count = lambda name: int(clock.now > looks[-1] + 0.55)  # shows itself late
    with pytest.raises(AlreadyRunning):
        graph._refuse_other_graph()


def test_later_looks_are_a_second_apart(clock, tmp_path, guard):
    graph, looks = Supervisor([], "/crane", tmp_path), []
    graph._monitor = guard
    guard.other_publisher = lambda: looks.append(clock.now) or ""
    for _ in range(25):
        graph._check_graph()
        clock.sleep(0.1)
    assert looks == pytest.approx([1000.0, 1001.0, 1002.0], abs=0.11)


def test_zero_is_said_when_the_nodes_that_command_have_been_told_to_be_silent(graph_of, guard, told):
    graph = graph_of(controller="", simulator="ends=1")
    guard.on_zero = lambda: graph._processes and graph._processes[0].popen.wait(20.0)
    with running(graph, told), pytest.raises(GraphError, match="simulator"):
        graph.run()
    assert guard.zeros > 0


def test_between_two_looks_at_the_processes_the_supervisor_sleeps(clock, tmp_path, guard):
    graph = Supervisor([], "/crane", tmp_path)
    graph._monitor = guard
    with pytest.raises(Stopped):
        graph.run(progress=stop_soon(graph, 5))
    assert clock.now == pytest.approx(1000.05)


def test_memory_is_noted_while_nodes_run(graph_of, told):
    graph = graph_of(simulator="")
    with running(graph, told):
        assert not graph.peak_memory_mb
        graph._check_graph()
        assert graph.peak_memory_mb["simulator"] > 1.0


def test_a_node_that_hangs_is_killed_also_where_ros_does_not_start(graph_of, diary, monkeypatch, wait_until):
    def no_ros(_graph):
        wait_until(diary)
        raise GraphError("ROS does not start")

    monkeypatch.setattr(supervisor, "GRACE", 0.2)
    monkeypatch.setattr(Supervisor, "_join_ros", no_ros)
    graph = graph_of(simulator="hangs")
    with pytest.raises(GraphError, match="ROS does not start"), graph:
        pytest.fail("entered")
    assert graph.exit_codes == {"simulator": -signal.SIGABRT}


@given(code=st.integers(-64, 255) | st.sampled_from((COULD_NOT_START, 0, 1)), needed=st.booleans())
def test_however_a_node_ends_the_valves_go_to_zero_unless_it_is_not_needed(code, needed, clock, tmp_path):
    graph, zeros = Supervisor([], "/crane", tmp_path), []
    graph._publish_zero = lambda: zeros.append(clock.now)
    (tmp_path / "log").touch()
    process = supervisor._Process(NodeSpec("arm", "arm", needed=needed), None, tmp_path / "log", None)
    if needed or code == COULD_NOT_START:
        with pytest.raises(GraphError, match=r"^arm (was killed by|ended with exit code) \w+"):
            graph._handle_exit(process, code)
        assert zeros[-1] - zeros[0] > 0.5
    else:
        graph._handle_exit(process, code)
        assert zeros == []
