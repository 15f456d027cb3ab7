import dataclasses
import math
from types import SimpleNamespace

import pytest

from forest_description.derived.limits import joint_limits
from forest_description.export.machine_yaml import machine_text
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_ident.driving import safety_monitor
from forest_ident.driving.safety_monitor import PEAK, Readings, State, bounds, out_of_bounds, step
from forest_ident.experiments import experiment_plan
from forest_ident.experiments.excitation import START
from forest_ident.experiments.excitation import step as excite

C180 = load_machine("c180_hoses")
PLAN = experiment_plan.plan("damping_boom", C180)
BOUNDS = bounds(PLAN, PLAN.programme)
WELL = Readings(PLAN.angles, (5e6, 3e6), 20.7e6, 313.0)
NAN = math.nan


def verdict(seen, seconds=0.05):
    state, reason = State(), ""
    for _ in range(round(seconds / 0.005)):
        state, reason = step(state, seen, BOUNDS, 0.005)
        if reason:
            break
    return reason


@pytest.mark.parametrize(
    ("change", "seconds", "sentence"),
    [
        ({}, 1.0, ""),
        ({"angles": (0.0, math.radians(71.0), -1.5)}, 0.01, "the boom stands at 71.0 deg; allowed"),
        ({"angles": (0.0, 0.5, -2.2)}, 1.0, ""),  # the stick is not driven
        ({"pressures": (4e7, 3e6)}, 0.2, ""),  # a valve that shuts
        ({"pressures": (4e7, 3e6)}, 2.0 * PEAK, "stays at 40.00 MPa; allowed: up to 36.15 MPa"),
        ({"supply": 1e6}, 2.0 * PEAK, "the supply pressure is 1.00 MPa; allowed: 5.17 MPa or more"),
        ({"supply": NAN, "temperature": NAN, "pressures": ()}, 1.0, ""),  # no such sensors
        ({"temperature": 351.0}, 0.01, "the oil is at 351.0 K; allowed: up to 350 K"),
    ],
)
def test_what_stops_an_experiment(change, seconds, sentence):
    said = verdict(WELL._replace(**change), seconds)
    assert sentence in said
    assert bool(said) == bool(sentence)


@pytest.mark.parametrize(
    ("volts", "moves", "axis"),
    [(3.0, 0.0, 1), (-3.0, 0.0, 1), (1.5, 0.0, None), (3.0, 1e-9, None)],
    ids=["out", "in", "the valve hardly opens", "the joint moves"],
)
def test_an_angle_that_stays_the_same_under_an_open_valve_stops_an_experiment(volts, moves, axis):
    """The stick is not driven: it may stand as long as it likes."""
    state, said = State(), []
    for k in range(200):
        seen = WELL._replace(angles=(PLAN.angles[0], PLAN.angles[1] + moves * k, PLAN.angles[2]))
        state, reason = step(state, seen, BOUNDS, 0.005, (0.0, volts, 5.0))
        said.append(reason)
    named = [k for k, reason in enumerate(said) if reason.startswith("the boom reads the same")]
    assert bool(named) == (axis is not None)
    if named:
        assert 0.29 < 0.005 * named[0] < 0.33
        assert step(state, seen._replace(angles=PLAN.angles), BOUNDS, 0.005, ZERO)[1] == ""


def test_a_peak_that_passes_is_forgotten():
    state = State()
    for k in range(400):
        state, reason = step(state, WELL._replace(pressures=(4e7 if k % 40 < 30 else 2e7,)), BOUNDS, 0.005)
        assert not reason


@pytest.mark.parametrize("name", ["c180_hoses", "c180_thesis", "loader"])
def test_every_start_is_within_the_bounds_of_its_experiment(name):
    machine = load_machine(name)
    for known in experiment_plan.names(machine)[1:]:
        plan = experiment_plan.plan(known, machine)
        assert not out_of_bounds(plan.angles, bounds(plan, plan.programme)), known


def test_the_swing_goes_about_where_it_stands_and_keeps_from_its_ends():
    plan = experiment_plan.plan("motor_external", C180)
    for stands, room in ((0.7, (-0.5, 1.9)), (2.5, (1.3, math.pi - 0.1))):
        moved = safety_monitor.around(plan.programme, plan, stands)
        assert moved.tracks[0][1:3] == pytest.approx(room)
        assert not out_of_bounds((stands, 0.0, 0.0), bounds(plan, moved))
        _, volts = excite(START._replace(time=2.0), (stands, 0.0, 0.0), moved, 0.005)
        assert volts[0] != 0.0


def test_a_rig_has_no_joints_that_could_be_out_of_bounds():
    plan = experiment_plan.plan("valve", C180)
    assert safety_monitor.monitored_ports(plan) == ("swing_1_actuator", "swing_2_actuator")
    assert not out_of_bounds((99.0, 99.0, 99.0), bounds(plan, plan.programme))


@pytest.mark.parametrize("name", ["valve_stick", "motor_internal"])
def test_a_prepared_machine_can_be_told_to_a_node_as_a_file(name, tmp_path):
    plan, file = experiment_plan.plan(name, load_machine("loader")), tmp_path / "rig.yaml"
    file.write_text(machine_text(plan.machine, "made of the loader's parts"), encoding="utf-8")
    assert load_machine(file) == dataclasses.replace(plan.machine, name="rig")


def test_a_trial_is_cut_off_and_rests_at_its_end():
    plan = experiment_plan.plan("validation", C180, longest=5.0)
    assert plan.programme.duration == 5.0
    assert excite(START._replace(time=4.5), plan.angles, plan.programme, 0.005)[1] == (0.0, 0.0, 0.0)


RANGES = safety_monitor.Bounds(
    driven=(True, True, True),
    low=(-1.0, 0.1, -2.0),
    high=(2.0, 0.9, -0.5),
    pressure=10e6,
    supply=4e6,
    open=(2.0, 3.0, 4.0),
)
THERE, VOLTS = (0.5, 0.4, -1.2), (2.5, -3.5, 4.5)
FINE = Readings(THERE, (5e6, 9.9e6), 4.1e6, 349.9)
JUST = 0.31 - 0.005  # [s] so that a sample more is beyond 0.3 s
every_joint = pytest.mark.parametrize("joint", [0, 1, 2])


def at(joint, value, others):
    return tuple(value if i == joint else others[i] for i in range(3))


def test_times_beyond_a_bound_grow_and_begin_anew_and_the_angles_are_kept():
    state = State(0.1, 0.2, (0.01, 0.02, 0.03), THERE)
    after, said = step(state, FINE._replace(pressures=(1e6, 10.1e6), supply=3.9e6), RANGES, 0.005, VOLTS)
    assert said == ""
    assert (after.over, after.starved) == pytest.approx((0.105, 0.205))
    assert after.still == pytest.approx((0.015, 0.025, 0.035))
    assert after.angles == THERE
    assert step(state, FINE, RANGES, 0.005)[0] == State(0.0, 0.0, (0.0, 0.0, 0.0), THERE)


@every_joint
def test_each_joint_counts_as_still_that_is_driven_under_its_own_open_valve(joint):
    state = State(still=(0.01, 0.02, 0.03), angles=THERE)
    for changed in (
        {"volts": at(joint, VOLTS[joint] * 0.75, VOLTS)},
        {"seen": FINE._replace(angles=at(joint, THERE[joint] + 1e-9, THERE))},
        {"b": RANGES._replace(driven=at(joint, False, (True, True, True)))},
    ):
        told = {"seen": FINE, "b": RANGES, "volts": VOLTS} | changed
        found = step(state, told["seen"], told["b"], 0.005, told["volts"])[0].still
        assert [time > 0.0 for time in found] == [i != joint for i in range(3)]


@every_joint
def test_each_joint_that_is_still_for_over_three_tenths_of_a_second_is_named(joint):
    name = ("swing", "boom", "stick")[joint]
    for time, named in ((JUST, True), (JUST - 0.02, False)):
        state = State(still=at(joint, time, (0.0, 0.0, 0.0)), angles=THERE)
        said = step(state, FINE, RANGES, 0.005, VOLTS)[1]
        assert said.startswith(f"the {name} reads the same") if named else said == ""


@every_joint
def test_each_driven_joint_is_named_beyond_either_end(joint):
    name = ("swing", "boom", "stick")[joint]
    for end, outward in ((RANGES.low[joint], -1e-3), (RANGES.high[joint], 1e-3)):
        beyond = at(joint, end + outward, THERE)
        said = out_of_bounds(beyond, RANGES)
        assert said.startswith(f"the {name} stands at {math.degrees(end + outward):.1f} deg; allowed")
        ends = f"{math.degrees(RANGES.low[joint]):.1f} .. {math.degrees(RANGES.high[joint]):.1f} deg"
        assert said.endswith(ends)
        assert out_of_bounds(at(joint, end - outward, THERE), RANGES) == ""
        assert out_of_bounds(at(joint, end, THERE), RANGES) == ""
        rig = RANGES._replace(driven=at(joint, False, (True, True, True)))
        assert out_of_bounds(beyond, rig) == ""
        assert step(State(), FINE._replace(angles=beyond), RANGES, 0.005)[1] == said


@pytest.mark.parametrize(
    ("state", "change", "said"),
    [
        (
            State(over=JUST),
            {"pressures": (10.1e6, 11e6, 3e6)},
            "stays at 11.00 MPa; allowed: up to 10.00 MPa",
        ),
        (State(over=JUST - 0.02), {"pressures": (10.1e6,)}, ""),
        (
            State(starved=JUST),
            {"supply": 3.9e6},
            "the supply pressure is 3.90 MPa; allowed: 4.00 MPa or more",
        ),
        (State(starved=JUST - 0.02), {"supply": 3.9e6}, ""),
        (State(), {"temperature": 350.1}, "the oil is at 350.1 K; allowed: up to 350 K"),
    ],
)
def test_the_bounds_of_pressure_and_temperature(state, change, said):
    found = step(state, FINE._replace(**change), RANGES, 0.005)[1]
    assert found.endswith(said) if said else found == ""


def test_the_bounds_of_an_experiment_are_those_of_its_machine():
    boom = C180.boom
    assert BOUNDS.driven == (False, True, False)
    assert (BOUNDS.low[1], BOUNDS.high[1]) == experiment_plan.cylinder_range(boom, 0.05)
    assert (BOUNDS.low[2], BOUNDS.high[2]) == experiment_plan.cylinder_range(C180.stick, 0.05)
    assert (BOUNDS.low[0], BOUNDS.high[0]) == joint_limits(C180)[0]
    relief = C180.port_valves.relief_pressure
    assert BOUNDS.pressure == 1.5 * max(C180.pump.supply_pressure, relief)
    assert BOUNDS.supply == 0.25 * C180.pump.idle_pressure
    edges = (C180.valve_of(i).law for i in range(3))
    assert BOUNDS.open == tuple(
        1.0 + max(law.forward.deadband_voltage, law.backward.deadband_voltage) for law in edges
    )
    bare = PLAN._replace(machine=dataclasses.replace(C180, port_valves=None))
    assert bounds(bare, bare.programme).pressure == 1.5 * C180.pump.supply_pressure


def test_a_driven_swing_may_go_beyond_its_turns_but_not_to_its_ends():
    plan = experiment_plan.plan("motor_external", C180)
    track = plan.programme.tracks[0]
    low, high = joint_limits(C180)[0]
    for turns, ends in (
        ((-0.5, 0.7), (-0.9, 1.1)),
        ((low + 0.2, high - 0.2), (low + 0.05, high - 0.05)),
    ):
        tracks = (track._replace(low=turns[0], high=turns[1]), *plan.programme.tracks[1:])
        found = bounds(plan, plan.programme._replace(tracks=tracks))
        assert (found.low[0], found.high[0]) == pytest.approx(ends)
    near = safety_monitor.around(plan.programme, plan, low + 0.3).tracks[0]
    assert near.low == pytest.approx(low + 0.1)


def test_what_is_driven_and_monitored_are_the_axes_of_the_programme():
    tracks = experiment_plan.plan("motor_external", C180).programme.tracks
    for joint, name in enumerate(("swing", "boom", "stick")):
        alone = tuple(tracks[0] if i == joint else None for i in range(3))
        plan = PLAN._replace(programme=PLAN.programme._replace(tracks=alone))
        assert bounds(plan, plan.programme).driven == tuple(i == joint for i in range(3))
        assert safety_monitor.monitored_ports(plan) == (f"{name}_1_actuator", f"{name}_2_actuator")
    none = PLAN._replace(programme=PLAN.programme._replace(tracks=(None, None, None)))
    assert safety_monitor.monitored_ports(none) == ("swing_1_actuator", "swing_2_actuator")


def test_a_swing_that_is_not_driven_or_of_a_rig_goes_about_nothing():
    assert safety_monitor.around(PLAN.programme, PLAN, 0.7) == PLAN.programme
    rig = experiment_plan.plan("valve", C180)
    assert safety_monitor.around(rig.programme, rig, 0.7) == rig.programme
    assert State()[:3] == (0.0, 0.0, ZERO)


def test_each_valve_is_open_a_volt_beyond_the_wider_of_its_own_overlaps(monkeypatch):
    laws = []
    for forward, backward in ((0.5, 0.9), (1.1, 0.7), (0.3, 0.2)):
        law = C180.valve_of(0).law
        laws.append(
            law._replace(
                forward=law.forward._replace(deadband_voltage=forward),
                backward=law.backward._replace(deadband_voltage=backward),
            )
        )
    monkeypatch.setattr(type(C180), "valve_of", lambda _machine, axis: SimpleNamespace(law=laws[axis]))
    assert bounds(PLAN, PLAN.programme).open == pytest.approx((1.9, 2.1, 1.3))
