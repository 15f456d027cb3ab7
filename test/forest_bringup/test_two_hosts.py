"""Controller and operator here, machine and recorder there, and the link between them is cut in motion."""

import hosts
import pytest

pytest.importorskip("rclpy")

from two_hosts import HERE, THERE, Times, TwoHosts

# The levers rest long enough for a busy computer to find the healed link again.
TIMES = Times(begun=1.5, rest=3.2, again=5.2, ends=6.2)
ZERO_S = 0.12  # command_timeout of the driver, and periods of state and watchdog
WAITED_S = 0.1  # that a busy computer may keep the driver from its watchdog


@pytest.fixture
def cable():
    with hosts.hosts("here", "there") as at:
        hosts.switch(at, [f"{HERE}/24", f"{THERE}/24"])
        yield at


def test_a_cut_link_stops_the_crane_and_it_moves_again_only_once_the_levers_rested(
    cable, domain_id, start_process, tmp_path
):
    graph = TwoHosts(lambda words, env: start_process(words, python=False, env=env), cable, tmp_path, TIMES)
    graph.until(TIMES.begun + 0.7)
    held, cut, healed = graph.cut(0.5)
    found = graph.end()
    assert found.moved(TIMES.begun, held), graph.text()
    assert found.zero_after(cut, healed) < ZERO_S + WAITED_S, graph.text()
    assert not found.moved(cut + ZERO_S + WAITED_S, TIMES.rest), graph.text()
    assert found.moved(TIMES.again, TIMES.ends), graph.text()
