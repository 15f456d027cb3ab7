"""The pictures show what is in the bag; the tip error is the integral of the wish against the truth."""

import logging
import struct

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_bag.plots.standard_plots import draw_all, tip_error
from forest_bag.read.timeseries import NotInBag, read_bag
from forest_msgs_py.interfaces import messages, topics

START = 1_700_000_000_000_000_000
PERIOD = 5_000_000
N = 200
SPEED = np.array([0.3, -0.2, 0.1])  # m/s
FIRST = np.array([5.5, 0.0, 1.0])  # m
OFFSET = np.array([0.0, 0.0, 0.004])  # m that the tip gains over the whole run
PICTURES = ["tip_path.png", "tip_error.png", "joints.png", "voltages.png", "hydraulics.png"]


def stream(make, first=START):
    return [(first + PERIOD * step, make(first + PERIOD * step, step)) for step in range(N)]


def tip_content(gap=0):
    """A tip that follows a constant wish but for a slow drift; ``gap``: periods without command."""

    def truth(stamp, step):
        position = FIRST + SPEED * step * PERIOD * 1e-9 + OFFSET * step / (N - 1)
        return messages.pose_stamped(stamp, "base_link", position)

    def wish(stamp, _step):
        return messages.twist_stamped(stamp, "base_link", SPEED)

    wishes = stream(wish)
    return {
        topics.GROUND_TRUTH_TIP_POSE: stream(truth),
        topics.TIP_TWIST_COMMAND: wishes[: N // 2 - gap] + wishes[N // 2 :],
    }


@pytest.fixture
def whole_content():
    rows = (
        (topics.VALVE_COMMANDS, (1.0, 2.0, 3.0)),
        (topics.VALVE_VOLTAGES, (2.0, 3.0, 4.0)),
        (topics.PRESSURES, tuple(1e6 * place for place in range(12))),
        (topics.SUPPLY, (20e6, 3e-3, 0.5)),
        (topics.FLOWS, (1e-3, 2e-3)),
    )
    content = tip_content()
    for topic, values in rows:
        content[topic] = stream(lambda stamp, _, t=topic, v=values: messages.float_array(t, stamp, v))
    content[topics.JOINT_STATES] = stream(
        lambda stamp, step: messages.joint_state(topics.JOINTS, stamp, (0.0, 0.01 * step, -1.0), (0, 2, 0))
    )
    return content


def test_tip_error_is_the_true_tip_minus_the_integrated_wish(make_bag):
    time, wished, moved = tip_error(read_bag(make_bag(tip_content())))
    np.testing.assert_allclose(time, np.arange(N) * PERIOD * 1e-9, atol=1e-12)
    np.testing.assert_allclose(wished, FIRST + np.outer(time, SPEED), atol=1e-9)
    np.testing.assert_allclose(moved[-1] - wished[-1], OFFSET, atol=1e-9)
    np.testing.assert_array_equal(moved[0], wished[0])


def test_a_wish_that_stops_coming_moves_the_tip_for_three_periods_at_most(make_bag):
    gap = 40
    _, wished, _ = tip_error(read_bag(make_bag(tip_content(gap))))
    commanded = (N - 1 - gap - 1) + 3  # whole periods, then three in place of the gap's 41
    np.testing.assert_allclose(wished[-1] - wished[0], SPEED * commanded * PERIOD * 1e-9, atol=1e-9)


def test_every_picture_is_drawn_1000_pixels_wide(whole_content, make_bag, tmp_path):
    bag = read_bag(make_bag(whole_content))
    drawn = draw_all(bag, tmp_path / "pictures", {"boom": (-0.64, 1.26)})
    assert [path.name for path in drawn] == PICTURES
    for path in drawn:
        data = path.read_bytes()
        assert data.startswith(b"\x89PNG")
        assert struct.unpack(">I", data[16:20]) == (1000,)


def test_a_picture_without_its_topics_is_skipped_and_reported(whole_content, make_bag, tmp_path, caplog):
    del whole_content[topics.TIP_TWIST_COMMAND], whole_content[topics.PRESSURES]
    bag = read_bag(make_bag(whole_content))
    with pytest.raises(NotInBag):
        tip_error(bag)
    with caplog.at_level(logging.WARNING):
        drawn = draw_all(bag, tmp_path / "pictures", leave_out=("joints.png", "voltages.png"))
    assert [path.name for path in drawn] == ["tip_path.png"]
    assert "tip_error.png is not drawn: no topic 'tip/twist_command'" in caplog.text
    assert "hydraulics.png is not drawn" in caplog.text
