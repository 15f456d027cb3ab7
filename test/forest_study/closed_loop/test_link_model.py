"""Claims about a bad link: what it delays, jitters and loses is what it was asked for, and repeats."""

import numpy as np
import pytest

from forest_control.valve.tracking_limit import FULL, OpeningRatio
from forest_study.closed_loop.link_model import Link, LinkError, Quality, Reports, reported


def arrivals(quality, seed=0, count=4000, period=0.01):
    """Return (number, time of arrival) of messages sent every period, seen every millisecond."""
    link, seen = Link(quality, seed), []
    for tick in range(int(1000 * (count * period + 2.0))):
        now = 1e-3 * tick
        if tick % round(1000 * period) == 0 and tick // round(1000 * period) < count:
            link.send(now, tick // round(1000 * period))
        seen += [(number, now) for number in link.arrived(now)]
    return seen


def test_a_perfect_link_hands_on_at_once():
    assert arrivals(Quality(), count=50) == [(k, pytest.approx(0.01 * k)) for k in range(50)]


def test_delay_jitter_and_loss_are_as_asked():
    seen = arrivals(Quality(delay=0.1, jitter=0.2, loss=0.3), seed=3, count=2000)
    late = np.array([time - 0.01 * number for number, time in seen])
    assert late.min() == pytest.approx(0.1, abs=0.002)
    assert late.max() == pytest.approx(0.3, abs=0.002)
    assert late.mean() == pytest.approx(0.2, abs=0.005)
    assert len(seen) == pytest.approx(0.7 * 2000, rel=0.05)
    numbers = [number for number, _ in seen]
    assert numbers != sorted(numbers)  # some were overtaken


def test_equal_seeds_repeat_and_others_differ():
    one, same, other = (arrivals(Quality(0.0, 0.05, 0.1), seed, 200) for seed in (1, 1, 2))
    assert one == same
    assert one != other


@pytest.mark.parametrize("bad", [Quality(delay=-1.0), Quality(jitter=float("nan")), Quality(loss=1.5)])
def test_what_cannot_be_is_refused(bad):
    with pytest.raises(LinkError, match="allowed: 0 "):
        Link(bad)


def test_in_lockstep_an_opening_ratio_is_said_every_twentieth_step_and_heard_two_such_spans_later():
    reports, steps = Reports(), 200
    for step in range(1, steps + 1):
        by_now = OpeningRatio((step / steps,) * 3, (0.0,) * 3)
        reports = reported(reports, by_now)
        said = 20 * (step // 20 - 2) + 1
        heard = OpeningRatio((said / steps,) * 3, (0.0,) * 3) if said > 0 else FULL
        assert reports.heard == heard, step
