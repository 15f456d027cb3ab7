"""The estimators on records made by hand: unlike motions, negative rates, port 2, and both directions.

What goes in is put together here from the thesis' equations, without the simulator that made the records of
`test_estimators`.
"""

import dataclasses
import math

import numpy as np
import pytest
from energies import kinetic_energy, potential_energy

from forest_description.derived.temperature import at_temperature
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_ident.estimators import (
    calibration,
    damping,
    gravity,
    hose_estimators,
    motor_leakage,
)
from forest_ident.measurements.session import Session, SessionError
from forest_ident.online.recursive_least_squares import Estimator, start, step
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Channel
from forest_sim.mechanics.manipulator import fold_head

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")
BODY = fold_head(C180.manipulator)
PERIOD = 0.005
EXACT = {"exact_sensors": 1.0}


def session(name, readings, voltages=None, facts=EXACT, period=PERIOD):
    rows = len(next(iter(readings.values())))
    volts = np.zeros((rows, 3)) if voltages is None else np.asarray(voltages, dtype=float)
    return Session(name, np.arange(rows) * period, volts, readings, facts)


# -- damping: (4.10), (4.11)


def joint_torques(q, rates, accelerations):
    """d/dt dT/dq' - dT/dq + dU/dq by central differences of the energies."""
    h = 1e-4

    def momentum(angles, u):
        moved = (tuple(x + h * s * (i == k) for i, x in enumerate(u)) for k in range(3) for s in (1, -1))
        t = [kinetic_energy(angles, m, BODY) for m in moved]
        return np.array([(t[2 * k] - t[2 * k + 1]) / (2.0 * h) for k in range(3)])

    def lagrangian(angles):
        return kinetic_energy(angles, rates, BODY) - potential_energy(angles, BODY)

    later, before = (
        momentum(
            tuple(x + s * h * u for x, u in zip(q, rates, strict=True)),
            tuple(u + s * h * a for u, a in zip(rates, accelerations, strict=True)),
        )
        for s in (1, -1)
    )
    shift = np.eye(3) * h
    slope = [(lagrangian(tuple(q + d)) - lagrangian(tuple(q - d))) / (2.0 * h) for d in shift]
    return (later - before) / (2.0 * h) - np.array(slope)


@pytest.fixture(scope="module")
def motion():
    """Times, angles, rates and torques of a motion in which every joint has its own frequency."""
    t = np.arange(0.0, 10.0, 2.0 * PERIOD)
    middles, sizes = np.array([0.2, 0.5, -1.5]), np.array([0.5, 0.25, 0.3])
    pulses, phases = 2.0 * np.pi * np.array([0.23, 0.31, 0.19]), np.array([0.3, 1.1, -0.6])
    turn = np.outer(t, pulses) + phases
    q, u = middles + sizes * np.sin(turn), sizes * pulses * np.cos(turn)
    a = -sizes * pulses**2 * np.sin(turn)
    return t, q, u, np.array([joint_torques(*map(tuple, rows)) for rows in zip(q, u, a, strict=True)])


@pytest.mark.parametrize(
    ("axis", "viscous", "dry", "pressed"),
    [
        (0, 3.1e4, False, 0.0),
        (1, 0.9e5, False, 0.0),
        (2, 1.4e5, False, 0.0),
        (1, 0.9e5, True, 0.0),
        (2, 1.4e5, True, 0.0),
        (2, 1.4e5, True, 4e-4),
    ],
)
def test_damping_is_what_the_force_leaves_over_while_all_joints_move(axis, viscous, dry, pressed, motion):
    rubbing = dataclasses.replace(LOADER.boom.friction, coulomb_force=9e3, breakaway_force=9e3)
    if pressed:
        rubbing = dataclasses.replace(rubbing, pressure_coefficient=pressed)
    machine, (t, q, u, torques) = C180, motion
    if dry:
        drive = dataclasses.replace(getattr(C180, AXES[axis]), friction=rubbing)
        machine = dataclasses.replace(C180, **{AXES[axis]: drive})
    drive = machine.drives[axis]
    arm, areas = 1.0, [machine.swing.gear_ratio * machine.swing.motor_displacement] * 2
    if axis:
        b, c, phi = drive.pivot_to_base, drive.pivot_to_rod, drive.angle_offset + q[:, axis]
        arm = b * c * np.sin(phi) / np.sqrt(b * b + c * c - 2.0 * b * c * np.cos(phi))
        areas = [drive.head_area, drive.rod_area]
    speed = arm * u[:, axis]
    sign = speed / np.sqrt(speed**2 + rubbing.smoothing_speed**2) if dry else 0.0
    force = torques[:, axis] / arm + viscous * speed + 9e3 * sign + 700.0
    two = 8e6 + 2e6 * np.sin(0.7 * t)
    rod_share = pressed * sign  # of what each port's pressure does to the seals
    readings = {f"{name}_resolver": q[:, k] for k, name in enumerate(AXES)}
    readings[f"{AXES[axis]}_pressure_1_actuator"] = (force + (areas[1] + rod_share) * two) / (
        areas[0] - rod_share
    )
    readings[f"{AXES[axis]}_pressure_2_actuator"] = two
    line = damping.damping(machine, session("damping", readings, period=2.0 * PERIOD), axis)
    assert line.values[0] == pytest.approx(viscous, rel=0.01)
    assert line.values[1] == pytest.approx(700.0, abs=0.01 * viscous * np.abs(speed).max())


# -- the motor's leakage: (4.7) to (4.9)


def creep(way, drain=True, temperature=330.0, shown=True):
    """The loaded chamber is port 1's for way = 1, port 2's for -1; warm oil leaks more.

    Unless it is shown, the other chamber's transducer stands at its zero.
    """
    t = np.arange(0.0, 40.0, PERIOD)
    warm = at_temperature(C180, temperature).swing
    high, low = 7e6 + 5e5 * np.sin(0.2 * t), 3e5 + 1e5 * np.cos(0.3 * t)
    inside, outside = 1.0 / warm.internal_leakage_resistance, 1.0 / warm.external_leakage_resistance
    d = C180.swing.gear_ratio * C180.swing.motor_displacement
    rate = -way * ((high - low) * inside + high * outside) / d
    flow, low = (high + low) * outside, low if shown else np.zeros(len(t))
    one, two = (high, low) if way > 0 else (low, high)
    readings = {
        "swing_resolver": np.cumsum(rate) * PERIOD,
        "swing_pressure_1_actuator": one,
        "swing_pressure_2_actuator": two,
        "tank_temperature": np.full(len(t), temperature),
    }
    if drain:
        return session("motor_internal", readings | {"case_drain": flow})
    facts = EXACT | {"case_drain_volume": float(np.sum(flow)) * PERIOD}
    return session("motor_internal", readings, facts=facts)


@pytest.mark.parametrize("way", [1, -1])
def test_internal_leakage_is_told_at_the_reference_temperature_whichever_port_is_loaded(way):
    outside = 1.0 / C180.swing.external_leakage_resistance
    line = motor_leakage.internal(C180, creep(way), outside)
    assert 1.0 / line.values[0] == pytest.approx(C180.swing.internal_leakage_resistance, rel=1e-3)


@pytest.mark.parametrize(("drain", "near"), [(True, 1e-3), (False, 1e-2)], ids=["meter", "vessel"])
@pytest.mark.parametrize("way", [1, -1])
def test_the_drain_tells_the_pressure_of_a_chamber_whose_transducer_stands_at_zero(way, drain, near):
    """The vessel knows a mean only; taken for zero, those 3 bar would make R_in 4 % too low."""
    outside = 1.0 / C180.swing.external_leakage_resistance
    line = motor_leakage.internal(C180, creep(way, drain, shown=False), outside)
    assert 1.0 / line.values[0] == pytest.approx(C180.swing.internal_leakage_resistance, rel=near)


@pytest.mark.parametrize("drain", [True, False], ids=["meter", "vessel"])
@pytest.mark.parametrize("way", [1, -1])
def test_external_leakage_counts_both_ports(way, drain):
    line = motor_leakage.external(C180, creep(way, drain))
    assert 1.0 / line.values[0] == pytest.approx(C180.swing.external_leakage_resistance, rel=1e-3)


# -- rests


def rests(m, poses, areas_of=C180):
    """Readings of the crane at rest in poses, 4 s each with a second of voltage in between."""
    columns = {f"{name}_resolver": [] for name in AXES}
    columns |= {f"{name}_pressure_{port}_actuator": [] for name in AXES[1:] for port in (1, 2)}
    volts = []
    for q in poses:
        q_23 = q[1] + q[2]
        g = m.gravity * math.cos(m.platform_tilt)
        stick = g * (
            (m.stick_mass * m.stick_x + m.head_mass * m.stick_length) * math.cos(q_23)
            - m.stick_mass * m.stick_y * math.sin(q_23)
        )
        boom = stick + g * (
            (m.boom_mass * m.boom_x + (m.stick_mass + m.head_mass) * m.boom_length) * math.cos(q[1])
            - m.boom_mass * m.boom_y * math.sin(q[1])
        )
        for moving in (True, False):
            rows = 200 if moving else 800
            volts += [[0.0, 3.0 if moving else 0.0, 0.0]] * rows
            for k, name in enumerate(AXES):
                columns[f"{name}_resolver"] += [q[k] + (0.1 if moving else 0.0)] * rows
            for name, torque, angle in (("boom", boom, q[1]), ("stick", stick, q[2])):
                drive = getattr(areas_of, name)
                a, b, phi = drive.pivot_to_base, drive.pivot_to_rod, drive.angle_offset + angle
                arm = a * b * math.sin(phi) / math.sqrt(a * a + b * b - 2.0 * a * b * math.cos(phi))
                two = 1.5e6
                one = (torque / arm + drive.rod_area * two) / drive.head_area
                ringing = 0 if moving else 300  # rows until the crane has stopped swinging
                columns[f"{name}_pressure_1_actuator"] += [one + 9e6] * (rows if moving else ringing)
                columns[f"{name}_pressure_1_actuator"] += [one] * (0 if moving else rows - ringing)
                columns[f"{name}_pressure_2_actuator"] += [two] * rows
    readings = {name: np.array(column) for name, column in columns.items()}
    return session("gravity", readings, volts)


POSES = [(0.0, -0.4, -1.0), (0.0, 0.3, -1.9), (0.0, 0.9, -1.2), (0.0, 0.1, -1.5), (0.0, 0.6, -2.0)]
HEAVY = dataclasses.replace(
    C180.manipulator, boom_y=0.21, stick_y=-0.13, head_mass=820.0, boom_mass=700.0, platform_tilt=0.1
)


def test_masses_are_weighed_against_those_that_the_file_tells():
    told = dataclasses.replace(HEAVY, head_mass=700.0, boom_mass=635.04)
    machine = dataclasses.replace(C180, manipulator=told)
    line = gravity.masses(machine, rests(HEAVY, POSES), ("head_mass", "boom_mass"))
    assert line.values == pytest.approx([820.0, 700.0], rel=1e-6)
    alone = dataclasses.replace(machine, manipulator=dataclasses.replace(told, boom_mass=700.0))
    assert gravity.masses(alone, rests(HEAVY, POSES)).values == pytest.approx([820.0], rel=1e-6)


@pytest.mark.parametrize(("rows", "counts"), [(80, True), (79, False)])
def test_a_rest_counts_from_two_seconds_after_the_motion_for_at_least_0_4_s(rows, counts):
    record = rests(HEAVY, POSES[:2])
    last = len(record.time) - 800 + 400 + rows
    found, _ = gravity.poses(C180, record.part(0, last))
    assert found == pytest.approx(np.array(POSES[: 1 + counts]))
    from_rest = record.part(200, 200 + 80)  # without a motion before it, there is nothing to wait for
    assert len(gravity.poses(C180, from_rest)[0]) == 1


# -- hoses: (4.4), (4.5a), (4.6)


@pytest.mark.parametrize("laminar", [True, False])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_inertance_and_capacitance_follow_from_flows_either_way(laminar, way):
    """Flows and pressures that obey the line's laws to the last digit, at 1 Hz, oil moving all the time."""
    t, i, c = np.arange(0.0, 12.0, PERIOD), 4e7, 2e-12
    r = 3e8 if laminar else 3e11
    w = 2.0 * np.pi
    q_2 = way * (1e-3 + 4e-4 * np.sin(w * t))
    rate_2 = way * 4e-4 * w * np.cos(w * t)
    p_out = 5e6 + 2e6 * np.sin(1.7 * t)
    p_c = p_out + r * (q_2 if laminar else q_2 * np.abs(q_2))
    p_c_rate = 3.4e6 * np.cos(1.7 * t) + r * (rate_2 if laminar else 2.0 * np.abs(q_2) * rate_2)
    q_1 = q_2 + c * p_c_rate
    p_in = p_c + i * np.gradient(q_1, PERIOD, edge_order=2)
    readings = {
        "swing_pressure_1_valve": p_in,
        "swing_pressure_1_actuator": p_out,
        "swing_flow": q_1,
        "stick_flow": q_2,
    }
    record = session("hose", readings)
    inertance, capacitance = hose_estimators.joint(record, r, laminar, lag=0.0, floor=0.0)
    assert inertance.values[0] == pytest.approx(i, rel=0.01)
    assert capacitance.values[0] == pytest.approx(c, rel=0.02)
    groups = hose_estimators.four_group_means(record, r, laminar)
    assert groups[0] == pytest.approx([i] * 4, rel=0.03)
    assert groups[1] == pytest.approx([c] * 4, rel=0.03)


@pytest.mark.parametrize("laminar", [True, False])
def test_resistance_has_the_flows_sign_and_not_the_transducers_difference(laminar):
    flow = np.array([-1.5e-3, -7e-4, -2e-4, 3e-4, 9e-4, 2e-3])
    drop = (2e9 * flow if laminar else 4e11 * flow * np.abs(flow)) + 3e3
    line = hose_estimators.resistance(flow, drop, laminar)
    assert line.values == pytest.approx([2e9 if laminar else 4e11, 3e3], rel=1e-6)


def test_only_holds_within_the_meters_range_count_whichever_way_the_oil_goes():
    flows = [-2e-3, -4e-5, 3e-5, 6e-4, 3.2e-3, -3.2e-3, 1.1e-3]
    rows = 400
    volts = np.zeros((rows * len(flows), 3))
    volts[:, 0] = np.repeat([-5.0, -1.0, 1.0, 3.0, 9.0, -9.0, 4.0], rows)
    flow, drop = np.repeat(flows, rows), np.repeat([1e5 * k for k in range(1, 8)], rows)
    flow[::rows] *= 0.5  # a hold begins with what the last one left
    readings = {
        "swing_pressure_1_valve": 3e6 + drop,
        "swing_pressure_1_actuator": np.full(len(flow), 3e6),
        "swing_flow": flow,
    }
    found = hose_estimators.steady(session("hose", readings, volts), floor=5e-5, highest=3.2e-3)
    assert found[0] == pytest.approx([-2e-3, 6e-4, 1.1e-3])
    assert found[1] == pytest.approx([1e5, 4e5, 7e5])


def test_meters_that_lag_and_stand_at_their_ends_bias_nothing():
    """A laminar line at 0.1, 0.3 and 2 Hz; the meters lag by 20 ms and end within the flow's swings."""
    t, lag, i, c, r = np.arange(0.0, 20.0, PERIOD), 0.02, 4e7, 2e-12, 3e8
    pulse = 2.0j * np.pi * np.fft.rfftfreq(len(t), PERIOD)

    def through(signal, transfer):
        return np.fft.irfft(np.fft.rfft(signal) * transfer, len(t))

    q_2 = 1e-3 + 4e-4 * np.sin(0.2 * np.pi * t) + 5e-5 * np.sin(4.0 * np.pi * t)
    p_out = 5e6 + 2e6 * np.sin(0.6 * np.pi * t)
    p_c = p_out + r * q_2
    q_1 = q_2 + c * through(p_c, pulse)
    read = [through(q, 1.0 / (1.0 + lag * pulse)) for q in (q_1, q_2)]
    readings = {
        "swing_pressure_1_valve": p_c + i * through(q_1, pulse),
        "swing_pressure_1_actuator": p_out,
        "swing_flow": np.minimum(read[0], 1.1e-3),
        "stick_flow": np.clip(read[1], 8.5e-4, 1.15e-3),
    }
    inertance, capacitance = hose_estimators.joint(
        session("hose", readings), r, True, lag, floor=8.5e-4, highest=1.1e-3
    )
    assert inertance.values[0] == pytest.approx(i, rel=0.02)
    assert capacitance.values[0] == pytest.approx(c, rel=0.02)


def test_a_quarter_of_a_second_on_either_side_of_the_meters_floor_is_left_out():
    """Ten times the pressure, up to 0.17 s from a sample at the floor: smoothing spreads it further."""
    t, i, c, r, w = np.arange(0.0, 12.0, PERIOD), 4e7, 2e-12, 3e8, 2.0 * np.pi
    q_2, rate_2 = 1e-3 + 4e-4 * np.sin(w * t), 4e-4 * w * np.cos(w * t)
    p_out = 5e6 + 2e6 * np.sin(1.7 * t)
    q_1 = q_2 + c * (3.4e6 * np.cos(1.7 * t) + r * rate_2)
    p_in = p_out + r * q_2 + i * np.gradient(q_1, PERIOD, edge_order=2)
    q_2[[400, 1200]] = 5e-5
    for at in (400, 1200):
        p_in[at - 34 : at + 35] *= 10.0
    readings = {
        "swing_pressure_1_valve": p_in,
        "swing_pressure_1_actuator": p_out,
        "swing_flow": q_1,
        "stick_flow": q_2,
    }
    inertance, _ = hose_estimators.joint(session("hose", readings), r, True, lag=0.0, floor=5e-5)
    assert inertance.values[0] == pytest.approx(i, rel=0.01)


# -- running estimates


def test_running_estimates_are_those_of_a_fit_that_forgets():
    """theta and P by the whole sum, sample k counting exp(-(t_n - t_k)/T), at uneven times."""
    luck, memory = np.random.default_rng(3), 1.7
    x, gaps = luck.normal([0.5, -2.0], 1.0, (60, 2)), luck.uniform(0.01, 0.2, 60)
    y = x @ [-1.5, 0.7] + luck.normal(0.0, 0.1, 60)
    first, spread = np.array([0.4, -0.3]), np.array([2.0, 0.5])
    e = start(tuple(first), tuple(spread))
    for row, value, gap in zip(x.tolist(), y.tolist(), gaps.tolist(), strict=True):
        e = step(e, (row[0], row[1]), value, gap, memory)
    age = np.append(np.cumsum(gaps[::-1])[::-1], 0.0)  # of what was known before each sample
    weights, begin = np.exp(-age[1:] / memory), np.exp(-age[0] / memory) * np.diag(spread**-2.0)
    information = x.T @ (weights[:, np.newaxis] * x) + begin
    best = np.linalg.solve(information, x.T @ (weights * y) + begin @ first)
    assert e.theta == pytest.approx(best, rel=1e-9)
    p = np.linalg.inv(information)
    assert e.covariance == pytest.approx([p[0, 0], p[0, 1], p[1, 1]], rel=1e-9)


def test_a_bounded_covariance_keeps_its_shape():
    e = Estimator((0.0, 0.0), (9e7, -4e7, 6e7), 1.0, 5.0)
    after = step(e, (0.0, 0.0), 0.0, 1.0, 1.0)
    grown = np.array([9e7, -4e7, 6e7]) * math.e
    assert after.covariance == pytest.approx(grown * 1e8 / grown.max())


# -- how channels are judged


def uniform(width):
    """Standard deviation of what lies evenly within +- half a width."""
    return width / math.sqrt(12.0)


def test_every_kind_of_sensor_is_judged_by_its_own_accuracy():
    volts = np.zeros((600, 3))
    volts[300:, 1] = -2.0
    record = session("motion", {"boom_resolver": np.zeros(600)}, volts, facts={})
    s = C180.sensors
    pressure = noise_model.channel(C180, record, "stick_pressure_2_actuator")
    assert pressure.noise == s.pressure.noise
    assert pressure.offset == pytest.approx(uniform(2.0 * s.pressure.accuracy * s.pressure.full_scale))
    assert (pressure.gain, pressure.zero, pressure.high) == (0.0, True, s.pressure.full_scale)
    flow = noise_model.channel(C180, record, "stick_flow")
    assert flow.gain == pytest.approx(uniform(2.0 * s.flow_meter.accuracy))
    meter = s.flow_meter
    assert (flow.offset, flow.floor, flow.high, flow.noise) == (0.0, meter.lowest, meter.highest, meter.noise)
    length = noise_model.channel(C180, record, "boom_transducer")
    grain = uniform(s.linear_transducer.full_scale * s.linear_transducer.resolution)
    assert length.offset == pytest.approx(grain)
    assert length.noise == pytest.approx(math.hypot(s.linear_transducer.noise, grain))
    turn = dataclasses.replace(s.resolver, resolution=2.0 * math.pi / 4096)
    coarse = dataclasses.replace(C180, sensors=dataclasses.replace(s, resolver=turn))
    angle, grain = noise_model.channel(coarse, record, "boom_resolver"), uniform(turn.resolution)
    assert angle.noise == pytest.approx(math.hypot(turn.noise, grain))
    assert angle.offset == pytest.approx(math.hypot(turn.noise / math.sqrt(300), grain), rel=1e-3)
    drain = noise_model.channel(C180, record, "case_drain")
    assert (drain.offset, drain.gain) == (0.0, pytest.approx(uniform(2.0 * s.case_drain.accuracy)))
    spool = noise_model.channel(C180, record, "swing_spool")
    assert (spool.offset, spool.gain) == (pytest.approx(uniform(2.0 * s.spool_sensor.accuracy)), 0.0)


def test_a_sensor_of_which_the_file_tells_nothing_is_as_good_as_exact():
    s, record = C180.sensors, session("motion", {"boom_resolver": np.zeros(9)}, facts={})
    plain = dataclasses.replace(s.pressure, noise=None, accuracy=None)
    bare = dataclasses.replace(
        C180,
        sensors=dataclasses.replace(
            s, pressure=plain, linear_transducer=None, resolver=dataclasses.replace(s.resolver, noise=None)
        ),
    )
    read = noise_model.channel(bare, record, "stick_pressure_2_actuator")
    assert (read.noise, read.offset, read.zero, read.high) == (100.0, 0.0, True, s.pressure.full_scale)
    assert noise_model.channel(bare, record, "boom_transducer") == Channel("boom_transducer", 1e-6)
    angle = noise_model.channel(bare, record, "boom_resolver")
    assert angle.noise == pytest.approx(max(uniform(s.resolver.resolution or 0.0), 1e-6))
    assert noise_model.accuracy(bare, record, "linear_transducer") == 0.0
    assert noise_model.accuracy(bare, record, "pressure") == 0.0
    assert noise_model.accuracy(C180, record, "pressure") == pytest.approx(
        s.pressure.accuracy / math.sqrt(3.0)
    )
    silent = dataclasses.replace(bare, sensors=dataclasses.replace(bare.sensors, resolver=None))
    assert noise_model.start_noise(silent, record, "boom.angle") == 0.0


def test_only_channels_that_are_there_and_move_count():
    still, moving, broken = np.full(9, 2.0), np.arange(9.0), np.r_[np.nan, np.arange(8.0)]
    names = ("boom_resolver", "swing_resolver", "stick_resolver", "boom_transducer")
    record = session("motion", dict(zip(names, (still, moving, broken), strict=False)))
    assert [c.name for c in noise_model.channels(C180, record, names)] == ["swing_resolver"]


@pytest.mark.parametrize(
    "name", ["stick_pressure_2_actuator", "stick_flow", "boom_transducer", "swing_spool"]
)
def test_exact_sensors_have_no_static_error(name):
    judged = noise_model.channel(C180, session("motion", {"boom_resolver": np.zeros(9)}), name)
    assert (judged.offset, judged.gain, judged.floor, judged.zero, judged.high) == (0, 0, 0, False, math.inf)
    assert 0.0 < judged.noise <= 100.0


# -- calibration


def baths(offset, gain, ice=8.0, water=9.5):
    time = np.arange(0.0, 20.0, PERIOD)
    true = np.where(time < ice, 273.15, np.where(time > water, 373.15, 320.0))
    reading = 273.15 + gain * (true - 273.15) + offset
    facts = {"ice_until": ice, "boiling_from": water}
    return session("calibration", {"tank_temperature": reading}, facts=facts)


@pytest.mark.parametrize(("offset", "gain"), [(0.4, 1.01), (-1.3, 0.98)])
def test_a_thermocouples_offset_is_the_ice_points_and_its_gain_that_between_the_baths(offset, gain):
    (found,) = calibration.calibrate(C180, baths(offset, gain))
    assert (found.offset, found.gain) == (pytest.approx(offset), pytest.approx(gain))


def test_a_bath_that_is_none_is_named():
    with pytest.raises(SessionError, match=r"tank_temperature reads 303.. K in ice"):
        calibration.calibrate(C180, baths(30.0, 1.0))
    with pytest.raises(SessionError, match=r"tank_temperature reads 343.. K in boiling water"):
        calibration.calibrate(C180, baths(0.0, 0.7))


@pytest.mark.parametrize("gain", [1.03, 0.96])
def test_the_second_meters_gain_is_over_the_first_whichever_way_the_oil_goes(gain):
    one = np.repeat([-2e-3, -1e-3, 1.5e-3, 2.5e-3, 1e-5], 50)
    two = np.where(np.abs(one) > 1e-4, gain * one, 8e-5)  # at its floor, it tells nothing
    found = calibration.meter_gain(session("valve", {"swing_flow": one, "stick_flow": two}), 5e-5)
    assert found.gain == pytest.approx(gain, rel=1e-9)
    assert calibration.meter_gain(session("valve", {"swing_flow": one}), 5e-5) is None


@pytest.mark.parametrize("at", [3, 8])
def test_a_bend_at_a_change_of_the_voltage_is_made_up_for_by_a_twelfth_of_it(at):
    """Three samples on either side tell both slopes; nearer to an end a bend stays."""
    rows = np.arange(12.0)
    column = 2.0 * rows + 0.6 * np.maximum(rows - at, 0.0)
    voltage = np.where(rows < at, 1.0, 2.0)
    found = hose_estimators.unbent(column, voltage)
    assert found - column == pytest.approx(np.where(rows == at, 0.6 / 12.0, 0.0))
    for near in (2, 9):
        assert [*hose_estimators.unbent(column, np.where(rows < near, 1.0, 2.0))] == [*column]
