"""A client of the Foxglove protocol, written after its published specification (foxglove.sdk.v1).

Messages are decoded by mcap-ros2-support from the schema that the server tells, as viewers do.
"""

import contextlib
import json
import struct

import aiohttp
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

PROTOCOL = "foxglove.sdk.v1"
MESSAGE, ANSWER = 1, 3  # binary opcodes of the server
SAY, CALL = 1, 2  # of the client
LIMIT_S = 30.0  # at which a test fails rather than hangs


class FoxgloveClient:
    """Keeps what the server tells: channels and services by name, parameters, messages, warnings."""

    def __init__(self, socket):
        self._socket = socket
        self.info, self.channels, self.services, self.parameters = {}, {}, {}, {}
        self.messages, self.answers, self.warnings, self.failures = {}, {}, [], {}
        self._wanted, self._made = {}, 0

    async def until(self, condition):
        """Take in what comes until a condition holds."""
        while not condition():
            told = await self._socket.receive(timeout=LIMIT_S)
            if told.type == aiohttp.WSMsgType.TEXT:
                await self._hear(json.loads(told.data))
            elif told.type == aiohttp.WSMsgType.BINARY:
                self._take(told.data)
            else:
                raise ConnectionError(f"{told.type} instead of a message")

    async def subscribe(self, topic):
        """Subscribe once the topic is there; its messages go to `messages[topic]`."""
        await self.until(lambda: topic in self.channels)
        channel = self.channels[topic]
        schema = Schema(1, channel["schema"].encode(), channel["schemaEncoding"], channel["schemaName"])
        self._wanted[len(self._wanted)] = topic, DecoderFactory().decoder_for(channel["encoding"], schema)
        self.messages[topic] = []
        number = len(self._wanted) - 1
        await self._subscribe(number, topic)
        return number

    async def _subscribe(self, number, topic):
        channel = self.channels[topic]
        await self.ask("subscribe", subscriptions=[{"id": number, "channelId": channel["id"]}])

    async def ask(self, op, **arguments):
        """Send a request."""
        await self._socket.send_json({"op": op, **arguments})

    async def say(self, topic, kind, data):
        """Publish a message on a channel of its own."""
        self._made += 1
        channel = {"id": self._made, "topic": topic, "encoding": "cdr", "schemaName": kind}
        await self.ask("advertise", channels=[channel])
        await self._socket.send_bytes(struct.pack("<BI", SAY, self._made) + data)

    async def call(self, service, request=b"\0\1\0\0"):
        """Call a service; give the answer's bytes, or the sentence of a failure."""
        await self.until(lambda: service in self.services)
        self._made += 1
        head = struct.pack("<BIII", CALL, self.services[service]["id"], self._made, 3)
        await self._socket.send_bytes(head + b"cdr" + request)
        await self.until(lambda: self._made in self.answers or self._made in self.failures)
        return self.answers.get(self._made) or self.failures[self._made]

    async def _hear(self, told):
        match told["op"]:
            case "serverInfo":
                self.info = told
            case "advertise":
                self.channels |= {channel["topic"]: channel for channel in told["channels"]}
                for number, (topic, _) in self._wanted.items():
                    if topic in {channel["topic"] for channel in told["channels"]}:  # again: it was gone
                        await self._subscribe(number, topic)
            case "advertiseServices":
                self.services |= {service["name"]: service for service in told["services"]}
            case "parameterValues":
                self.parameters |= {one["name"]: one.get("value") for one in told["parameters"]}
            case "status":
                self.warnings.append(told["message"])
            case "serviceCallFailure":
                self.failures[told["callId"]] = told["message"]

    def _take(self, data):
        if data[0] == MESSAGE:
            number, _time = struct.unpack_from("<IQ", data, 1)
            topic, decode = self._wanted[number]
            self.messages[topic].append(decode(data[13:]))
        elif data[0] == ANSWER:
            _service, call, size = struct.unpack_from("<III", data, 1)
            self.answers[call] = data[13 + size :]


@contextlib.asynccontextmanager
async def connected(port):
    """A client that has been greeted."""
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(f"ws://127.0.0.1:{port}", protocols=[PROTOCOL], max_msg_size=0) as socket,
    ):
        assert socket.protocol == PROTOCOL
        client = FoxgloveClient(socket)
        await client.until(lambda: client.info)
        yield client
