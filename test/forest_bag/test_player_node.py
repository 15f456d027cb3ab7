"""The player process sends a bag's bytes again, obeys services and parameters, says what it cannot play."""

import signal

import pytest

rclpy = pytest.importorskip("rclpy")

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from forest_bag.read.bag_reader import BagReader
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.serialization.cdr import to_cdr

PERIOD = 5_000_000
N = 60
START = 10**18
SERVICES = ("play_next", "pause", "resume")


def joints(step):
    return messages.joint_state(topics.JOINTS, START + PERIOD * step, (float(step), 0.0, 0.0))


@pytest.fixture
def bag(make_bag):
    return make_bag(
        {
            topics.JOINT_STATES: [(START + PERIOD * step, joints(step)) for step in range(N)],
            topics.ROBOT_DESCRIPTION: [(START + PERIOD, String(data="<robot/>"))],
            topics.unlisted("/theirs", "nobody_msgs/msg/Secret"): [(START, b"\x00\x01\x00\x00abc")],
        },
    )


@pytest.fixture
def play(domain_id, start_process):
    return lambda *arguments: start_process(["-m", "forest_bag.cli.main", "play", *map(str, arguments)])


def test_a_bag_is_heard_as_it_was_recorded(bag, play, peer):
    heard, moved = peer.hear(topics.ROBOT_DESCRIPTION), peer.hear(topics.JOINT_STATES, "/elsewhere")
    times = peer.hear(topics.CLOCK)
    process = play(
        bag, "-m", "/joint_states:=/elsewhere", "--clock", "100", "--wait-for-subscribers", "--stats"
    )
    peer.until(lambda: process.poll() is not None)
    peer.until(lambda: len(moved) == N)
    assert process.returncode == 0, process.text()
    assert moved == [joints(step) for step in range(N)]
    assert [message.data for message in heard] == ["<robot/>"]
    clock = [messages.stamp_to_ns(message.clock) for message in times]
    assert clock == sorted(clock)
    assert START <= clock[0] < clock[-1] <= START + PERIOD * N
    assert "/theirs is not played: its type nobody_msgs/msg/Secret is not installed" in process.text()
    assert f"played {N + 1} messages; late by p50" in process.text()


def test_services_and_parameters_steer_it(bag, play, peer):
    heard, stream = peer.hear(topics.ROBOT_DESCRIPTION), peer.hear(topics.JOINT_STATES)
    # Before the player begins: of a client that comes later it may know too late to answer.
    clients = {name: peer.node.create_client(Trigger, f"/player/{name}") for name in SERVICES}
    parameters = peer.node.create_client(SetParameters, "/player/set_parameters")
    process = play(bag, "--start-paused", "--loop", "--wait-for-subscribers")

    def call(client, request):
        peer.until(client.service_is_ready)
        future = client.call_async(request)
        peer.until(future.done)
        return future.result()

    def trigger(name):
        return call(clients[name], Trigger.Request())

    def put(name, number):
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=number)
        request = SetParameters.Request(parameters=[Parameter(name=name, value=value)])
        return call(parameters, request).results[0]

    assert trigger("play_next").success
    peer.until(lambda: len(stream) == 1)
    assert not heard
    assert trigger("resume").success
    peer.until(lambda: len(stream) > N)  # once around
    assert heard
    assert trigger("pause").message.startswith("paused at 0.")
    refused = put("rate", -1.0)
    assert not refused.successful
    assert refused.reason == "Parameter rate out of range Min: 0.0, Max: 1000000.0, value: -1.0"
    assert not put("seek", 1.0).successful  # the bag is 0.3 s long
    before = len(heard)
    assert put("seek", 0.25).successful
    peer.until(lambda: len(heard) == before + 1)
    last = len(stream)
    assert trigger("play_next").success
    peer.until(lambda: len(stream) == last + 1)
    assert stream[-1].position[0] == 50.0
    assert process.stop(signal.SIGINT) == 0
    assert "played" in process.text()


def test_its_parameters_tell_their_ranges(bag, play, peer):
    process = play(bag, "--start-paused", "--wait-for-subscribers")
    client = peer.node.create_client(DescribeParameters, "/player/describe_parameters")
    peer.until(client.service_is_ready)
    answer = client.call_async(DescribeParameters.Request(names=["rate", "seek"]))
    peer.until(answer.done)
    ranges = [one.floating_point_range[0] for one in answer.result().descriptors]
    whole = pytest.approx(PERIOD * 1e-9 * (N - 1))
    assert [(one.from_value, one.to_value) for one in ranges] == [(0.0, 1e6), (0.0, whole)]
    process.stop(signal.SIGINT)


def test_as_fast_as_possible_loses_nothing(make_bag, play, peer):
    count = 2000
    rows = [(START + PERIOD * step, joints(step)) for step in range(count)]
    heard = []
    name, kind = topics.JOINT_STATES.name, topics.message_class(topics.JOINT_STATES)
    peer.node.create_subscription(kind, name, heard.append, count, raw=True)
    process = play(make_bag({topics.JOINT_STATES: rows}, "long"), "-r", "0", "--wait-for-subscribers")
    peer.until(lambda: len(heard) == count)
    peer.until(lambda: process.poll() is not None)
    assert process.returncode == 0, process.text()
    assert "late" not in process.text()


def test_several_bags_are_bursted_as_one_merged_by_time_under_another_qos(
    make_bag, start_process, peer, tmp_path
):
    first = make_bag({topics.JOINT_STATES: [(START + 2 * step, joints(2 * step)) for step in range(N)]}, "a")
    second = make_bag(
        {topics.JOINT_STATES: [(START + 2 * step + 1, joints(2 * step + 1)) for step in range(N)]}, "b"
    )
    qos = tmp_path / "qos.yaml"
    qos.write_text("/joint_states: {durability: transient_local, depth: 200}")
    late = QoSProfile(depth=200, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    count, heard = N + 7, []
    process = start_process(
        [
            "-m",
            "forest_bag.cli.main",
            "burst",
            str(first),
            str(second),
            "-n",
            str(count),
            "-d",
            "0",
            "--qos-profile-overrides-path",
            str(qos),
        ]
    )
    kind = topics.message_class(topics.JOINT_STATES)
    peer.until(lambda: peer.node.count_publishers("/joint_states"))
    peer.node.create_subscription(kind, "/joint_states", lambda m: heard.append(m.position[0]), late)
    peer.until(lambda: len(heard) == count)
    assert heard == [float(step) for step in range(count)]
    assert process.stop(signal.SIGINT) == 0  # it was paused
    assert f"played {count} messages" in process.text()


def test_a_type_that_was_defined_otherwise_is_warned_of(play, tmp_path):
    typesys = pytest.importorskip("rosbags.typesys")
    writer = BagWriter(tmp_path / "bag")
    good = typesys.get_typestore(typesys.Stores.ROS2_JAZZY).hash_rihs01("std_msgs/msg/String")
    for topic, type_hash in (("/same", good), ("/other", f"RIHS01_{0:064x}"), ("/unknown", "")):
        writer.add_topic(topic, "std_msgs/msg/String", [], type_hash)
        writer.write(topic, to_cdr(String(data="hi")), START, START)
    writer.close()
    process = play(writer.directory, "-d", "0")
    assert process.ended() == 0
    assert process.text().count("another definition") == 1
    assert "/other: std_msgs/msg/String was recorded with another definition" in process.text()


def test_a_damaged_bag_is_refused_with_advice(make_bag, play):
    bag = make_bag({topics.JOINT_STATES: [(START, joints(0))]}, "bag", closed=False)
    process = play(bag)
    assert process.ended() == 2
    assert f"forest-bag recover {bag}" in process.text()
    assert process.text().count("\n") == 1


@pytest.fixture
def changed_bag(tmp_path):
    """Its last chunk but one has a changed byte, which opening it does not meet."""
    writer = BagWriter(tmp_path / "changed", Layout("none", chunk_bytes=1000))
    writer.add_topic("/joint_states", topics.JOINT_STATES.type, [], "")
    for step in range(5 * N):  # more than are read ahead at once
        writer.write("/joint_states", to_cdr(joints(step)), START + PERIOD * step, START + PERIOD * step)
    writer.close()
    with BagReader(writer.directory) as reader:
        (file,) = reader.files
        piece = file.pieces[-2]
    data = bytearray(file.path.read_bytes())
    data[piece.offset + piece.length - 1] ^= 1
    file.path.write_bytes(data)
    return writer.directory


def test_of_a_bag_with_changed_bytes_nothing_is_played(changed_bag, play, peer):
    heard = peer.hear(topics.JOINT_STATES)
    process = play(changed_bag, "-d", "0", "--wait-for-subscribers")
    peer.until(lambda: process.poll() is not None)
    assert process.returncode == 2
    assert "the chunk's checksum is wrong; 'forest-bag recover" in process.text()
    assert process.text().count("\n") == 1
    assert not heard
    unchecked = play(changed_bag, "--no-check", "-r", "0", "--wait-for-subscribers")
    peer.until(lambda: unchecked.poll() is not None)
    assert unchecked.returncode == 1
    peer.until(lambda: heard)
    assert "the chunk's checksum is wrong" in unchecked.text()
