import math

from forest_ident.experiments.excitation import START, Programme, Row, Track, stairs, step

TRACK = Track(stairs((2.0, 4.0), 0.1), -0.5, 0.5)


def play(programme, angle, count=400, dt=0.005):
    state, volts = START, []
    for k in range(count):
        state, out = step(state, (0.0, angle(k * dt), 0.0), programme, dt)
        volts.append(out[1])
    return volts


def test_it_rests_before_and_after():
    volts = play(Programme((None, TRACK, None), 2.0, rest=0.5), lambda _: 0.0)
    assert not any(volts[:100])
    assert all(volts[101:299])
    assert not any(volts[300:])


def test_an_axis_turns_round_at_its_soft_limit():
    volts = play(Programme((None, TRACK, None), 2.0, rest=0.0), lambda time: 0.6 if time > 1.0 else 0.0)
    assert min(volts[:199]) > 0.0
    assert max(volts[202:398]) < 0.0


def test_an_axis_without_a_reading_stands():
    assert not any(play(Programme((None, TRACK, None), 2.0, rest=0.0), lambda _: math.nan))


def test_a_ramp_goes_straight():
    ramp = Track((Row(1.0, 0.0, 2.0),), -1.0, 1.0)
    volts = play(Programme((None, ramp, None), 2.0, rest=0.0), lambda _: 0.0)
    assert abs(volts[100] - 1.0) < 1e-9
