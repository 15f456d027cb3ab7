"""What of a bag is played, under which name, and what is refused."""

from pathlib import Path

import pytest

from forest_bag.cli.main import main
from forest_bag.play.play_options import PlayOptions, plan, select
from forest_bag.storage.bag_files import BagError
from forest_bag.storage.raw_messages import Channel
from forest_msgs_py.interfaces.qos_profiles import Qos

JOY = Channel("/joy", "sensor_msgs/msg/Joy", qos="- {depth: 7}")
THEIRS = Channel("/theirs", "nobody_msgs/msg/Secret")
SECOND = 1_000_000_000


class FakeReader:
    path = Path("bag")
    span = (10 * SECOND, 14 * SECOND)

    def __init__(self, *channels):
        self.channels = {}
        for channel in channels:
            self.channels.setdefault(channel.topic, []).append(channel)


def chosen(*channels, **options):
    options = PlayOptions((Path("bag"),), **options)
    return select(FakeReader(*channels), options, lambda name: not name.startswith("nobody"))


def test_what_is_installed_is_played_and_the_rest_is_named():
    selection = chosen(JOY, THEIRS, Channel("/old", "std_msgs/String", "ros1"), Channel("/bare", ""))
    assert selection.names == {"/joy": "/joy", "/bare": "/bare"}
    assert selection.profiles["/joy"] == Qos(7)
    theirs, old = selection.warnings
    assert "/theirs is not played: its type nobody_msgs/msg/Secret is not installed" in theirs
    assert "/old is not played: it is encoded as ros1; allowed: cdr" in old


@pytest.mark.parametrize("name", ["", "/1a", "/a b", "/a/", "/é"])
def test_a_name_that_ros_does_not_allow_is_left_out_and_named_or_renamed(name):
    odd = JOY._replace(topic=name)
    selection = chosen(JOY, odd)
    assert selection.names == {"/joy": "/joy"}
    assert f"{name!r} is no name of a topic" in selection.warnings[0]
    assert chosen(odd, remaps=((name, "/good"),)).names == {name: "/good"}


def test_topics_are_chosen_and_renamed():
    both = (JOY, JOY._replace(topic="/other"))
    assert chosen(*both, topics=("/joy",)).names == {"/joy": "/joy"}
    assert chosen(*both, exclude=("/joy",)).names == {"/other": "/other"}
    assert chosen(*both, remaps=(("/joy", "/new"),)).names == {"/joy": "/new", "/other": "/other"}


def test_a_recorded_clock_gives_way_to_the_players():
    clock = Channel("/clock", "rosgraph_msgs/msg/Clock")
    assert chosen(JOY, clock, clock=40.0).names == {"/joy": "/joy"}
    assert "/clock" in chosen(JOY, clock).names


@pytest.mark.parametrize(
    ("channels", "options", "problem"),
    [
        ([JOY], {"topics": ("/nothing",)}, "no topic /nothing in the bag; it holds /joy"),
        ([JOY], {"remaps": (("joy", "/x"),)}, "no topic joy in the bag; it holds /joy"),
        ([THEIRS], {}, "nothing to play in bag; /theirs is not played"),
        ([], {}, "nothing to play"),
        ([JOY, JOY._replace(type="std_msgs/msg/String")], {}, "it has several types"),
    ],
)
def test_what_cannot_be_played_is_said(channels, options, problem):
    with pytest.raises(BagError, match=problem):
        chosen(*channels, **options)


def test_start_and_duration_are_times_of_the_bag():
    reader = FakeReader(JOY)
    whole = plan(reader, PlayOptions((Path("bag"),), clock=100.0))
    assert (whole.start_ns, whole.end_ns, whole.clock_period_ns) == (*reader.span, SECOND // 100)
    part = plan(reader, PlayOptions((Path("bag"),), start_offset=1.5, duration=0.5))
    assert (part.start_ns, part.end_ns) == (11.5 * SECOND, 12 * SECOND)
    with pytest.raises(BagError, match=r"--start-offset is 5; allowed: 0 .. 4 s"):
        plan(reader, PlayOptions((Path("bag"),), start_offset=5.0))


@pytest.mark.parametrize(
    ("flags", "allowed"),
    [
        (["-r", "-1"], "'-1'; allowed: 0 .. 1e+06"),
        (["-r", "fast"], "'fast'; allowed"),
        (["--clock", "0"], "'0'; allowed: 0.1 .. 10000"),
        (["--duration", "nan"], "'nan'; allowed: 0 or more"),
        (["-m", "/a=/b"], "'/a=/b'; allowed: OLD:=NEW"),
        (["-m", "/a:=/1b"], "'/a:=/1b'; allowed: OLD:=NEW"),
    ],
)
def test_a_wrong_flag_names_what_is_allowed(capsys, flags, allowed):
    with pytest.raises(SystemExit, match="2"):
        main(["play", "bag", *flags])
    assert allowed in capsys.readouterr().err
