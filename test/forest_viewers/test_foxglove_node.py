"""The Foxglove server: what a client sees of a graph, and what it may do to it."""

import asyncio
import re
import subprocess
import sys
import threading
import time

import aiohttp
import pytest

pytest.importorskip("rclpy")

import rclpy
from foxglove_client import connected
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.runtime.node import publisher, subscription

# A reply to a node that has not met this one yet, on a busy computer; it asks again.
pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")

STOP, NOT_STOP = b"\0\1\0\0\1", b"\0\1\0\0\0"
LONG = "x" * 50_000
LIMIT_S = 30.0


class Graph:
    """A node that stands for the graph, and what it heard of emergency stops."""

    def __init__(self, node):
        self.node, self.stops = node, []
        node.declare_parameter("speed", 0.5)
        node.create_service(Trigger, "~/mark", self._mark)
        self.joints = publisher(node, topics.JOINT_STATES)
        self.description = publisher(node, topics.ROBOT_DESCRIPTION)
        self.texts = node.create_publisher(String, "texts", 10)
        self._ear = subscription(node, topics.EMERGENCY_STOP, lambda said: self.stops.append(said.data))
        self.description.publish(String(data=robot_description(load_machine("c180_hoses"))))

    @staticmethod
    def _mark(_request, response):
        response.success, response.message = True, "marked"
        return response


@pytest.fixture(scope="module")
def graph(session_domain_id):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=session_domain_id)
    node = Node("crane", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, daemon=True)
    made = Graph(node)
    thread.start()
    yield made
    executor.shutdown()
    thread.join()
    node.destroy_node()
    context.try_shutdown()


def started(tmp_path_factory, session_domain_id, *options):
    """Start a server; give its process and its port."""
    log = tmp_path_factory.mktemp("foxglove") / "log"
    command = [sys.executable, "-m", "forest_viewers.foxglove_node", "--ros-args", "-p", "port:=0", *options]
    with pytest.MonkeyPatch.context() as patch, log.open("w") as sink:
        patch.setenv("ROS_DOMAIN_ID", str(session_domain_id))
        process = subprocess.Popen(command, stdout=sink, stderr=sink)
    end = time.monotonic() + LIMIT_S
    while not (found := re.search(r"ws://127\.0\.0\.1:(\d+)", log.read_text())):
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < end, "it did not start"
        time.sleep(0.01)
    return process, int(found[1])


@pytest.fixture(scope="module")
def port(graph, tmp_path_factory, session_domain_id):
    process, number = started(tmp_path_factory, session_domain_id)
    yield number
    process.terminate()
    assert process.wait(LIMIT_S) == 0


def test_a_topic_comes_with_its_definition_and_is_subscribed_to_while_a_client_wants_it(graph, port):
    name = graph.joints.topic_name

    async def session():
        async with connected(port) as client:
            await client.until(lambda: name in client.channels)
            assert graph.joints.get_subscription_count() == 0
            number = await client.subscribe(name)
            heard = asyncio.ensure_future(client.until(lambda: client.messages[name]))
            while not heard.done():
                graph.joints.publish(messages.joint_state(topics.JOINTS, 7, (0.1, 0.2, 0.3)))
                await asyncio.wait([heard], timeout=0.1)
            await heard
            await client.ask("unsubscribe", subscriptionIds=[number])
            while graph.joints.get_subscription_count():
                await asyncio.sleep(0.01)
            return client.channels[name], client.messages[name][0]

    channel, message = asyncio.run(asyncio.wait_for(session(), LIMIT_S))
    assert (channel["encoding"], channel["schemaName"]) == ("cdr", "sensor_msgs/msg/JointState")
    assert list(message.name) == list(topics.JOINTS)
    assert list(message.position) == [0.1, 0.2, 0.3]
    assert message.header.stamp.nanosec == 7


def test_each_client_gets_what_was_latched_before_it_came(graph, port):
    name = graph.description.topic_name

    async def session():
        async with connected(port) as first, connected(port) as second:
            for client in (first, second):
                await client.subscribe(name)
                await client.until(lambda client=client: client.messages[name])
            return first.messages[name][0].data, second.messages[name][0].data

    text = robot_description(load_machine("c180_hoses"))
    assert asyncio.run(session()) == (text, text)


def test_a_client_that_does_not_read_delays_nobody(graph, port):
    name = graph.texts.topic_name

    async def session():
        async with connected(port) as slow, connected(port) as fast:
            await slow.subscribe(name)
            await fast.subscribe(name)
            while not graph.texts.get_subscription_count():
                await asyncio.sleep(0.01)
            for _ in range(400):  # 20 MB, far more than the sockets hold
                graph.texts.publish(String(data=LONG))
                await asyncio.sleep(0)
            last = String(data="last")
            while not fast.messages[name] or fast.messages[name][-1].data != "last":
                graph.texts.publish(last)
                count = len(fast.messages[name])
                await fast.until(lambda count=count: len(fast.messages[name]) > count)

    asyncio.run(session())


@pytest.mark.parametrize(
    ("protocol", "origin", "status"),
    [
        ("foxglove.websocket.v1", None, 101),
        ("foxglove.sdk.v1", "https://app.foxglove.dev", 101),
        ("foxglove.sdk.v1", "http://localhost:8080", 101),
        ("foxglove.sdk.v1", "file://", 101),
        ("foxglove.sdk.v1", "https://app.foxglove.dev.example.org", 403),
        ("foxglove.sdk.v1", "null", 403),
        ("rosbridge", None, 400),
    ],
)
def test_both_names_of_the_protocol_are_let_in_and_strange_web_pages_are_not(port, protocol, origin, status):
    async def session():
        url, headers = f"ws://127.0.0.1:{port}", {"Origin": origin} if origin else {}
        async with aiohttp.ClientSession() as client:
            try:
                async with client.ws_connect(url, protocols=[protocol], headers=headers) as socket:
                    assert socket.protocol == protocol
                    assert (await socket.receive_json(timeout=LIMIT_S))["op"] == "serverInfo"
                    return 101
            except aiohttp.WSServerHandshakeError as error:
                return error.status

    assert asyncio.run(session()) == status


def test_parameters_are_told_and_set_and_a_refusal_is_shown(graph, port):
    async def session():
        async with connected(port) as client:
            while "/crane.speed" not in client.parameters:
                await client.ask("getParameters", parameterNames=[], id="all")
                client.parameters = {}
                await client.until(lambda: client.parameters)
            await client.ask("subscribeParameterUpdates", parameterNames=["/crane.speed"])
            await client.ask("setParameters", parameters=[{"name": "/crane.speed", "value": 1}])
            await client.until(lambda: client.parameters["/crane.speed"] == 1.0)
            await client.ask("setParameters", parameters=[{"name": "/crane.speed", "value": "fast"}])
            await client.until(lambda: client.warnings)
            return client.warnings

    (warning,) = asyncio.run(session())
    assert warning == "/crane.speed is 'fast'; allowed: a value of type float"
    assert graph.node.get_parameter("speed").value == 1.0


def test_services_are_called_and_who_sends_no_request_gets_a_sentence(graph, port):
    async def session():
        async with connected(port) as client:
            answer = await client.call("/crane/mark")
            return answer, await client.call("/crane/mark", b"")

    answer, sentence = asyncio.run(session())
    assert answer[4] == 1, answer
    assert b"marked" in answer
    assert "no request" in sentence


def test_of_what_clients_publish_only_an_emergency_stop_is_taken(graph, port):
    async def session():
        async with connected(port) as client:
            await client.say("/joy", topics.JOY_TYPE, b"\0\1\0\0")
            await client.until(lambda: client.warnings)
            await client.say("/emergency_stop", topics.EMERGENCY_STOP.type, NOT_STOP)
            await client.until(lambda: len(client.warnings) == 2)
            await client.say("/emergency_stop", topics.EMERGENCY_STOP.type, STOP)
            while not graph.stops:
                await asyncio.sleep(0.01)
            return client.warnings

    joy, reset = asyncio.run(session())
    assert joy == "/joy is not taken from here; allowed: /emergency_stop"
    assert "call the service reset_emergency_stop" in reset
    assert graph.stops == [True]


def test_a_read_only_server_offers_no_service_and_sets_nothing_and_a_taken_port_is_one_sentence(
    graph, port, tmp_path_factory, session_domain_id, start_process, monkeypatch
):
    process, number = started(tmp_path_factory, session_domain_id, "-p", "read_only:=true")

    async def session():
        async with connected(number) as client:
            await client.ask("setParameters", parameters=[{"name": "/crane.speed", "value": 0.1}])
            await client.until(lambda: client.warnings)
            return client.info["capabilities"], client.warnings

    capabilities, warnings = asyncio.run(session())
    process.terminate()
    assert process.wait(LIMIT_S) == 0
    assert "services" not in capabilities
    assert "clientPublish" not in capabilities
    assert warnings == ["this server is read-only: no parameter is set"]
    monkeypatch.setenv("ROS_DOMAIN_ID", str(session_domain_id))
    late = start_process(["-m", "forest_viewers.foxglove_node", "--ros-args", "-p", f"port:={port}"])
    assert late.ended() == 2
    assert f"parameter 'port' is {port}: " in late.text()
