"""Claims about learning a valve: deadband and gain are found from motion, and from nothing else."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from forest_control.valve import valve_adaptation as adaptation
from forest_control.valve import valve_driver_parameters
from forest_control.valve.valve_adaptation import NO_ESTIMATE, updated_estimate
from forest_control.valve.valve_driver_parameters import Settings
from forest_control.valve.valve_flow import AxisMeasurement, Yielding, opening_from_flow
from forest_description.hydraulics.valve_characteristic import TABLE, Curve, Direction, ValveLaw, edges
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
P = valve_driver_parameters.parameters(MACHINE, Settings(adapt=True))
FILE = MACHINE.valve.law
SUPPLY = MACHINE.pump.supply_pressure
PERIOD = 0.005
TANK = 2e5  # [Pa] at the outlet


class Axis(NamedTuple):
    """One actuator behind its valve."""

    flow: object  # FlowParameters
    load: float  # pressure over its ports, A_1 P_1 - A_2 P_2 [N; N m]


BOOM, SWING = Axis(P.flows[1], 60e3), Axis(P.flows[0], 0.0)


def law(forward=(0.0, 1.0), backward=(0.0, 1.0), curve=FILE.curve):
    """The file's valve, each direction with a deadband wider by [V] and a gain that is a factor."""

    def way(wider, gain):
        edge = FILE.forward
        deadband = edge.deadband_voltage + wider
        span = (edge.rated_voltage - edge.deadband_voltage) / gain
        return Direction(deadband, deadband + span, edge.resistance_1, edge.resistance_2)

    return ValveLaw(way(*forward), way(*backward), curve, 0.0)


def steady(axis, volts, valve):
    """Speed and port pressures of an actuator without inertia under its load."""
    a, open_to = axis.flow, edges(volts, valve)
    one, two = a.displacement_1, a.displacement_2
    extends = volts > 0.0
    c_1, c_2 = (open_to.supply_1, open_to.tank_2) if extends else (open_to.tank_1, open_to.supply_2)
    if math.isinf(c_1):
        return 0.0, (max(axis.load, 0.0) + two * 1e6) / one, 1e6
    drive = one * SUPPLY - axis.load if extends else two * SUPPLY + axis.load
    speed = math.copysign(math.sqrt(drive / (c_1 * one**3 + c_2 * two**3)), volts)
    if extends:
        return speed, SUPPLY - c_1 * (one * speed) ** 2, c_2 * (two * speed) ** 2
    return speed, c_1 * (one * speed) ** 2, SUPPLY - c_2 * (two * speed) ** 2


def run(axis, valve, volts, noise=0.0, seed=0, file=FILE, learner=NO_ESTIMATE, a=P.adaptation):
    """Learn from a voltage's course [V], one value (or function of what is learnt) a period."""
    rng, position, last = np.random.default_rng(seed), 1.0, None
    for v in volts:
        v = v(learner) if callable(v) else v
        speed, one, two = steady(axis, v, valve)
        # What the hoses take up while their pressures change comes on top: take none of it here.
        flow = axis.flow._replace(oil_1=Yielding(), oil_2=Yielding(), internal_leakage=0.0)
        flow = flow._replace(external_leakage=0.0, position_noise=noise)
        position += PERIOD * speed
        seen = AxisMeasurement(position + noise * rng.standard_normal(), one, two, one, two, SUPPLY, v)
        learner, last = updated_estimate(learner, seen, file, flow, a, PERIOD), seen
    assert last is not None
    return learner


def strokes(duration=8.0, most=5.0, period=4.0):
    """To and fro, over the overlap at once as the driver does it."""
    times = np.arange(0.0, duration, PERIOD)
    wave = most * np.sin(2.0 * math.pi * times / period)
    return (np.sign(wave) * (1.2 + np.abs(wave))).tolist()


def shift(way):
    return way.deadband, adaptation.gain(way)


@pytest.mark.parametrize("axis", [BOOM, SWING], ids=["boom", "swing"])
@pytest.mark.parametrize(
    ("forward", "backward"),
    [((0.15, 1.4), (0.15, 1.4)), ((-0.15, 0.6), (0.1, 1.2)), ((0.0, 1.0), (-0.2, 0.8))],
)
def test_deadband_and_gain_of_either_direction_are_found(axis, forward, backward):
    learner = run(axis, law(forward, backward), strokes())
    assert shift(learner.forward) == pytest.approx(forward, abs=0.01)
    assert shift(learner.backward) == pytest.approx(backward, abs=0.01)


def test_a_file_that_is_right_stays_right():
    learner = run(BOOM, law(), strokes())
    assert shift(learner.forward) == pytest.approx((0.0, 1.0), abs=1e-3)
    assert shift(learner.backward) == pytest.approx((0.0, 1.0), abs=1e-3)


def test_under_noise_the_estimate_is_as_good_as_its_spread_says():
    off = []
    for seed in range(6):
        learner = run(BOOM, law((0.15, 1.4), (-0.15, 0.7)), strokes(), noise=1.8e-4, seed=seed)
        for way, (wider, gain) in ((learner.forward, (0.15, 1.4)), (learner.backward, (-0.15, 0.7))):
            assert adaptation.deadband_spread(way) < 0.08
            assert adaptation.gain_spread(way) < 0.06
            off.append((way.deadband - wider) / adaptation.deadband_spread(way))
            off.append((adaptation.gain(way) - gain) / adaptation.gain_spread(way))
    assert np.sqrt(np.mean(np.square(off))) < 2.0
    assert np.max(np.abs(off)) < 5.0


def test_a_curve_that_is_not_straight_is_learnt_as_well():
    knots = (0.0, 0.2, 0.5, 1.0) + (1.0,) * 8
    curve = Curve(TABLE, knots, (0.0, 0.1, 0.4, 1.0) + (1.0,) * 8)
    learner = run(BOOM, law((0.12, 0.8), (0.0, 1.3), curve), strokes(), file=law(curve=curve))
    assert shift(learner.forward) == pytest.approx((0.12, 0.8), abs=0.03)
    assert shift(learner.backward) == pytest.approx((0.0, 1.3), abs=0.05)


def test_an_open_valve_without_motion_widens_the_deadband_until_something_moves():
    tops = []

    def just_beyond(learner):
        tops.append(learner.forward.deadband)
        return 1.05 + learner.forward.deadband

    run(SWING, law((0.15, 1.0)), [just_beyond] * 200, noise=2e-4)
    assert tops[0] == 0.0
    assert 0.1 < max(tops) < 0.25
    assert tops[-1] == pytest.approx(0.15, abs=0.02)


def test_a_dead_valve_is_searched_no_further_than_allowed():
    learner = run(SWING, law((3.0, 1.0)), [1.3] * 400)
    assert 0.0 < learner.forward.deadband <= P.adaptation.deadband_range
    assert learner.backward == NO_ESTIMATE.backward


SURE = adaptation.DirectionEstimate(p_dd=1e-4, p_kk=0.01)


@pytest.mark.parametrize(
    "sure",
    [
        adaptation.DirectionEstimate(deadband=-0.036, p_dd=0.04),
        adaptation.DirectionEstimate(stretch=0.8, p_dd=0.002, p_dk=-0.04, p_kk=1.0),
    ],
    ids=["too narrow", "gain near its end"],
)
def test_a_shut_valve_of_an_overlap_that_was_sure_is_searched_for(sure):
    """No gain explains a valve that lets nothing through: one did, and the tip stood before a wider edge."""
    course = []

    def just_beyond(learner):
        course.append(learner.forward)
        return 1.03 + learner.forward.deadband

    run(SWING, law((0.3, 1.0)), [just_beyond] * 400, noise=2e-4, learner=NO_ESTIMATE._replace(forward=sure))
    assert course[-1].deadband == pytest.approx(0.3, abs=0.03)
    assert max(way.deadband for way in course) < 0.35
    assert max(abs(way.stretch - sure.stretch) for way in course) < 0.35


def stuck(learner, periods, play=0.0, spool=1.3, speed=0.0):
    """The swing's estimates, period by period: spool [V], and the swing's own speed [rad/s]."""
    flow = SWING.flow._replace(play=play)
    for k in range(periods):
        seen = AxisMeasurement(speed * k * PERIOD, 8e6, 8e6, 8e6, 8e6, SUPPLY, spool)
        learner = updated_estimate(learner, seen, FILE, flow, P.adaptation, PERIOD)
        yield learner


@pytest.mark.parametrize(("play", "stays"), [(1.0, True), (0.0, False)])
def test_an_overlap_stays_sure_while_the_gears_play_is_taken_up(play, stays):
    course = list(stuck(NO_ESTIMATE._replace(forward=SURE), 60, play))
    assert (max(learner.forward.p_dd for learner in course) < 0.001) == stays


def test_an_actuator_that_is_behind_its_spool_teaches_no_gain():
    """Within the play the overlap is sure and in force: nothing but d may answer for what stands still."""
    course = [learner.forward for learner in stuck(NO_ESTIMATE._replace(forward=SURE), 200, play=1.0)]
    behind = [way.stretch for way in course if way.behind > 0.002]
    assert len(behind) > 100
    assert max(behind) <= behind[0]


@pytest.mark.parametrize("first", [1.3, -1.3])
def test_the_other_direction_begins_anew_to_count_what_is_behind(first):
    *_, learner = stuck(NO_ESTIMATE._replace(forward=SURE, backward=SURE), 60, play=1.0, spool=first)
    assert max(learner.forward.behind, learner.backward.behind) > 0.002
    *_, learner = stuck(learner, 60, play=1.0, spool=-first)
    assert min(learner.forward.behind, learner.backward.behind) == 0.0


def test_a_flow_that_shows_has_caught_up():
    late = NO_ESTIMATE._replace(forward=SURE._replace(behind=1.0))
    assert run(SWING, FILE, [2.0] * 40, noise=2e-4, learner=late).forward.behind == 0.0


def test_a_joint_that_falls_back_through_its_play_is_no_shut_valve():
    *_, learner = stuck(NO_ESTIMATE, 60, play=1.0, spool=1.04, speed=-0.02)
    assert learner.forward == NO_ESTIMATE.forward._replace(behind=learner.forward.behind)


def test_a_valve_little_beyond_its_overlap_is_searched_for_by_and_by():
    """0.04 V are less than a flow's noise at once; 4.4 mrad/s for half a second are not."""
    tops = [learner.forward.deadband for learner in stuck(NO_ESTIMATE, 200, play=0.001, spool=1.04)]
    assert tops[40] == 0.0
    assert tops[-1] == pytest.approx(0.04, abs=0.005)


def test_an_actuator_ahead_of_its_spool_is_not_owed_for_later():
    course = list(stuck(NO_ESTIMATE._replace(forward=SURE), 60, play=1.0, spool=1.01, speed=0.005))
    assert [learner.forward.behind for learner in course] == [0.0] * 60


def test_a_valve_that_is_slow_is_not_taken_for_a_shut_one():
    sure = adaptation.DirectionEstimate(p_dd=0.002)
    learner = run(SWING, law((0.0, 0.6)), [2.0] * 100, noise=2e-4, learner=NO_ESTIMATE._replace(forward=sure))
    assert shift(learner.forward) == pytest.approx((0.0, 0.6), abs=0.03)


def test_a_ramp_whose_flow_is_late_is_not_taken_for_a_shut_valve():
    """The spool lags by 15 ms more than its file says, on a ramp of 6 V/s from its edge: 0.09 V."""
    learner, position, most = NO_ESTIMATE._replace(forward=SURE), 1.0, 0.0
    flow = SWING.flow._replace(oil_1=Yielding(), oil_2=Yielding(), internal_leakage=0.0, external_leakage=0.0)
    for k in range(60):
        v = 1.0 + 6.0 * PERIOD * k
        speed, one, two = steady(SWING, v - 0.09, FILE)
        position += PERIOD * speed
        seen = AxisMeasurement(position, one, two, one, two, SUPPLY, v)
        learner = updated_estimate(learner, seen, FILE, flow, P.adaptation, PERIOD)
        most = max(most, learner.forward.behind)
    assert most < flow.position_noise


def test_the_swings_play_is_its_files():
    gear = load_machine("c180").swing.backlash
    flows = valve_driver_parameters.parameters(load_machine("c180"), Settings()).flows
    assert flows[0].play == gear.free_way > 0.0
    assert flows[1].play == flows[2].play == 0.0
    assert SWING.flow.play == 0.0


@pytest.mark.parametrize("volts", [[0.0] * 400, [0.9, -0.9] * 200], ids=["centred", "inside the overlap"])
def test_a_shut_valve_teaches_nothing(volts):
    learner = run(BOOM, law((0.15, 1.4)), volts, noise=2e-4)
    assert learner.forward == NO_ESTIMATE.forward
    assert learner.backward == NO_ESTIMATE.backward


def still(**changes):
    """A spool wide open, seen with something that makes the flow unknowable."""
    sight = AxisMeasurement(1.0, 8e6, 5e6, 8e6, 5e6, SUPPLY, 4.0)._replace(**changes)
    learner = NO_ESTIMATE
    for _ in range(300):
        learner = updated_estimate(learner, sight, FILE, P.flows[1], P.adaptation, PERIOD)
    return learner.forward


def test_what_cannot_tell_a_flow_teaches_nothing():
    assert still() != NO_ESTIMATE.forward
    relief, stalled = 1.3 * SUPPLY, SUPPLY
    assert still(port_1=relief, valve_1=relief, port_2=0.0, valve_2=0.0) == NO_ESTIMATE.forward
    assert still(port_1=stalled, valve_1=stalled, port_2=2e5, valve_2=0.0) == NO_ESTIMATE.forward


def test_a_gap_in_the_measurements_keeps_what_is_learnt():
    learner = run(BOOM, law((0.15, 1.4), (0.15, 1.4)), strokes())
    after = adaptation.unmeasured(learner)
    assert (after.forward, after.backward) == (learner.forward, learner.backward)
    resumed = run(BOOM, law((0.15, 1.4), (0.15, 1.4)), strokes(4.0), learner=after)
    assert shift(resumed.forward) == pytest.approx((0.15, 1.4), abs=0.01)


def test_nothing_winds_up_and_nothing_leaves_its_range():
    rng, learner = np.random.default_rng(5), NO_ESTIMATE
    a = P.adaptation._replace(forgetting_time=0.05)
    for _ in range(4000):
        ports = rng.uniform(-1e6, 30e6, 4).tolist()
        seen = AxisMeasurement(rng.normal(), *ports, SUPPLY, rng.uniform(-10.0, 10.0))
        learner = updated_estimate(learner, seen, FILE, P.flows[1], a, PERIOD)
        for way in (learner.forward, learner.backward):
            assert abs(way.deadband) <= a.deadband_range
            assert 1.0 / a.gain_range - 1e-12 <= adaptation.gain(way) <= a.gain_range + 1e-12
            assert 0.0 <= way.p_dd <= 1.0 + 1e-12
            assert 0.0 <= way.p_kk <= 1.0 + 1e-12


def test_an_underlapped_valve_is_left_alone():
    edge = FILE.forward._replace(deadband_voltage=-0.1)
    learner = run(BOOM, law((0.15, 1.4)), strokes(2.0), file=ValveLaw(edge, edge, FILE.curve, 0.0))
    assert learner.forward == NO_ESTIMATE.forward


def test_the_learnt_valve_is_the_true_one():
    true = law((0.15, 1.4), (-0.1, 0.8))
    known = adaptation.estimated_law(FILE, run(BOOM, true, strokes()))
    for volts in (1.3, 2.0, 4.0, -1.1, -3.0):
        told, meant = edges(volts, known), edges(volts, true)
        assert min(told.supply_1, told.tank_1) == pytest.approx(min(meant.supply_1, meant.tank_1), rel=0.1)


def test_a_dead_time_that_the_file_knows_is_not_learnt_as_a_wider_overlap():
    """A spool that is 10 ms late on a ramp of 10 V/s is 0.1 V behind its voltage."""

    def learnt(dead_time):
        learner, position = NO_ESTIMATE, 1.0
        flow = BOOM.flow._replace(oil_1=Yielding(), oil_2=Yielding(), dead_time=dead_time)
        for k in range(80):
            v = 1.5 + 10.0 * PERIOD * k
            speed, one, two = steady(BOOM, v - 0.1, FILE)
            position += PERIOD * speed
            seen = AxisMeasurement(position, one, two, one, two, SUPPLY, v)
            learner = updated_estimate(learner, seen, FILE, flow, P.adaptation, PERIOD)
        return learner.forward.deadband

    assert learnt(0.0) > 0.03
    assert abs(learnt(0.01)) < 0.02


@pytest.mark.parametrize("axis", [1, 2])
def test_the_oil_of_the_chambers_counts_as_flow(axis):
    """While a cylinder stands and its chamber's pressure rises, the valve is open by what the oil takes."""
    real = valve_driver_parameters.parameters(load_machine("c180"), Settings())
    flow, law = real.flows[axis], real.axes[axis].valve
    assert (flow.oil_1, flow.oil_2) == (real.axes[axis].oil_1, real.axes[axis].oil_2)
    before = AxisMeasurement(2.0, 5e6, 5e6, 5e6, 5e6, SUPPLY, 2.0)
    raised = before._replace(port_1=5.1e6)
    taken = (flow.oil_1.fixed + flow.oil_1.growing * 2.0) * 1e5 / PERIOD  # [m^3/s]
    y = opening_from_flow(before, raised, law, flow, PERIOD)
    moved = before._replace(position=2.0 + PERIOD * taken / flow.displacement_1)
    rigid = flow._replace(oil_1=Yielding(), oil_2=Yielding())
    other = opening_from_flow(before, moved, law, rigid, PERIOD)
    share = law.forward.resistance_1 * flow.displacement_1**3
    share /= share + law.forward.resistance_2 * flow.displacement_2**3
    assert y.opening == pytest.approx(share * other.opening, rel=1e-6)
    assert y.opening > 0.0
