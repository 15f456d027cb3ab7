"""The node for taught work, its time and its inputs in the test's hands: what it hears, and what it says."""

import pytest

rclpy = pytest.importorskip("rclpy")

from clock_by_hand import HandClock, to_cdr
from rclpy.parameter import Parameter

from forest_control import cycle_node
from forest_control.operator.levers import BUTTON_COUNT, Levers, axes_from_levers
from forest_control.operator.taught_command import from_values
from forest_control.pipeline.controller_topics import ControllerInputs
from forest_control.taught.cycle import Cycle, Pose
from forest_control.taught.cycle_file import load_cycle, save_cycle
from forest_control.taught.player import Phase
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array, pose_stamped
from forest_msgs_py.types import NS_PER_S, PERIOD

START, REST = (5.5, 0.0, 1.0), Levers(0.0, 0.0, 0.0)


class Publisher:
    """Remembers what is published."""

    def __init__(self):
        self.said = []

    def publish(self, *said):
        self.said.append(said)


class NodeClock(HandClock):
    """A node's clock by hand."""

    def __init__(self):
        super().__init__()
        self.time, self.publishers, self.ticks = 100.0, {}, []

    def stamp(self):
        return round(self.time * NS_PER_S)

    def publisher(self, topic):
        return self.publishers.setdefault(topic.name, Publisher())

    def on(self, _topic, _call):
        """The rig calls by itself."""

    def every(self, _period, call):
        self.ticks.append(call)


class Rig:
    """The node, a controller that tells where the tip is, and a person's joystick."""

    def __init__(self, monkeypatch):
        self.clock, self.armed, self.tip, self.levers, self.down = NodeClock(), True, START, REST, False
        monkeypatch.setattr(cycle_node, "LiveClock", lambda _node: self.clock)
        monkeypatch.setattr(cycle_node, "number_publisher", lambda clock, topic: clock.publisher(topic))
        self.node = cycle_node.CycleNode()

    def ask(self, service, **names):
        values = [Parameter(name, value=value) for name, value in names.items()]
        assert all(result.successful for result in self.node.set_parameters(values))
        return self.node._act(self.node._work.actions[service])

    def once(self, heard=True, gap=PERIOD):
        self.clock.time += gap
        message = topics.message_class(topics.JOY)(
            axes=axes_from_levers(self.levers), buttons=[0] * BUTTON_COUNT
        )
        message.buttons[0] = int(self.down)
        self.clock.put(topics.JOY, message)
        if heard:
            status = (1.0, 0.0, float(self.armed), 1.0, 0.0)
            self.clock.put(topics.CONTROLLER_STATUS, float_array(topics.CONTROLLER_STATUS, 1, status))
        self.node._on_tip(
            to_cdr(pose_stamped(1, "base_link", (*self.tip, 0.0, 0.0, 0.0, 1.0))), self.clock.time
        )

    def said_of_diagnostics(self):
        (message,) = self.clock.publisher(topics.DIAGNOSTICS).said[-1]
        return message.status[0]

    def diagnosed(self):
        told = {pair.key: pair.value for pair in self.said_of_diagnostics().values}
        del told["troubles since start"]
        return told

    @property
    def commands(self):
        return [from_values(values) for _, values in self.clock.publisher(topics.TAUGHT_COMMAND).said]

    @property
    def events(self):
        return [message.data for (message,) in self.clock.publisher(topics.EVENTS).said]

    @property
    def phase(self):
        return self.node._work.phase


@pytest.fixture
def rig(monkeypatch, domain_id, tmp_path):
    rclpy.init(args=["--ros-args", "-p", f"directory:={tmp_path}"], domain_id=domain_id)
    save_cycle(Cycle("go", (Pose("there", (5.5, 0.8, 1.0), 0.3),)), tmp_path)
    try:
        made = Rig(monkeypatch)
        made.once(gap=1.5 * cycle_node.RESTING_PERIOD)
        yield made
        made.node.destroy_node()
    finally:
        rclpy.shutdown()


@pytest.fixture
def running(rig):
    assert rig.ask("play", cycle="go") == (True, "go: play, segment there")
    for _ in range(5):
        rig.once()
    assert rig.phase == Phase.RUNNING
    return rig


def test_a_cycle_is_played_as_pieces_of_its_path_which_the_controller_reads(running):
    (run, first), (_, last) = running.commands[0], running.commands[-1]
    assert run == pytest.approx(running.clock.time, abs=5 * PERIOD)
    assert first.tangent == pytest.approx((0.0, 1.0, 0.0))
    assert 0.0 < first.speed <= last.speed < 0.3
    assert last.left == pytest.approx(0.8, abs=0.05)
    assert "go: play, segment there" in running.events


def test_the_controllers_inputs_read_what_the_node_says(running):
    heard = []

    class Controller:
        def hear_taught(self, *said):
            heard.append(said)

    clock = HandClock()
    clock.lockstep = False
    inputs = ControllerInputs(clock, load_machine("c180_hoses"), 9)
    _, values = running.clock.publisher(topics.TAUGHT_COMMAND).said[-1]
    clock.put(topics.TAUGHT_COMMAND, float_array(topics.TAUGHT_COMMAND, 1, values))
    inputs.read_taught(Controller())
    assert heard == [(*running.commands[-1], 0.0)]
    clock.put(topics.TAUGHT_COMMAND, float_array(topics.TAUGHT_COMMAND, 1, [float("nan")] * 12))
    inputs.read_taught(Controller())
    assert heard[-1][3]


def test_a_stick_pauses_and_the_run_is_ended(running):
    running.levers = Levers(0.0, 0.06, 0.0)
    running.once()
    assert running.phase == Phase.PAUSED
    assert running.commands[-1][1].speed == 0.0
    assert running.events[-1] == "go: paused: a stick moved"


def test_a_controller_that_is_not_armed_or_not_heard_pauses(running):
    for _ in range(25):
        running.once(heard=False)
    assert running.phase == Phase.PAUSED
    assert "the deadman was released" in running.events[-1]
    assert running.ask("resume") == (True, "go: going on")
    for _ in range(3):
        running.once()
    assert running.phase == Phase.RUNNING
    running.armed = False
    running.once()
    assert running.phase == Phase.PAUSED


def test_a_node_that_is_held_up_pauses(running):
    running.once(gap=0.11)
    assert running.phase == Phase.PAUSED
    assert "held up for 0.11 s" in running.events[-1]


def test_the_button_pauses_when_it_goes_down_and_goes_on_when_it_does_again(running):
    running.down = True
    for _ in range(60):
        running.once()
    assert running.phase == Phase.PAUSED
    running.down = False
    running.once()
    running.down = True
    running.once()
    running.once()
    assert running.phase == Phase.RUNNING


def test_at_rest_it_looks_now_and_then_and_under_way_at_each_pose(running):
    seen, read = [], running.node._inputs.seen
    running.node._inputs.seen = lambda *given: seen.append(given) or read(*given)
    for _ in range(8):
        running.once()
    assert len(seen) == 8
    assert running.ask("stop")[0]
    for _ in range(100):
        running.once()
    assert running.phase == Phase.IDLE
    seen.clear()
    for _ in range(8):
        running.once(gap=cycle_node.RESTING_PERIOD / 3.9)
    assert len(seen) == 2


def test_bytes_that_are_no_pose_move_nothing(running):
    before = len(running.commands)
    running.node._on_tip(b"\0\1\0\0 no pose", running.clock.time)
    assert len(running.commands) == before


def test_what_is_driven_is_taught_under_the_labels_name(rig, tmp_path):
    assert rig.ask("record", cycle="new", label="round")[0]
    for k in range(200):
        rig.tip = (5.5, 0.002 * k, 1.0)
        rig.once()
    assert rig.phase == Phase.RECORDING
    assert rig.ask("stop")[0]
    (path,) = load_cycle("new", tmp_path).segments
    assert path.name == "round"
    assert path.points[-1] == pytest.approx((5.5, 0.39, 1.0), abs=0.01)
    assert path.speed == pytest.approx(0.4, rel=0.1)


def test_a_refusal_is_one_sentence(rig):
    assert rig.ask("play", cycle="none")[1].startswith("cycle 'none': there is none in")
    assert rig.ask("resume") == (
        False,
        "nothing waits for a person; allowed: resume after a pause, or at a grapple",
    )
    assert rig.ask("stop")[1].startswith("nothing is taught or played")
    rig.ask("record", cycle="go")
    done, said = rig.ask("stop")
    assert not done
    assert "the tip moved by 0.00 m" in said


def test_diagnostics_tell_what_is_done_and_what_a_person_is_waited_for(running):
    running.clock.ticks[0]()
    assert running.diagnosed() == {"phase": "running", "cycle": "go", "segment": "there"}
    assert running.said_of_diagnostics().message == "well"
    running.levers = Levers(0.0, 0.06, 0.0)
    running.once(gap=0.1)
    running.clock.ticks[0]()  # at once, though the last time is less than a second ago
    assert running.diagnosed()["phase"] == "paused"
    assert running.said_of_diagnostics().message == "go: paused: a stick moved"


def test_a_plan_keeps_to_the_walls_that_the_parameter_names(rig, tmp_path):
    box = tmp_path / "box.yaml"
    box.write_text("boxes: [{lower: [5.0, 0.3, 0.5], upper: [6.0, 0.6, 1.5]}]\n")
    assert "a wall of the work area" in rig.ask("play", cycle="go", workspace=str(box))[1]
    assert rig.ask("play", cycle="go", workspace="")[0]
    (refused,) = rig.node.set_parameters([Parameter("workspace", value="none")])
    assert "neither shipped" in refused.reason


def test_what_is_taught_of_a_shipped_cycle_is_added_to_a_copy(rig, tmp_path):
    assert rig.ask("pose", cycle="transport", label="and on")[0]
    assert [one.name for one in load_cycle("transport", tmp_path).segments] == ["transport", "and on"]


def test_status_and_last_words_are_said(running):
    running.clock.ticks[0]()
    (_, status) = running.clock.publisher(topics.CYCLE_STATUS).said[-1]
    assert status[:3] == (Phase.RUNNING, 1, 1)
    running.node.stop()
    assert running.commands[-1][1].speed == 0.0
    assert running.commands[-1][0] == running.commands[0][0]
