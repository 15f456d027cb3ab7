"""The recorder process hears everybody, loses nothing, closes on a signal, says in one line what is wrong."""

import functools
import random
import string
import struct

import pytest
import yaml

rclpy = pytest.importorskip("rclpy")

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.timeseries import read_bag
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.runtime import node
from forest_msgs_py.runtime.stop_signals import heeded


@pytest.fixture
def speaker(make_node):
    return make_node("speaker")


@pytest.fixture
def record(domain_id, start_process, tmp_path):
    def start(*arguments, output="bag"):
        where = ["-p", f"output:={tmp_path / output}"]
        return start_process(["-m", "forest_bag.recorder_node", "--ros-args", *where, *arguments])

    return start


@pytest.fixture
def ask(speaker, ros_context, wait_until):
    """Calls a service of the recorder; returns whether it did it, and its message."""
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(speaker)

    @functools.cache  # the recorder may know a new client too late to answer it
    def client_of(verb):
        return speaker.create_client(Trigger, f"/recorder/{verb}")

    def call(verb):
        client = client_of(verb)
        wait_until(client.service_is_ready)
        answer = client.call_async(Trigger.Request())
        wait_until(answer.done, executor=executor)
        return answer.result().success, answer.result().message

    yield call
    executor.shutdown()


@pytest.mark.parametrize("number", heeded())
def test_every_message_of_every_topic_is_in_the_bag(record, speaker, wait_until, tmp_path, number):
    # Deep enough for all: a busy machine may not have heard the first when the last is said.
    joints = speaker.create_publisher(topics.message_class(topics.JOINT_STATES), "joint_states", 500)
    description = node.publisher(speaker, topics.ROBOT_DESCRIPTION)
    loose = speaker.create_publisher(
        Float64, "loose", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    )
    description.publish(String(data="<robot/>"))  # before the recorder is there: latched
    process = record()
    wait_until(lambda: joints.get_subscription_count() and loose.get_subscription_count())
    for step in range(500):
        joints.publish(messages.joint_state(topics.JOINTS, step, (step, 0.0, 0.0)))
    probe = tmp_path / "bag" / "bag_0.mcap"
    wait_until(lambda: messages_in(probe, "/joint_states") == 500)
    wait_until(lambda: messages_in(probe, "/robot_description") == 1)
    assert process.stop(number) == 0
    bag = read_bag(tmp_path / "bag")
    assert bag.complete
    assert list(bag.series(topics.JOINT_STATES).column("swing.position")) == list(range(500))
    assert bag.topics["/joint_states"].lost == 0
    assert bag.topics["/robot_description"].count == 1
    assert "/loose" in bag.topics
    assert "/rosout" in bag.topics
    assert all("INFO" in line for line in process.text().splitlines())


def messages_in(file, topic):
    """Messages that a reader finds in a file that is still being written."""
    count = 0
    if not file.exists():
        return 0
    with file.open("rb") as stream:
        try:
            for _, channel, _ in NonSeekingReader(stream).iter_messages(log_time_order=False):
                count += channel.topic == topic
        except (McapError, struct.error):  # the end of an open file may be the middle of a record
            return count
    return count


def test_a_killed_recorder_leaves_a_readable_file(record, speaker, wait_until, tmp_path):
    joints = node.publisher(speaker, topics.JOINT_STATES)
    process = record()
    wait_until(joints.get_subscription_count)
    for step in range(100):
        joints.publish(messages.joint_state(topics.JOINTS, step, (step, 0.0, 0.0)))
    file = tmp_path / "bag" / "bag_0.mcap"
    wait_until(lambda: messages_in(file, "/joint_states") == 100)
    process.kill_group()
    bag = read_bag(tmp_path / "bag")
    assert not bag.complete
    assert list(bag.series(topics.JOINT_STATES).column("swing.position")) == list(range(100))
    assert bag.topics["/joint_states"].lost == 0


def test_services_mark_split_stop_and_start_again(record, speaker, ask, wait_until, tmp_path):
    description = node.publisher(speaker, topics.ROBOT_DESCRIPTION)
    description.publish(String(data="<robot/>"))
    process = record("-p", "event:='log dropped'", "-p", "topics:=[robot_description]")
    wait_until(lambda: messages_in(tmp_path / "bag/bag_0.mcap", "/robot_description") == 1)
    wait_until(lambda: ask("mark") == (True, "marked: log dropped"))
    wait_until(lambda: messages_in(tmp_path / "bag/bag_0.mcap", "/events") == 1)
    assert ask("snapshot") == (
        False,
        "no message waits; allowed: with parameter 'snapshot_seconds' above 0",
    )
    assert ask("split") == (True, f"the next file of {tmp_path / 'bag'} begins")
    assert ask("mark")[0]
    assert ask("start") == (False, f"recording already, to {tmp_path / 'bag'}")
    done, message = ask("stop")
    assert done
    assert message.startswith("recorded ")
    assert ask("mark") == ask("split") == ask("stop") == (False, "not recording")
    assert ask("start") == (True, f"recording to {tmp_path / 'bag_2'}")
    assert process.stop() == 0
    assert messages_in(tmp_path / "bag/bag_1.mcap", "/events") == 1
    assert messages_in(tmp_path / "bag/bag_1.mcap", "/robot_description") == 1
    assert read_bag(tmp_path / "bag").topics["/events"].count == 2
    assert read_bag(tmp_path / "bag_2").complete


def test_a_snapshot_is_what_came_in_the_last_seconds(record, speaker, ask, wait_until, tmp_path):
    depth = speaker.create_publisher(Float64, "depth", 10)
    process = record("-p", "snapshot_seconds:=60.0", "-p", "topics:=[depth]")
    wait_until(depth.get_subscription_count)
    for step in range(5):
        depth.publish(Float64(data=float(step)))
    wait_until(lambda: "wrote the last" in ask("snapshot")[1])
    assert process.stop() == 0
    assert 1 <= read_bag(tmp_path / "bag").topics["/depth"].count <= 5


def test_the_parameters_of_every_node_and_its_machine_are_in_the_bag(
    record, speaker, ros_context, wait_until, tmp_path
):
    speaker.declare_parameter("machine", "loader")
    speaker.declare_parameter("seed", 7)
    executor = SingleThreadedExecutor(context=ros_context)
    executor.add_node(speaker)
    process = record()
    file = tmp_path / "bag/bag_0.mcap"
    wait_until(lambda: file.exists() and b"machine/loader.yaml" in file.read_bytes(), executor=executor)
    executor.shutdown()
    assert process.stop() == 0
    with file.open("rb") as stream:
        reader = make_reader(stream)
        attached = {attachment.name: attachment.data.decode() for attachment in reader.iter_attachments()}
        notes = {note.name: note.metadata for note in reader.iter_metadata()}
    told = yaml.safe_load(attached["parameters/speaker.yaml"])["/speaker"]["ros__parameters"]
    assert (told["machine"], told["seed"]) == ("loader", 7)
    assert "parameters/recorder.yaml" in attached
    assert yaml.safe_load(attached["machine/loader.yaml"])
    assert notes["forest_seeds"] == {"/speaker": "7"}
    assert "python" in notes["forest_versions"]


def test_a_namespace_and_the_excluded_are_kept_to(record, speaker, wait_until, tmp_path):
    mine = speaker.create_publisher(Float64, "/crane_1/mine", 10)
    left_out = speaker.create_publisher(Float64, "/crane_1/left_out", 10)
    others = speaker.create_publisher(Float64, "/crane_2/others", 10)
    process = record("-r", "__ns:=/crane_1", "-p", "exclude:=[left_out]")
    wait_until(mine.get_subscription_count)
    assert process.stop() == 0
    recorded = set(read_bag(tmp_path / "bag").topics)
    assert "/crane_1/mine" in recorded
    assert "/rosout" in recorded
    assert not recorded & {"/crane_1/left_out", "/crane_2/others"}
    assert left_out.get_subscription_count() == others.get_subscription_count() == 0


def test_latecomers_are_heard_and_a_best_effort_one_beside_a_reliable_publisher(
    record, speaker, wait_until, tmp_path
):
    first = speaker.create_publisher(Float64, "shared", 10)
    process = record()
    wait_until(first.get_subscription_count)
    second = speaker.create_publisher(
        Float64, "shared", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    )
    late = speaker.create_publisher(String, "late", 10)
    wait_until(lambda: second.get_subscription_count() and late.get_subscription_count())
    assert process.stop() == 0
    assert {"/shared", "/late"} <= read_bag(tmp_path / "bag").topics.keys()
    with (tmp_path / "bag/bag_0.mcap").open("rb") as stream:
        channels = make_reader(stream).get_summary().channels.values()
    (last,) = [c.metadata for c in channels if c.topic == "/shared"][-1:]
    words = [profile["reliability"] for profile in yaml.safe_load(last["offered_qos_profiles"])]
    assert sorted(words) == ["best_effort", "reliable"]
    assert last["topic_type_hash"].startswith("RIHS01_")


def test_log_times_by_clock_and_a_subscription_of_another_qos(domain_id, start_process, peer, tmp_path):
    """The publisher of `loose` offers best effort: who asks for more hears nothing of it."""
    qos = tmp_path / "qos.yaml"
    qos.write_text("/loose: {reliability: reliable}")
    options = [
        "--use-sim-time",
        "--qos-profile-overrides-path",
        str(qos),
        "--topics",
        "/joint_states",
        "/loose",
    ]
    process = start_process(["-m", "forest_bag.cli.main", "record", "-o", str(tmp_path / "bag"), *options])
    loose = peer.node.create_publisher(
        Float64, "loose", QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    )
    joints, clock = peer.speak(topics.JOINT_STATES), peer.speak(topics.CLOCK)
    peer.until(lambda: clock.get_subscription_count() == 2)  # the recorder's, and rclpy's own
    probe = tmp_path / "bag" / "bag_0.mcap"
    joints.publish(messages.joint_state(topics.JOINTS, 1, (-1.0, 0.0, 0.0)))  # before the first time
    for step in range(3):
        clock.publish(topics.message_class(topics.CLOCK)(clock=messages.ns_to_stamp(700 + 100 * step)))
        joints.publish(messages.joint_state(topics.JOINTS, 1, (float(step), 0.0, 0.0)))
        loose.publish(Float64(data=1.0))
        peer.until(lambda: messages_in(probe, "/joint_states") == step + 1)  # noqa: B023
    assert process.stop() == 0
    with BagReader(tmp_path / "bag") as bag:
        told = [(m.channel.topic, m.log_ns) for m in bag.messages() if m.channel.topic != "/events"]
    assert told == [("/joint_states", 700), ("/joint_states", 800), ("/joint_states", 900)]


@pytest.mark.parametrize(
    ("output", "words"),
    [("here", "here exists; allowed: a directory"), ("file/bag", "allowed: a directory that does not exist")],
)
def test_a_wrong_output_is_one_clear_line_and_exit_code_2(record, tmp_path, output, words):
    (tmp_path / "here").mkdir()
    (tmp_path / "file").touch()
    process = record(output=output)
    assert process.ended() == 2
    assert process.text().startswith("recorder_node: parameter 'output' is ")
    assert words in process.text()
    assert process.text().count("\n") == 1


def test_a_full_disk_ends_the_recorder_with_one_clear_line(
    domain_id, start_process, speaker, wait_until, tmp_path
):
    """The file may grow to 64 KiB only (RLIMIT_FSIZE), which the kernel refuses as it refuses a full disk."""
    limited = (
        "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536)); "
        "from forest_bag.recorder_node import main; sys.argv[0] = 'recorder_node'; sys.exit(main())"
    )
    output = ["--ros-args", "--disable-external-lib-logs", "-p", f"output:={tmp_path / 'bag'}"]
    process = start_process(["-c", limited, *output])
    noise = speaker.create_publisher(String, "noise", 10)
    wait_until(noise.get_subscription_count)
    generator = random.Random(1)
    for _ in range(10):
        noise.publish(String(data="".join(generator.choices(string.printable, k=60000))))
    assert process.ended() == 1
    assert "cannot write the bag in" in process.text()
    assert "messages" in process.text()
    assert "Traceback" not in process.text()
    read_bag(tmp_path / "bag")
