"""Claims about what passes the valve driver: each axis by its own numbers, nothing beyond its rating."""

import math

import numpy as np
import pytest

from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.load_estimate import STILL, UNMEASURED, UNSEEN, LoadEstimate, Motion, Pressures
from forest_control.valve.spool_model import SpoolLaw
from forest_control.valve.valve_adaptation import NO_ESTIMATE
from forest_control.valve.valve_driver import REST
from forest_control.valve.valve_driver_parameters import Settings
from forest_control.valve.valve_hold import SHUT
from forest_description.machine import load_machine
from forest_description.types import AXES

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")
PERIOD, ZERO = 0.005, (0.0, 0.0, 0.0)
LAG = 1.0 / (2.0 * math.pi * 12.0)  # [s] of the C-180's spools
every_axis = pytest.mark.parametrize("axis", range(3), ids=AXES)
both_ways = pytest.mark.parametrize("sign", [1.0, -1.0], ids=["positive", "negative"])


def parameters(machine=C180, **settings):
    return valve_driver_parameters.parameters(machine, Settings(**settings))


def on_axis(axis, value, others=0.0):
    return tuple(value if i == axis else others for i in range(3))


def lopsided(axis, **settings):
    """A driver of which one axis' valve gives less backwards: 7 V, beyond 0.5 V."""
    p = parameters(**{"beyond_valve": False, **settings})
    law = p.axes[axis].valve
    law = law._replace(backward=law.backward._replace(rated_voltage=7.0, deadband_voltage=0.5))
    return p._replace(axes=tuple(a._replace(valve=law) if i == axis else a for i, a in enumerate(p.axes)))


# --- what is believed -----------------------------------------------------------------------------


@every_axis
@pytest.mark.parametrize("port", ["port_1", "port_2"])
def test_every_port_s_pressure_is_believed_from_a_little_vacuum_to_half_over_the_pump_s_and_no_further(
    axis, port
):
    p = parameters()
    usual = Pressures((5e6,) * 3, (4e6,) * 3, p.supply_pressure)

    def believed(pressure):
        told = usual._replace(**{port: on_axis(axis, pressure, 4.5e6)})
        state, _ = valve_driver.step(REST, ZERO, told, STILL, p, PERIOD)
        assert state.load.primed == load_estimate.plausible(told, p)
        return state.load.primed

    assert believed(-1e6)
    assert believed(1.5 * p.supply_pressure)
    assert not believed(-1.001e6)
    assert not believed(1.501 * p.supply_pressure)
    assert not believed(math.nan)


@pytest.mark.parametrize("machine", [C180, LOADER], ids=["constant pressure", "load sensing"])
def test_a_supply_is_believed_from_a_quarter_of_the_idle_to_half_over_the_greatest(machine):
    p = parameters(machine)
    ports = Pressures((5e5,) * 3, (5e5,) * 3, 0.0)
    for supply, believed in (
        *((0.25 * p.idle_pressure, True), (1.5 * p.supply_pressure, True)),
        *((0.249 * p.idle_pressure, False), (1.501 * p.supply_pressure, False), (math.nan, False)),
    ):
        assert load_estimate.plausible(ports._replace(supply=supply), p) == believed


# --- without a pump ---------------------------------------------------------------------------------


def driven(steps, p, state=REST):
    """The voltages of steps of (command of all valves, supply over that of no pump), and the last state."""
    told = []
    for command, supply in steps:
        pressures = Pressures((5e6,) * 3, (5e6,) * 3, supply * min(2e6, 0.5 * p.idle_pressure))
        state, volts = valve_driver.step(state, (command,) * 3, pressures, STILL, p, PERIOD)
        told.append(volts)
    return told, state


@pytest.mark.parametrize("machine", [C180, LOADER, load_machine("forwarder")], ids=["c180", "loader", "fw"])
def test_without_a_pump_the_valves_shut_and_its_return_opens_none_until_nothing_was_commanded(machine):
    p = parameters(machine)
    told, state = driven([(2.0, 1.0), *[(2.0, 0.99)] * 10], p)
    assert [volts == ZERO for volts in told] == [False] * 10 + [True]  # 0.05 s
    assert valve_driver.objection(state).startswith("the supply is under 2 MPa, or half of its idle pressure")
    told, state = driven([(2.0, 1.0)] * 200, p, state)
    assert set(told) == {ZERO}
    told, state = driven([(0.0, 1.0), (2.0, 1.0)], p, state)
    assert told[0] == ZERO != told[1]
    assert valve_driver.objection(state) == ""


def test_a_pump_that_is_gone_while_nothing_is_commanded_moves_nothing_when_it_is():
    p = parameters()
    _, state = driven([(0.0, 0.0)] * 10, p)
    told, _ = driven([(2.0, 0.0), (2.0, 1.0), (2.0, 1.0)], p, state)
    assert set(told) == {ZERO}
    centred = valve_driver.at_rest(state)
    assert set(driven([(2.0, 1.0)], p, centred)[0]) == {ZERO}  # as after a stop


def test_a_glitch_of_the_supplys_transducer_or_none_shuts_no_valve():
    p = parameters()
    told, state = driven([(2.0, 1.0), *[(2.0, 0.0)] * 9, (2.0, 1.0), *[(2.0, 0.0)] * 9, (2.0, math.nan)], p)
    assert ZERO not in told
    assert state.unfed == 0.0
    assert valve_driver.is_unfed(state._replace(unfed=valve_driver.UNFED))


@pytest.mark.parametrize("machine", [C180, LOADER], ids=["constant pressure", "load sensing"])
def test_a_supply_under_0_7_of_what_it_was_in_this_motion_shuts_the_valves(machine):
    """A pump that flickers: its line does not empty in between."""
    p = parameters(machine)
    idle = p.idle_pressure / min(2e6, 0.5 * p.idle_pressure)
    fell, good = [(2.0, 0.69 * idle)] * 10, (2.0, idle)
    for steps, shuts in (
        ([good, *fell], True),
        ([good, *fell[:9], good], False),
        ([fell[0], good, *fell], True),
        ([good, *[(2.0, 0.71 * idle)] * 20], False),
        ([(2.0, 2.0 * idle), *[(2.0, 0.71 * idle)] * 20], False),  # more than at idle is a load's
        ([(2.0, math.nan), good, *fell], True),
        ([good, (0.0, idle), *fell, *fell], False),  # a relief valve that was set low at rest
    ):
        told, _ = driven(steps, p)
        assert (told[-1] == ZERO) == shuts, steps


@pytest.mark.parametrize("port", [1, 2])
@pytest.mark.parametrize(
    ("axis", "apart", "believed"),
    [(0, 0.51, False), (0, -0.51, False), (0, 0.49, True), (0, -0.49, True), (0, math.nan, True)]
    + [(axis, 0.9, True) for axis in (1, 2)],  # a load-holding valve may stand between both ends
)
def test_both_ends_of_a_swing_s_hose_must_agree(port, axis, apart, believed):
    p, ports = parameters(), {1: (5e6, 4e6, 4e6), 2: (7e6, 4e6, 4e6)}
    told = Pressures(ports[1], ports[2], p.supply_pressure)
    off = on_axis(axis, apart * p.supply_pressure)
    ends = {
        f"valve_{port}": tuple(x - d for x, d in zip(ports[port], off, strict=True)),
        f"valve_{3 - port}": ports[3 - port],
    }
    motion = STILL._replace(positions=(0.1, 2.0, 2.0), **ends)
    state, _ = valve_driver.step(REST, ZERO, told, motion, p, PERIOD)
    assert state.load.primed == believed


# --- each axis by its own numbers -----------------------------------------------------------------


@pytest.mark.parametrize("machine", [C180, LOADER], ids=["C-180", "loader"])
def test_an_axis_gets_what_it_would_get_alone(machine):
    rng, p = np.random.default_rng(61), parameters(machine)
    for _ in range(100):
        one, two = (tuple(x) for x in rng.uniform(1e6, 9e6, (2, 3)).tolist())
        told = Pressures(one, two, p.supply_pressure)
        command = tuple(rng.normal(0.0, 3.0, 3).tolist())
        together, volts = valve_driver.step(REST, command, told, STILL, p, PERIOD)
        for axis in range(3):
            ports = [on_axis(axis, port[axis], 5e6) for port in (one, two)]
            alone, by_itself = valve_driver.step(
                REST, on_axis(axis, command[axis]), Pressures(*ports, p.supply_pressure), STILL, p, PERIOD
            )
            assert volts[axis] == by_itself[axis]
            assert together.holds[axis] == alone.holds[axis]
            assert together.saturated[axis] == alone.saturated[axis]


@every_axis
@pytest.mark.parametrize("machine", [C180, LOADER], ids=["C-180", "loader"])
def test_loads_and_mean_pressures_are_those_of_their_own_ports_behind_their_low_passes(machine, axis):
    p, area = parameters(machine), parameters(machine).axes[axis]
    before, after = ((5e6, 1e6), (2e6, 7e6))  # port 1, port 2

    def told(ports):
        return Pressures(on_axis(axis, ports[0], 3e6), on_axis(axis, ports[1], 3.5e6), p.supply_pressure)

    def load(ports):
        return area.displacement_1 * ports[0] - area.displacement_2 * ports[1]

    def mean(ports):
        return 0.5 * (ports[0] + ports[1] * area.displacement_2 / area.displacement_1)

    state, _ = valve_driver.step(REST, ZERO, told(before), STILL, p, PERIOD)
    assert state.load.loads[axis] == pytest.approx(load(before))
    assert state.load.means[axis] == pytest.approx(mean(before))
    for _ in range(11):
        state, _ = valve_driver.step(state, ZERO, told(after), STILL, p, PERIOD)
    left, filling, borne = (math.exp(-rate * 11 * PERIOD) for rate in (2.0 * math.pi, 60.0, 0.4))
    assert state.load.loads[axis] == pytest.approx(load(after) + left * (load(before) - load(after)))
    assert state.load.means[axis] == pytest.approx(mean(after) + filling * (mean(before) - mean(after)))
    if axis == 0:
        weights = [1.0 - math.exp(-2.0 * math.pi * PERIOD * k) for k in range(1, 12)]
        slow = load(before)
        for weight in weights:
            swing = load(before) + weight * (load(after) - load(before))
            slow += (1.0 - math.exp(-0.4 * PERIOD)) * (swing - slow)
        assert state.load.borne == pytest.approx(slow)
        assert abs(slow - load(before)) < (1.0 - borne) * abs(load(after) - load(before))
    state, _ = valve_driver.step(state, ZERO, UNSEEN, STILL, p, PERIOD)
    assert state.load == UNMEASURED


def test_a_driver_that_begins_has_given_moved_and_borne_nothing():
    for three in (
        REST.load.loads,
        REST.load.means,
        REST.load.rocking,
        REST.spools,
        REST.strokes,
        REST.voltages,
    ):
        assert three == ZERO
    assert (REST.ahead, REST.load.borne, REST.phase) == (0.0, 0.0, 0.0)
    assert not any((REST.load.primed, *REST.saturated))


def test_where_the_spools_are_and_were_on_average_follows_from_the_voltages_in_force():
    before, volts = (1.0, -2.0, 3.0), (4.0, 5.0, -6.0)
    state = REST._replace(spools=before, voltages=volts)
    state, _ = valve_driver.step(state, ZERO, UNSEEN, STILL, parameters(), 0.01)
    after = [v + math.exp(-0.01 / LAG) * (y - v) for y, v in zip(before, volts, strict=True)]
    assert state.spools == pytest.approx(after)
    assert state.strokes == pytest.approx([0.5 * (a + b) for a, b in zip(before, after, strict=True)])


def test_a_cylinder_s_valve_opens_by_its_load_and_a_motor_s_by_its_mean_pressure_too():
    """Of the motor's hoses less comes through while they fill; a port under tank pressure counts as empty."""
    p = parameters()

    def volts(mean_of):
        one, two = zip(*((mean, mean) for mean in mean_of), strict=True)
        areas = [p.axes[i] for i in range(3)]
        two = tuple(
            a.displacement_1 / a.displacement_2 * x for a, x in zip(areas, two, strict=True)
        )  # no load
        return valve_driver.step(
            REST, (2.0, 2.0, 2.0), Pressures(one, two, p.supply_pressure), STILL, p, PERIOD
        )[1]

    half = 0.5 * p.supply_pressure
    usual, low = volts((half, half, half)), volts((1e6, 1e6, 1e6))
    assert low[1:] == pytest.approx(usual[1:], rel=1e-9)
    assert low[0] > 1.05 * usual[0]
    assert volts((half, 1e6, 1e6))[0] == pytest.approx(usual[0], rel=1e-9)
    assert volts((-0.5e6, half, half))[0] == volts((0.0, half, half))[0] > low[0]


@pytest.mark.parametrize("axis", [1, 2], ids=AXES[1:])
def test_a_cylinder_s_chambers_are_as_long_as_it_stands_out_and_no_other_s(axis):
    """Oil in the chambers yields: a valve opens by its own cylinder's length, while pressures settle."""
    p = parameters(load_machine("c180"))
    told, out = Pressures((5e6,) * 3, (4e6,) * 3, p.idle_pressure), (0.0, 1.5, 1.5)

    def volts(positions):
        motion = STILL._replace(positions=positions)
        return valve_driver.step(REST, (3.0,) * 3, told, motion, p, 0.0)[1]

    further = volts(tuple(x + 0.4 * (i == axis) for i, x in enumerate(out)))
    assert [a != b for a, b in zip(volts(out), further, strict=True)] == [i == axis for i in range(3)]


# --- nothing beyond a rating ----------------------------------------------------------------------


@every_axis
def test_each_way_has_its_own_rating(axis):
    passing = lopsided(axis, compensate=False)
    for command, volts in ((-20.0, -7.0), (-7.0, -7.0), (-6.9, -6.9), (20.0, 10.0), (9.9, 9.9)):
        state, given = valve_driver.step(REST, on_axis(axis, command), UNSEEN, STILL, passing, PERIOD)
        assert given == on_axis(axis, volts)
        assert state.saturated == (False, False, False)  # nobody asked for a speed
    for command, volts in ((-20.0, -7.0), (20.0, 10.0)):
        state, given = valve_driver.step(REST, on_axis(axis, command), UNSEEN, STILL, lopsided(axis), PERIOD)
        assert given == on_axis(axis, volts)
        assert state.saturated == on_axis(axis, True, False)
    for command in (-3.0, 3.0):
        assert (
            valve_driver.step(REST, on_axis(axis, command), UNSEEN, STILL, lopsided(axis), PERIOD)[
                0
            ].saturated
            == (False,) * 3
        )


@every_axis
def test_dither_swings_at_its_frequency_and_stays_within_the_rating_of_its_way(axis):
    p = lopsided(axis, compensate=False, dither_frequency=20.0)
    p = p._replace(axes=tuple(a._replace(dither=0.5) for a in p.axes))
    state, swings = REST, []
    for _ in range(100):
        state, volts = valve_driver.step(state, on_axis(axis, 4.0), UNSEEN, STILL, p, PERIOD)
        assert volts[:axis] == (0.0,) * axis
        assert volts[axis + 1 :] == (0.0,) * (2 - axis)
        assert 0.0 <= state.phase < 1.0
        swings.append(volts[axis] - 4.0)
    times = PERIOD * np.arange(1, 101)
    assert swings == pytest.approx(0.5 * np.sin(2.0 * math.pi * 20.0 * times), abs=1e-9)
    for base, low, high in ((-6.9, -7.0, -6.4), (9.9, 9.4, 10.0)):
        state, seen = REST, []
        for _ in range(100):
            state, volts = valve_driver.step(state, on_axis(axis, base), UNSEEN, STILL, p, PERIOD)
            seen.append(volts[axis])
        assert (min(seen), max(seen)) == pytest.approx((low, high), abs=0.03)


@every_axis
def test_dither_begins_at_a_node_each_time_a_valve_opens(axis):
    p = parameters(dither_frequency=23.0)
    state = REST
    for command in (4.0,) * 7 + (0.0,):
        state, _ = valve_driver.step(state, on_axis(axis, command), UNSEEN, STILL, p, PERIOD)
        assert (state.phase == 0.0) == (command == 0.0)


@every_axis
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_shuts_its_valve_and_forgets_that_it_was_open(axis, bad):
    p, state = parameters(), REST
    for _ in range(50):
        state, _ = valve_driver.step(state, (20.0, 20.0, 20.0), UNSEEN, STILL, p, PERIOD)
    assert state.saturated == (True, True, True)
    state, volts = valve_driver.step(state, on_axis(axis, bad, 20.0), UNSEEN, STILL, p, PERIOD)
    assert volts[axis] == state.voltages[axis] == 0.0
    assert state.holds[axis] == SHUT
    assert state.saturated == on_axis(axis, False, True)


# --- a swing that is held -------------------------------------------------------------------------


def held(load, borne, command=1e-9, p=None, **state):
    """The swing's voltage under a load that has been borne, both [N m]."""
    p = p or parameters()
    push = 0.5 * load / p.axes[0].displacement_1
    told = Pressures((8e6 + push, 5e6, 5e6), (8e6 - push, 5e6, 5e6), p.supply_pressure)
    bears = LoadEstimate((load, 0.0, 0.0), True, means=(8e6,) * 3, borne=borne)
    before = REST._replace(load=bears, **state)
    return valve_driver.step(before, on_axis(0, command), told, STILL, p, PERIOD)[1][0]


@both_ways
def test_what_the_swing_bears_at_rest_is_fed_while_it_is_held_and_a_load_that_comes_and_goes_is_not(sign):
    load = sign * 1e4
    for command in (1e-9, -1e-9, 0.9e-6, -0.9e-6):
        for loads in (load, -load, 0.0):
            assert sign * held(loads, load, command) > 1.0  # its weight, whatever rocks
            assert held(loads, 0.0, command) == 0.0
    assert held(load, load, 0.0) == 0.0  # none is none
    for command in (1.1e-6, -1.1e-6, sign * 0.5, -sign * 0.5):  # a wish meets the load as it is
        assert held(load, 0.0, command) == held(load, load, command) != 0.0


@both_ways
def test_friction_of_a_swing_that_turns_is_no_load_at_rest(sign):
    """Steadily turning, it lags behind its low-pass by its rate over the corner."""
    axis, rate = parameters().axes[0], sign * 0.05
    load = LoadEstimate(borne=axis.damping * rate + sign * 2e3, place=1.0)
    assert load_estimate.borne_at_rest(load, 1.0 + rate / 0.4, axis) == pytest.approx(sign * 2e3)
    for place, position in ((math.nan, 1.0), (1.0, math.nan)):  # not measured
        assert load_estimate.borne_at_rest(load._replace(place=place), position, axis) == load.borne


def test_the_swings_place_is_low_passed_while_it_is_measured():
    p, told = parameters(), Pressures((8e6, 5e6, 5e6), (8e6, 5e6, 5e6), parameters().supply_pressure)

    def after(state, position, pressures=told):
        return valve_driver.step(
            state, ZERO, pressures, STILL._replace(positions=(position, 0.0, 0.0)), p, PERIOD
        )[0]

    state = after(REST, 0.5)
    assert state.load.place == 0.5
    state = after(state, 1.5)
    assert state.load.place == pytest.approx(0.5 + 1.0 - math.exp(-0.4 * PERIOD))
    assert math.isinf(after(state, math.nan).load.place)
    assert math.isinf(after(state, 1.5, UNSEEN).load.place)


def test_what_dry_friction_bears_is_not_fed():
    for name, fed in (("c180_hoses", 0.002), ("c180", 0.00325)):
        axes = valve_driver_parameters.axis_drivers(load_machine(name))
        assert axes[0].least_fed == pytest.approx(fed, abs=5e-6)
        assert [axis.damping for axis in axes[1:]] == [0.0, 0.0]


@both_ways
def test_leakage_opens_a_valve_from_what_is_worth_it_on_and_keeps_it_open_at_three_quarters(sign):
    p = parameters()
    per_load = 10.0 * p.axes[0].slip / p.axes[0].rated_speed  # [V/(N m)]
    worth = p.axes[0].least_fed / per_load  # [N m]
    assert held(sign * 1.01 * worth, sign * worth) != 0.0
    assert held(sign * 0.99 * worth, sign * worth) == 0.0
    for share, way, stays in ((0.77, 1.0, True), (0.73, 1.0, False), (0.9, -1.0, False), (0.9, 0.0, False)):
        leaked = sign * share * p.axes[0].least_fed
        hold = SHUT._replace(slow=leaked, quick=leaked, way=sign)
        volts = (way * sign * 1.1, 0.0, 0.0)
        kept = held(
            sign * share * worth,
            sign * share * worth,
            holds=(hold, SHUT, SHUT),
            spools=volts,
            voltages=volts,
        )
        assert (kept != 0.0) == stays, (share, way)


@both_ways
def test_a_small_command_against_what_is_fed_takes_the_spool_as_far_back_as_it_asks_for(sign):
    """It stays on the side that feeds: inwards from that edge, not over the overlap."""
    p = parameters()
    per_load = 10.0 * p.axes[0].slip / p.axes[0].rated_speed  # [V/(N m)]
    load = sign * 2.0 * p.axes[0].least_fed / per_load
    fed = 2.0 * p.axes[0].least_fed
    hold = SHUT._replace(slow=sign * fed, quick=sign * fed, way=sign)
    at = {"holds": (hold, SHUT, SHUT), "spools": (sign * 1.1, 0.0, 0.0), "voltages": (sign * 1.1, 0.0, 0.0)}

    def volts(net):
        return sign * held(load, load, sign * (net - fed), **at)

    assert volts(0.01) > 1.0
    assert 0.0 < volts(-0.02) < volts(-0.01) < 1.0


@pytest.mark.parametrize(
    ("beyond", "within"),
    [(0.9, 0.7), (1.0, 0.6), (1.7, 0.0), (2.5, 0.0), (-0.6, -0.4), (-0.9, -0.1), (-1.1, 0.0), (-2.0, 0.0)],
)
def test_as_far_inwards_from_the_edge_of_its_way_as_the_voltage_is_beyond_it(beyond, within):
    law = C180.valve.law
    law = law._replace(
        forward=law.forward._replace(deadband_voltage=0.8),
        backward=law.backward._replace(deadband_voltage=0.5),
    )
    assert valve_driver._within_the_overlap(beyond, law) == pytest.approx(within, abs=1e-12)


def test_what_leaks_is_fed_by_the_rating_that_commands_are_told_in():
    assert held(1e4, 1e4, p=lopsided(0, beyond_valve=True)) == held(1e4, 1e4) > 1.0


# --- crossing the overlap -------------------------------------------------------------------------


def steady(command, p=None):
    """State and voltage after a second of a boom's command."""
    state, volts = REST, ZERO
    for _ in range(200):
        state, volts = valve_driver.step(state, on_axis(1, command), UNSEEN, STILL, p or parameters(), PERIOD)
    return state, volts[1]


@both_ways
def test_no_voltage_is_expected_to_be_replaced_sooner_than_a_quarter_of_a_hundredth_of_a_second(sign):
    target = steady(sign * 0.25)[1]
    assert 1.0 < sign * target < 1.5
    for dt in (0.0005, 0.001, 0.002):
        volts = valve_driver.step(REST, on_axis(1, sign * 0.25), UNSEEN, STILL, parameters(), dt)[1][1]
        assert volts * (1.0 - math.exp(-0.0025 / LAG)) == pytest.approx(target)


def test_how_late_voltages_were_is_forgotten_in_three_tenths_of_a_second():
    state, _ = valve_driver.step(REST, on_axis(1, 1.0), UNSEEN, STILL, parameters(), 0.03)
    assert state.ahead == 0.03
    for _ in range(60):
        state, _ = valve_driver.step(state, on_axis(1, 1.0), UNSEEN, STILL, parameters(), PERIOD)
    assert state.ahead == pytest.approx(PERIOD + math.exp(-1.0) * 0.025)
    state, _ = valve_driver.step(state, on_axis(1, 1.0), UNSEEN, STILL, parameters(), 0.001)
    assert state.ahead < PERIOD + math.exp(-1.0) * 0.025


@every_axis
@both_ways
def test_an_overlap_is_crossed_by_the_edge_of_its_own_way(axis, sign):
    """At 0.7 V the spool is past the edge backwards, at 0.5 V, and short of the one ahead, at 1 V."""
    p = lopsided(axis)._replace(beyond_valve=True)
    p = p._replace(axes=tuple(a._replace(spool=SpoolLaw(LAG)) for a in p.axes))
    spools = on_axis(axis, sign * 0.7)
    state = REST._replace(spools=spools, voltages=spools, ahead=PERIOD)
    command = on_axis(axis, sign * 0.5)
    volts = valve_driver.step(state, command, UNSEEN, STILL, p, PERIOD)[1][axis]
    target = valve_driver.step(REST, command, UNSEEN, STILL, lopsided(axis), PERIOD)[1][axis]
    assert (sign * volts > 1.2 * sign * target) == (sign > 0.0)


@every_axis
def test_an_edge_nearer_than_a_volt_ends_the_lead_too(axis):
    """At 0.4 V the spool is past the edge ahead, at 0.3 V, and short of the one backwards, at 1 V."""
    p = parameters()
    law = p.axes[axis].valve
    law = law._replace(forward=law.forward._replace(deadband_voltage=0.3))
    p = p._replace(axes=tuple(a._replace(valve=law, spool=SpoolLaw(LAG)) for a in p.axes))
    spools = on_axis(axis, 0.4)
    state = REST._replace(spools=spools, voltages=spools, ahead=PERIOD)
    volts = valve_driver.step(state, on_axis(axis, 0.25), UNSEEN, STILL, p, PERIOD)[1][axis]
    assert 0.4 < volts < 0.8


@every_axis
@both_ways
def test_before_any_time_has_passed_a_voltage_leads_nothing(axis, sign):
    p = parameters()
    p = p._replace(axes=tuple(a._replace(spool=SpoolLaw(LAG)) for a in p.axes))
    command = on_axis(axis, sign * 0.5)
    at_once = valve_driver.step(REST, command, UNSEEN, STILL, p, 0.0)[1][axis]
    assert (
        at_once
        == valve_driver.step(REST, command, UNSEEN, STILL, p._replace(beyond_valve=False), 0.0)[1][axis]
    )
    assert sign * valve_driver.step(REST, command, UNSEEN, STILL, p, PERIOD)[1][axis] > 1.2 * sign * at_once


@every_axis
@both_ways
def test_an_actuator_whose_command_is_a_millionth_of_a_volt_or_less_is_held(axis, sign):
    for command, held_now in ((sign * 0.9e-6, True), (sign * 1.1e-6, False), (-sign * 2.0, False)):
        state = REST
        for k in range(32):
            now = sign * 2.0 if k < 20 else command
            state, _ = valve_driver.step(state, on_axis(axis, now), UNSEEN, STILL, parameters(), PERIOD)
        assert (state.holds[axis].calm_for > 0.5) == held_now, command


# --- learning -------------------------------------------------------------------------------------


@every_axis
@pytest.mark.parametrize("what", ["positions", "valve_1", "valve_2"])
def test_an_axis_of_which_anything_is_not_measured_learns_nothing_and_the_others_go_on(axis, what):
    p = parameters(adapt=True)
    told = Pressures((5e6,) * 3, (4e6,) * 3, p.supply_pressure)
    motion = Motion((0.1, 0.2, 0.3), (5e6,) * 3, (4e6,) * 3)
    missing = motion._replace(**{what: on_axis(axis, math.nan, getattr(motion, what)[0])})
    state, _ = valve_driver.step(REST, (3.0, 3.0, 3.0), told, motion, p, PERIOD)
    assert [learner.primed for learner in state.estimates] == [True] * 3
    after, _ = valve_driver.step(state, (3.0, 3.0, 3.0), told, missing, p, PERIOD)
    assert tuple(learner.primed for learner in after.estimates) == on_axis(axis, False, True)
    blinded, _ = valve_driver.step(state, (3.0, 3.0, 3.0), UNSEEN, motion, p, PERIOD)
    assert [learner.primed for learner in blinded.estimates] == [False] * 3
    still, _ = valve_driver.step(state, (3.0, 3.0, 3.0), told, motion, p, 0.0)
    assert still.estimates == state.estimates


@every_axis
@both_ways
def test_a_learnt_deadband_is_crossed_only_by_a_driver_that_adapts(axis, sign):
    way = NO_ESTIMATE.forward._replace(deadband=0.3)
    learner = NO_ESTIMATE._replace(forward=way, backward=way)
    estimates = tuple(learner if i == axis else NO_ESTIMATE for i in range(3))

    def volts(adapt, learnt):
        p = parameters(adapt=adapt, beyond_valve=False)
        state = REST._replace(estimates=estimates if learnt else REST.estimates)
        return valve_driver.step(state, on_axis(axis, sign * 2.0), UNSEEN, STILL, p, PERIOD)[1][axis]

    assert volts(False, True) == volts(False, False)
    assert sign * (volts(True, True) - volts(True, False)) == pytest.approx(0.3, abs=0.05)


@every_axis
def test_what_an_axis_learns_from_is_its_own_sight(axis):
    p = parameters(adapt=True)
    one, two = (5e6, 6e6, 7e6), (4e6, 3e6, 2e6)
    motion = Motion((0.1, 0.2, 0.3), (5.1e6, 6.1e6, 7.1e6), (3.9e6, 2.9e6, 1.9e6))
    state = REST._replace(voltages=(2.0, 3.0, 4.0))
    state, _ = valve_driver.step(state, ZERO, Pressures(one, two, p.supply_pressure), motion, p, PERIOD)
    expected = motion.positions[axis], motion.valve_1[axis], motion.valve_2[axis], one[axis], two[axis]
    assert state.estimates[axis].last == (*expected, p.supply_pressure, state.strokes[axis])
