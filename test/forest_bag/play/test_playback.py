"""The player's time: simulated here, so that every due time is exact."""

import itertools
import threading

import pytest

from forest_bag.play import read_ahead as reading
from forest_bag.play.lateness import Lateness
from forest_bag.play.playback import ALL, Plan, Player
from forest_bag.play.read_ahead import BagSource, read_ahead
from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.raw_messages import Channel, RawMessage
from forest_bag.write.bag_writer import BagWriter
from forest_msgs_py.interfaces.qos_profiles import Qos
from forest_msgs_py.types import NS_PER_S

STREAM, TRANSIENT_LOCAL = Channel("/stream", "a"), Channel("/map", "b")
START = 10**18
STEP = NS_PER_S // 10


def message(time, channel=STREAM):
    return RawMessage(START + time, 0, 0, channel, f"{channel.topic}{time}".encode())


class FakeWall:
    """Time that passes only when somebody waits; events happen on the way."""

    def __init__(self):
        self.time = 77 * NS_PER_S
        self.events = []  # (time since the start, action)

    def now(self):
        return self.time

    def at(self, seconds, action):
        self.events.append((77 * NS_PER_S + round(seconds * NS_PER_S), action))
        self.events.sort(key=lambda event: event[0])

    def wait(self, condition, seconds):
        assert seconds is not None or self.events, "nothing would ever wake the player"
        target = self.time + round(seconds * NS_PER_S) if seconds is not None else self.events[0][0]
        if self.events and self.events[0][0] <= target:
            self.time, action = self.events.pop(0)
            condition.release()
            action()
            condition.acquire()
        else:
            self.time = target


class Session:
    """A bag in memory, and what came out when."""

    def __init__(self, messages, latched=()):
        self.wall, self.sent, self.ticks = FakeWall(), [], []
        self._messages, self._transient_local = messages, latched

    def messages(self, start_ns):
        yield from (m for m in self._messages if m.log_ns >= start_ns)

    def transient_local(self, position_ns, renew):
        return [m for m in self._transient_local if m.log_ns < position_ns or renew]

    def publish(self, message):
        self.sent.append((self.wall.time - 77 * NS_PER_S, message.log_ns - START))

    def clock(self, bag_ns):
        self.ticks.append((self.wall.time - 77 * NS_PER_S, bag_ns - START))

    def player(self, **plan):
        return Player(self, self, Plan(START, START + 9 * STEP)._replace(**plan), self.wall)


@pytest.fixture
def session():
    return Session([message(STEP * number) for number in range(10)])


@pytest.mark.parametrize("rate", [1.0, 0.5, 4.0])
def test_messages_are_due_at_their_log_times_divided_by_the_rate(session, rate):
    player = session.player(rate=rate)
    player.run()
    assert session.sent == [(round(time / rate), time) for time in range(0, 10 * STEP, STEP)]
    assert (player.played, player.lateness.largest_ns) == (10, 0)


def test_rate_zero_does_not_wait(session):
    session.player(rate=0.0).run()
    assert [wall for wall, _ in session.sent] == [0] * 10


def test_playing_begins_and_ends_where_asked(session):
    session.player(start_ns=START + 2 * STEP, end_ns=START + 4 * STEP).run()
    assert session.sent == [(0, 2 * STEP), (STEP, 3 * STEP), (2 * STEP, 4 * STEP)]


def test_a_pause_shifts_what_follows(session):
    player = session.player()
    session.wall.at(0.25, player.pause)
    session.wall.at(1.25, player.resume)
    player.run()
    walls = [wall for wall, _ in session.sent]
    assert walls == [0, STEP, 2 * STEP, *range(13 * STEP, 20 * STEP, STEP)]


def test_a_paused_player_plays_single_messages_when_told(session):
    player = session.player(paused=True)
    session.wall.at(1.0, player.step)
    session.wall.at(2.0, player.step)
    session.wall.at(3.0, player.stop)
    player.run()
    assert session.sent == [(NS_PER_S, 0), (2 * NS_PER_S, STEP)]
    assert player.position_ns == START + STEP
    assert not session.player().step()


def test_a_rate_set_on_the_way_holds_from_then_on(session):
    player = session.player()
    session.wall.at(0.15, lambda: player.set_rate(0.5))
    player.run()
    assert [wall for wall, _ in session.sent][:4] == [0, STEP, 2.5 * STEP, 4.5 * STEP]


def test_latched_topics_come_first_after_a_seek_and_not_twice():
    stream = [message(STEP * number) for number in range(10)]
    shown = message(STEP, TRANSIENT_LOCAL)
    session = Session(sorted([*stream, shown], key=lambda m: m.log_ns), [shown])
    player = session.player()
    session.wall.at(0.35, lambda: player.seek(START))
    player.run()
    before, after = session.sent[:5], session.sent[5:]
    assert [time for _, time in before] == [0, STEP, STEP, 2 * STEP, 3 * STEP]
    assert after[0] == (3.5 * STEP, STEP)
    assert [time for _, time in after[1:]] == [STEP * number for number in range(10)]
    assert after[-1][0] == 3.5 * STEP + 9 * STEP


def test_a_paused_player_shows_latched_topics_of_where_it_is_put():
    shown = message(0, TRANSIENT_LOCAL)
    session = Session([message(STEP * number) for number in range(1, 10)], [shown])
    player = session.player(paused=True)
    session.wall.at(1.0, lambda: player.seek(START + 5 * STEP))
    session.wall.at(2.0, player.stop)
    player.run()
    assert session.sent == [(NS_PER_S, 0)]
    assert player.position_ns == START + 5 * STEP


def test_a_loop_begins_anew_with_latched_topics(session):
    session._transient_local = [message(-1, TRANSIENT_LOCAL)]
    player = session.player(loop=True)
    session.wall.at(1.25, player.stop)
    player.run()
    assert [time for _, time in session.sent] == [
        -1,
        *range(0, 10 * STEP, STEP),
        -1,
        0,
        STEP,
        2 * STEP,
        3 * STEP,
    ]


def test_nothing_is_not_played_again_and_again():
    session = Session([])
    session.player(loop=True).run()
    assert not session.sent


def test_the_clock_ticks_at_its_rate_and_stands_while_paused(session):
    player = session.player(clock_period_ns=STEP // 2)
    session.wall.at(0.2, player.pause)
    session.wall.at(0.4, player.resume)
    player.run()
    walls, times = zip(*session.ticks, strict=True)
    assert list(walls) == [number * STEP // 2 for number in range(len(walls))]
    assert times[:10] == tuple(STEP * k // 2 for k in (0, 1, 2, 3, 4, 4, 4, 4, 4, 5))


def test_a_player_that_was_stopped_for_long_goes_on_from_there(session):
    player = session.player()

    def suspend():
        session.wall.time += 5 * NS_PER_S

    session.wall.at(0.25, suspend)
    player.run()
    assert [wall for wall, _ in session.sent][2:5] == [2 * STEP, 52.5 * STEP, 53.5 * STEP]
    assert player.slips == 1
    assert "over 1 s late" in player.summary(True)


def test_lateness_is_told_in_shares():
    late = Lateness()
    for number in range(1000):
        late.add(1000 * number)
    assert late.quantile(0.5) == pytest.approx(0.5e-3, abs=1e-5)
    assert late.quantile(0.99) == pytest.approx(0.99e-3, abs=1e-5)
    late.add(10 * NS_PER_S)
    assert late.quantile(1.0) == 10.0


def test_reading_ahead_changes_nothing_and_ends_when_closed():
    many = [message(time) for time in range(100_000)]
    assert list(read_ahead(iter(many))) == many
    endless = read_ahead(map(message, itertools.count(1)))
    assert next(endless) == message(1)
    endless.close()

    def broken():
        yield message(1)
        raise OSError("the disk is gone")

    with pytest.raises(OSError, match="the disk is gone"):
        list(read_ahead(broken()))


@pytest.mark.parametrize(("size", "most"), [(100_000_000, 1), (8_000_000, 3), (500_000, 36), (100, 28_000)])
def test_reading_ahead_ends_at_bytes_whatever_the_size_of_a_message(size, most):
    data, waiting, put = bytes(size), reading._Batches(reading.AHEAD_BYTES), 0
    endless = (message(time)._replace(data=data) for time in itertools.count(1))
    for batch in reading._in_batches(endless):
        if waiting.full():
            break
        waiting.put(batch)
        put += len(batch)
    assert 0.9 * most <= put <= most
    assert len(waiting.get()) == min(put, 100, -(-(1 << 20) // size))
    assert not waiting.full()


def test_latched_topics_hold_what_their_publishers_kept(tmp_path):
    writer = BagWriter(tmp_path / "bag")
    for topic in ("/map", "/tf_static", "/stopped"):
        writer.add_topic(topic, "std_msgs/msg/String", [], "")
    for time, topic, data in [
        (1, "/tf_static", b"arm"),
        (2, "/tf_static", b"hand"),
        (3, "/map", b"old"),
        (5, "/tf_static", b"arm"),
        (6, "/map", b"new"),
        (2 * NS_PER_S, "/stopped", b"true"),
    ]:
        writer.write(topic, data, time, time)
    writer.close()
    profiles = {
        "/map": Qos(1, transient_local=True),
        "/tf_static": Qos(2, transient_local=True),
        "/stopped": Qos(1, transient_local=True),
    }
    with BagReader(writer.directory) as reader:
        source = BagSource(reader, profiles)

        def held(position, renew=True):
            return [m.data for m in source.transient_local(position, renew)]

        assert held(0) == [b"arm", b"old"]
        assert held(0, renew=False) == []
        assert held(4) == [b"arm", b"hand", b"old"]
        assert held(9) == [b"hand", b"arm", b"new"]
        assert held(3 * NS_PER_S) == [b"hand", b"arm", b"new", b"true"]  # not before it happened


def test_a_burst_plays_so_many_messages_at_once_and_then_pauses(session):
    player = session.player(paused=True, at_once=4)
    session.wall.at(5.0, player.stop)
    player.run()
    assert [log for _, log in session.sent] == [STEP * n for n in range(4)]
    assert {when for when, _ in session.sent} == {0}


def test_a_burst_of_all_ends_with_the_bag_and_not_in_the_next_loop(session):
    player = session.player(paused=True, loop=True, at_once=ALL)
    session.wall.at(5.0, player.stop)
    player.run()
    assert player.played == 10


@pytest.mark.parametrize(("asked", "played"), [(3, 3), (0, 10), (99, 10)])
def test_who_asks_for_a_burst_learns_how_many_messages_it_had(asked, played):
    session = Session([message(STEP * number) for number in range(10)])
    player = Player(session, session, Plan(START, START + 9 * STEP, paused=True))  # by the real clock
    running = threading.Thread(target=player.run)
    assert player.burst(asked) == 0  # it does not run yet
    running.start()
    while not player._running:
        running.join(0.001)
    assert player.burst(asked) == played
    player.stop()
    running.join()
    assert player.played == played
    assert player.burst(asked) == 0  # it has ended


def test_a_burst_needs_a_pause(session):
    player, told = session.player(), []
    session.wall.at(0.15, lambda: told.append(player.burst(5)))
    player.run()
    assert told == [0]
