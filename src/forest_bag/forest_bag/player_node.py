"""The player node: raw bytes from a bag onto their topics, with the QoS they were recorded with.

Playing runs in a thread of its own; the executor serves rosbag2's services, or Triggers (pause, resume,
toggle_paused, play_next) where its interfaces are not installed, and the parameters rate and seek.
"""

import sys
import threading

from rclpy.node import Node
from rclpy.parameter import Parameter

from forest_bag.play.keyboard import Keyboard
from forest_bag.play.play_options import PlayOptions, plan, select
from forest_bag.play.playback import Player
from forest_bag.play.player_parameters import DESCRIPTIONS
from forest_bag.play.read_ahead import BagSource
from forest_bag.play.remote_control import KEYS, RemoteControl
from forest_bag.play.rosbag2_services import rosbag2_services
from forest_bag.read.merged_bags import MergedBags
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import RawMessage
from forest_msgs_py.introspection.raw_publishers import RawPublishers, is_installed
from forest_msgs_py.runtime.node import Finished, NodeFailure
from forest_msgs_py.runtime.services import offer_parameters, offer_services, offer_triggers

SWITCH_S = 2e-4  # how long another Python thread may keep the interpreter; by default 5 ms
SETTLE_S = 0.2  # a reader that the player has found may not have found the player yet
POLL_S = 0.05
REMINDER_POLLS = 100


class PlayerNode(Node):
    """Plays one bag, or several as one, then ends."""

    def __init__(self, options: PlayOptions) -> None:
        super().__init__("player")
        self._options = options
        self._closing = threading.Event()
        self._given_up = 0
        self._failure: Exception | None = None
        try:
            self._reader = MergedBags(options.bags)
            chosen = select(self._reader, options, is_installed)
            source = BagSource(self._reader, chosen.profiles)
            whole = plan(self._reader, options)
        except BagError as error:
            raise NodeFailure(str(error)) from error
        for warning in chosen.warnings:
            self.get_logger().warning(warning)
        self._out = RawPublishers(self, *chosen[:3], bool(options.clock), options.hurries)
        for topic in self._out.redefined(chosen.hashes):
            self.get_logger().warning(f"{topic}: {chosen.types[topic]} was recorded with another definition")
        self._player = player = Player(source, self, whole)
        span, say = self._reader.span, self.get_logger().info
        self._remote = remote = RemoteControl(player, span, self._set_rate, say)
        if not offer_services(self, "rosbag2_interfaces", rosbag2_services(player, span, self._set_rate)):
            offer_triggers(self, remote.services)
        values = {"rate": options.rate, "seek": 0.0}
        offer_parameters(self, values, DESCRIPTIONS, remote.highest, remote.refuse, remote.apply)
        self._done = self.create_guard_condition(self._finish)
        sys.setswitchinterval(SWITCH_S)
        self._thread = threading.Thread(target=self._play, name="player", daemon=True)
        self._thread.start()

    def publish(self, message: RawMessage) -> None:
        """Send a message of the bag."""
        if not self._out.publish(message.channel.topic, message.data):
            self._given_up += 1

    def clock(self, bag_ns: int) -> None:
        """Send the bag's time."""
        self._out.clock(bag_ns)

    def stop(self) -> None:
        """End the thread and tell how well the times were kept."""
        self._closing.set()
        self._player.stop()
        self._thread.join()
        self._reader.close()
        self.get_logger().info(self._player.summary(self._options.stats))
        if self._given_up:
            self.get_logger().warning(f"{self._given_up} messages not sent: a reliable reader does not read")

    def _play(self) -> None:
        try:
            self._wait_for_readers()
            if not self._closing.is_set():
                with Keyboard(self._remote.keys) as keyboard:
                    if keyboard.active:
                        self.get_logger().info(KEYS)
                    self._player.run()
                self._out.drain()
        except Exception as error:  # noqa: BLE001  a thread must not end alone
            self._failure = error
        finally:
            self._done.trigger()

    def _finish(self) -> None:
        if isinstance(self._failure, (BagError, OSError)):
            raise NodeFailure(str(self._failure))
        raise self._failure or Finished

    def _wait_for_readers(self) -> None:
        """Let those who are there find the player; if asked, wait until every topic has a reader."""
        self._closing.wait(self._options.delay)
        polls = 0
        while self._options.wait_for_subscribers and (without_subscribers := self._out.without_subscribers()):
            if polls % REMINDER_POLLS == 0:
                self.get_logger().info(f"waiting for a subscriber of {', '.join(without_subscribers)}")
            polls += 1
            if self._closing.wait(POLL_S):
                return
        if self._options.wait_for_subscribers:
            self._closing.wait(SETTLE_S)

    def _set_rate(self, rate: float) -> None:
        self.set_parameters([Parameter("rate", value=rate)])
