"""Machine files whose numbers contradict each other are refused: file, line, key, and what is allowed."""

import dataclasses
import re

import numpy as np
import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_description.mechanics.drives import Friction
from forest_description.mechanics.inertia import require_rigid

C180, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")


def written(text):
    """A machine file in which "= 3 kg" stands for a number with its unit and a source."""
    return re.sub(r"= (\S+) (\S+)", r"{value: \1, unit: \2, source: x}", text)


MASSLESS = """manipulator:
  stick_mass: = 0 kg
  head_mass: = 0 kg
  stick_xx: = 0 kg*m2
  stick_yy: = 0 kg*m2
  stick_zz: = 0 kg*m2
"""
LONG = """stick:
  pivot_to_base: = 1.6 m
  pivot_to_rod: = 1.2 m
  retracted_length: = 1.2 m
  stroke: = 1.5 m
"""
GRAPPLE = """manipulator:
  pendulum:
    kind: grapple
    rotator_mass: = {mass} kg
    rotator_centre: = {centre} m
    rotator_length: = 0.5 m
    grapple_centre: = 0.5 m
    grapple_inertia: = 90 kg*m2
    grip: = 0.8 m
    damping: = 400 N*m*s/rad
"""
CAPACITY = """capacity:
  reach: {{values: [{reach}], unit: m, source: x}}
  load: {{values: [{load}], unit: kg, source: x}}
"""
EDGE = "  leakage_edge_ratio: = 20 1\n"
BODIES = [
    (
        "c180_hoses",
        "boom_xx: = 0 kg*m2",
        "boom_zz (833.6518 kg*m2) must not be above boom_xx + boom_yy (756.0469",
    ),
    (
        "c180_hoses",
        "boom_xx: = 0 kg*m2",
        "no rigid body has such moments of inertia; allowed: boom_xx of 77.6049 ",
    ),
    ("c180_thesis", "boom_xx: = 40 kg*m2", "allowed: boom_xx of 77.6049 kg*m2 or more"),
    ("c180_thesis", "stick_yy: = 900 kg*m2", "stick_yy (900 kg*m2) must not be above"),
    ("c180_hoses", "stick_zz: = 1000 kg*m2", "stick_zz (1000 kg*m2) must not be above"),
    ("loader", "stick_yy: = 19 kg*m2", "allowed: stick_xx of 0.9 kg*m2 or more"),
    ("loader", "boom_xx: = 70 kg*m2", "allowed: boom_yy of 37.6 kg*m2 or more"),
    ("loader", "boom_xy: = -9 kg*m2", "allowed: -5.994789 .. 5.994789 kg*m2"),
    (
        "c180_hoses",
        "stick_mass: = 0 kg",
        "stick_mass is 0 kg: a body without mass has no inertia; allowed: above 0",
    ),
]
COMPENSATOR = (
    "valve:\n  compensator:\n    kind: {kind}\n    setting: = {setting} MPa\n    control_range: = 0.4 MPa\n"
    "    minimum_resistance: = 5e10 Pa*s2/m6\n    response_time: = 15 ms\n"
)
ENGINE = """pump:
  engine:
    inertia: = 3 kg*m2
    droop: = {droop} percent
    torque: = {torque} N*m
    stall_speed: = {stall} rpm
"""
PILOT_CHECK = """stick:
  holding_2:
    kind: pilot_check
    setting: = 0.3 MPa
    pilot_ratio: = 1.2 1
    hysteresis: = 0 Pa
    opening_range: = 1 MPa
    minimum_resistance: = 1e11 Pa*s2/m6
    check_resistance: = 1e11 Pa*s2/m6
    response_time: = 10 ms
"""
ROOT = "    damping: = 0 N*m*s/rad\n    root_inertia: = 90 kg*m2\n"
OTHERS = [
    (
        "forwarder",
        "valve:\n  compensator:\n    minimum_resistance: = 5e16 Pa*s2/m6\n",
        4,
        "valve.compensator.minimum_resistance (5e+16 Pa*s2/m6) takes",
    ),
    (
        "forwarder",
        "boom:\n  elasticity:\n    damping: = 1e9 N*m*s/rad\n",
        4,
        "boom.elasticity.damping (1e+09 N*m*s/rad): the link would creep rather than swing; allowed: below",
    ),
    (
        "forwarder",
        "boom:\n  elasticity:\n    root_inertia: = 1e5 kg*m2\n",
        4,
        "more than the outstretched crane has about this joint; allowed: below 3.489e+04 kg*m2",
    ),
    (
        "c180",
        "swing:\n  backlash:\n    motor_inertia: = 9 kg*m2\n",
        4,
        "swing.backlash.motor_inertia (9 kg*m2): through the gear more than the outstretched crane has",
    ),
    (
        "c180",
        "swing:\n  backlash:\n    damping: = 1e9 N*m*s/rad\n",
        4,
        "the motor would creep on its teeth rather than strike them; allowed: below 1.248e+06 N*m*s/rad",
    ),
    (
        "forwarder",
        "boom:\n  holding_1:\n    setting: = 60 MPa\n",
        4,
        "boom.holding_1.setting (6e+07 Pa): without a load the pump's full pressure on the other side does",
    ),
    ("c180", PILOT_CHECK, 5, "(1.2); allowed: a pilot_ratio above 1.348, or a lower setting"),
    (
        "forwarder",
        "pump:\n  shaft_speed: = 1400 rpm\n  engine:\n    droop: = 50 percent\n",
        5,
        "pump.engine.stall_speed (78.5398 rad/s) must be below the speed at greatest torque (73.3038",
    ),
    ("forwarder", "chassis:\n  centre_ahead: = 6 m\n", 3, ": chassis.centre_ahead (6 m): the vehicle falls"),
    (
        "c180_hoses",
        CAPACITY.format(reach="4, 8", load="900, 500"),
        3,
        "capacity.reach ends at 8 m; allowed: at least 8.570 m, as far as straight links reach",
    ),
    (
        "c180_hoses",
        CAPACITY.format(reach="4, 9", load="900"),
        4,
        "capacity.load (1 numbers) must have as many as reach (2)",
    ),
    (
        "c180_hoses",
        CAPACITY.format(reach="4, 9", load="500, 900"),
        4,
        "capacity.load (500, 900 kg) must not grow with the reach",
    ),
    (
        "c180_hoses",
        CAPACITY.format(reach="9, 4", load="900, 500"),
        3,
        "capacity.reach (9, 4 m) must rise from number to number",
    ),
    (
        "c180_hoses",
        CAPACITY.format(reach="9", load="900"),
        3,
        "capacity.reach has 1 numbers; allowed: 2 .. 8",
    ),
    (
        "c180_hoses",
        CAPACITY.format(reach="4, 9", load="-900, -950"),
        4,
        "capacity.load = -900 kg is outside the range 1 .. 100000 kg",
    ),
    ("c180_thesis", "manipulator:\n  head_folding: full\n", 2, "allowed: boom_xx of 77.6049 kg*m2 or more"),
    (
        "c180_hoses",
        MASSLESS,
        3,
        "manipulator.stick_mass: nothing resists the stick's acceleration; allowed: a mass",
    ),
    (
        "c180_hoses",
        "valve:\n  spool_bandwidth: null\n  spool_damping: = 0.7 1\n",
        4,
        "valve.spool_damping (0.7) is of a lag that spool_bandwidth: null leaves out; allowed: null, or a",
    ),
    ("loader", "valve:\n  spool_bandwidth: null\n", 3, "valve.spool_damping (0.75) is of a lag"),
    ("loader", "stick:\n  valve:\n    spool_bandwidth: null\n", 4, "stick.valve.spool_damping (0.75) is"),
    ("c180_hoses", LONG, 6, "stick.stroke (1.5 m) must be smaller than retracted_length (1.2 m)"),
    (
        "c180_hoses",
        "boom:\n  angle_offset: = -62 deg\n",
        3,
        "boom.angle_offset: over the stroke the boom goes from 87.3 to 196.0 deg; allowed: within -180",
    ),
    (
        "c180_hoses",
        "boom:\n  angle_offset: = 300 deg\n",
        3,
        "the boom goes from -274.7 to -166.0 deg; allowed",
    ),
    (
        "c180_hoses",
        GRAPPLE.format(mass=700, centre=0.2),
        5,
        "pendulum.rotator_mass (700 kg) must be smaller than head_mass (700 kg): the head is rotator and",
    ),
    (
        "c180",
        "manipulator:\n  pendulum:\n    grapple_inertia: = 1e6 kg*m2\n",
        4,
        "600 kg would lie 40.8 m from their centre; allowed: at most 5400 kg*m2, 3 m",
    ),
    (
        "loader",
        "manipulator:\n  pendulum:\n    inertia: = 500 kg*m2\n",
        4,
        "46 kg would lie 3.3 m from their centre; allowed: at most 414 kg*m2, 3 m",
    ),
    (
        "c180",
        "manipulator:\n  pendulum:\n    grip: = 15 m\n",
        4,
        "grip = 15 m is outside the range 0 .. 5 m",
    ),
    (
        "c180_hoses",
        GRAPPLE.format(mass=100, centre=0.6),
        6,
        "manipulator.pendulum.rotator_centre (0.6 m) must be smaller than rotator_length (0.5 m)",
    ),
    (
        "c180_hoses",
        GRAPPLE.format(mass=-1, centre=0.2),
        5,
        "rotator_mass = -1 kg is outside the range 0 .. 100000",
    ),
    (
        "c180_hoses",
        "manipulator:\n  pendulum:\n    kind: claw\n",
        4,
        "manipulator.pendulum.kind = 'claw' is unknown; allowed: no kind, grapple",
    ),
    (
        "loader",
        "manipulator:\n  log:\n    mass: = 80 kg\n    x: = 0.6 m\n    y: = 0 m\n    length: = 70 m\n",
        7,
        "manipulator.log.length = 70 m is outside the range 0 .. 50 m",
    ),
    (
        "c180_hoses",
        "port_valves:\n  relief_pressure: = 200 bar\n",
        3,
        "port_valves.relief_pressure (2e+07 Pa) must not be below pump.supply_pressure (2.06841e+07 Pa)",
    ),
    (
        "c180_hoses",
        "pump:\n  relief_pressure: = 400 bar\n  supply_pressure: = 300 bar\n",
        4,
        "port_valves.relief_pressure (2.41e+07 Pa) must not be below pump.supply_pressure (3e+07 Pa)",
    ),
    (
        "c180_hoses",
        "port_valves:\n  anticavitation_pressure: = 9 bar\n  relief_pressure: = 4 bar\n",
        3,
        "port_valves.anticavitation_pressure (900000 Pa) must be smaller than relief_pressure (400000 Pa)",
    ),
    ("c180_hoses", "pump:\n  count: = 1.5 1\n", 3, "pump.count (1.5) must be a whole number"),
    (
        "c180_hoses",
        "pump:\n  leakage_resistance: = 5e9 Pa*s/m3\n",
        3,
        "pump.leakage_resistance (5e+09 Pa*s/m3) lets all that the pumps deliver (0.00375 m3/s) back",
    ),
    (
        "c180_hoses",
        "pump:\n  engine_power: = 2.5 kW\n",
        3,
        "pump.engine_power (2500 W) does not even hold supply_pressure against leakage_resistance; allowed",
    ),
    (
        "c180_hoses",
        "pump:\n  compensator_band: = 9 MPa\n  supply_pressure: = 8 MPa\n",
        3,
        "pump.compensator_band (9e+06 Pa) must be smaller than supply_pressure (8e+06 Pa)",
    ),
    (
        "c180_hoses",
        "pump:\n  stroke_up_time: = 0 s\n  stroke_down_time: = 1 s\n",
        3,
        "= 0 s is outside the range 0.001",
    ),
    (
        "loader",
        "pump:\n  stroke_up_time: = 50 ms\n",
        3,
        "pump.stroke_up_time alone; allowed: stroke_up_time and",
    ),
    ("loader", "pump:\n  stroke_down_time: = 50 ms\n", 3, "pump.stroke_down_time alone; allowed: stroke_up"),
    (
        "c180_hoses",
        "pump:\n  torque_limit: = -90 N*m\n",
        3,
        "pump.torque_limit = -90 N*m is outside the range 1",
    ),
    (
        "c180_hoses",
        "pump:\n  torque_limit: = 8 N*m\n",
        3,
        "pump.torque_limit (8 N*m) does not even hold supply_pressure against leakage_resistance",
    ),
    (
        "c180_hoses",
        ENGINE.format(droop=120, torque=550, stall=800),
        5,
        "droop = 120 percent (1.2) is outside the range 0.001 .. 0.5",
    ),
    (
        "c180_hoses",
        ENGINE.format(droop=0, torque=550, stall=800),
        5,
        "pump.engine.droop = 0 percent (0) is outside",
    ),
    (
        "c180_hoses",
        ENGINE.format(droop=8, torque=-550, stall=800),
        6,
        "torque = -550 N*m is outside the range 1",
    ),
    (
        "c180_hoses",
        ENGINE.format(droop=8, torque=9, stall=800),
        6,
        "pump.engine.torque (9 N*m) does not even hold",
    ),
    (
        "c180_hoses",
        ENGINE.format(droop=8, torque=550, stall=2400),
        7,
        "pump.engine.stall_speed (251.327 rad/s) must be below the speed at greatest torque (240.855",
    ),
    (
        "c180_hoses",
        "tank_line:\n  preload: = 2 bar\n  resistance: = 2e12 Pa*s2/m6\n  capacitance: = 1e-11 m3/Pa\n",
        4,
        "tank_line.resistance (2e+12 Pa*s2/m6) takes 2.8325e+07 Pa at the pump's full flow, with its",
    ),
    (
        "c180_hoses",
        "tank_line:\n  preload: = 2 bar\n  resistance: = 0 Pa*s2/m6\n  capacitance: = 1e-11 m3/Pa\n",
        4,
        "tank_line.resistance = 0 Pa*s2/m6 is outside the range 1e+07 .. 1e+14 Pa*s2/m6",
    ),
    (
        "loader",
        "pump:\n  compensator_band: = 22 bar\n",
        3,
        "pump.compensator_band (2.2e+06 Pa) must be smaller than margin (2.2e+06 Pa)",
    ),
    (
        "loader",
        "boom:\n  friction:\n    smoothing_speed: = 0.02 m/s\n",
        4,
        "boom.friction.smoothing_speed (0.02 m/s) must be smaller than stribeck_speed (0.012 m/s)",
    ),
    (
        "c180_hoses",
        "valve:\n  centring_force: = 50 N/V\n",
        3,
        "valve.centring_force (50 N/V): at pump.supply_pressure the flow forces would take half of",
    ),
    (
        "c180_hoses",
        "valve:\n  centring_force: = 100 N/V\n  spool_bandwidth: null\n",
        3,
        "valve.centring_force is of a spool that flow forces push; allowed: with a spool_bandwidth",
    ),
    (
        "c180_hoses",
        "valve:\n  centring_force: = 100 N/V\noil: null\n",
        4,
        "oil is null, but valve.centring_force needs its density",
    ),
    (
        "c180_hoses",
        "valve:\n" + EDGE,
        3,
        "valve.leakage_edge_ratio is of leakage through an overlap; allowed: a leakage_conductance and a",
    ),
    (
        "c180_hoses",
        "valve:\n  deadband_voltage: = 0 V\n  leakage_conductance: = 1e-14 m3/(s*Pa)\n" + EDGE,
        5,
        "deadband_voltage above 0 in both directions",
    ),
    (
        "c180",
        "boom:\n  friction:\n    pressure_coefficient: = 0.01 N/Pa\n",
        4,
        "the seals would hold the rod side's piston; allowed: below 0.009234 N/Pa, rod_area times",
    ),
    (
        "c180",
        "stick:\n  friction:\n    coulomb_force: = 0 N\n",
        4,
        "stick.friction.pressure_coefficient is of seals that pressure adds to; allowed: a coulomb_force",
    ),
    (
        "c180",
        "swing:\n  friction:\n    breakaway_torque: = 700 N*m\n",
        4,
        "swing.friction.breakaway_torque (700 N*m) must not be below coulomb_torque (800 N*m)",
    ),
    (
        "c180",
        "swing:\n  friction:\n    stiffness: = 1e5 N*m/rad\n",
        4,
        "swing.friction.stiffness (100000 N*m/rad): the bearing would turn 0.011 rad before it breaks away",
    ),
    (
        "c180",
        "swing:\n  friction:\n    breakaway_torque: = 40000 N*m\n    stiffness: = 1e8 N*m/rad\n",
        4,
        "swing.friction.breakaway_torque (40000 N*m) must be smaller than what the motor has",
    ),
    (
        "c180",
        "swing:\n  backlash:\n    free_way: = 5 deg\n  lower_limit: = -1 deg\n  upper_limit: = 1 deg\n",
        4,
        "swing.backlash.free_way (0.0872665 rad) must be smaller than the swing's travel (0.0349066 rad)",
    ),
    (
        "c180",
        "stick:\n  chambers:\n    rod_dead_volume: = 13 L\n",
        4,
        "stick.chambers.rod_dead_volume (0.013 m3) must be at most what the stroke sweeps (0.0125",
    ),
    (
        "c180",
        "oil:\n  air:\n    vapour_pressure: = 0.49 bar\n",
        4,
        "oil.air.vapour_pressure = 0.49 bar (49000 Pa) is outside the range 0 .. 20000 Pa",
    ),
    (
        "c180",
        "oil:\n  air:\n    share: = 60 percent\n",
        4,
        "= 60 percent (0.6) is outside the range 1e-05 .. 0.2",
    ),
    (
        "c180",
        "oil:\n  air:\n    tank_pressure: = 0 bar\n",
        4,
        "= 0 bar (0 Pa) is outside the range",
    ),
    (
        "c180_hoses",
        "oil:\n  air:\n    share: = 1 percent\n",
        3,
        "missing key oil.air.dissolving_pressure",
    ),
    (
        "c180",
        "valve:\n  rated_voltage: = 1.15 V\n",
        3,
        "valve.hysteresis (0.4 V) keeps the valve shut at rated_voltage (1.15 V); allowed: below 0.3 V",
    ),
    (
        "c180",
        "valve:\n  dead_time: = 21 ms\n",
        3,
        "= 21 ms (0.021 s) is outside the range 0.0005 .. 0.02",
    ),
    ("c180", "valve:\n  hysteresis: = -1 V\n", 3, "= -1 V is outside the range 0 .. 5 V"),
    ("c180", "valve:\n  spool_slew_limit: = 0 V/s\n", 3, "= 0 V/s is outside the range 1 .. 1"),
    (
        "c180",
        "boom:\n  chambers: null\n",
        3,
        "boom.chambers is null, but boom.holding_1 holds the oil in them; allowed: both, or neither",
    ),
    (
        "c180",
        "boom:\n  holding_1:\n    hysteresis: = 22 MPa\n    setting: = 21 MPa\n",
        4,
        "= 22 MPa (2.2e+07 Pa) is outside the range 0 .. 2e+07 Pa",
    ),
    (
        "c180",
        "stick:\n  holding_2:\n    setting: = 0.5 MPa\n",
        4,
        "stick.holding_2.hysteresis (1e+06 Pa) must be smaller than setting (500000 Pa)",
    ),
    (
        "c180",
        "boom:\n  holding_1:\n    kind: spring\n",
        4,
        "boom.holding_1.kind = 'spring' is unknown; allowed: counterbalance, pilot_check, rupture",
    ),
    (
        "c180",
        "boom:\n  holding_1:\n    kind: rupture\n    closing_flow: = 2 L/min\n",
        3,
        "missing key boom.holding_1.minimum_resistance",
    ),
    (
        "c180",
        "boom:\n  holding_1:\n    pilot_ratio: = 0 1\n",
        4,
        "boom.holding_1.pilot_ratio = 0 is outside the range 0.5 .. 20",
    ),
    (
        "forwarder",
        "valve:\n  compensator:\n    setting: = 2 MPa\n",
        4,
        "valve.compensator.setting (2e+06 Pa): the compensator uses 2.6e+06 Pa of pump.margin (2.4e+06 Pa)",
    ),
    (
        "forwarder",
        COMPENSATOR.format(kind="before_spool", setting=0.3),
        6,
        "valve.compensator.control_range (400000 Pa) must be smaller than setting (300000 Pa)",
    ),
    (
        "forwarder",
        "valve:\n  deadband_voltage: = -0.5 V\n  leakage_edge_ratio: null\n",
        3,
        "valve.deadband_voltage (-0.5 V): a valve with a compensator must not be underlapped; allowed",
    ),
    (
        "c180_hoses",
        COMPENSATOR.format(kind="after_spool", setting=0.5),
        4,
        "valve.compensator.kind = after_spool shares what a load-sensing pump leaves over the greatest load",
    ),
    (
        "forwarder",
        "valve:\n  compensator:\n    response_time: = 1 ms\n",
        4,
        "= 1 ms (0.001 s) is outside the range 0.002 .. 1 s",
    ),
    (
        "forwarder",
        "valve:\n  compensator:\n    kind: ludv\n",
        4,
        "valve.compensator.kind = 'ludv' is unknown; allowed: before_spool, after_spool",
    ),
    ("c180", "oil: null\n", 2, "oil is null, but the swing has chambers: how their oil yields needs"),
    (
        "c180",
        "boom:\n  chambers:\n    area: = 1 m2\n",
        4,
        "unknown key boom.chambers.area; allowed: head",
    ),
    (
        "c180_hoses",
        "boom:\n  chambers:\n    head_dead_volume: = 1 L\n",
        3,
        "missing key boom.chambers.rod_dead_volume",
    ),
    (
        "c180_hoses",
        "swing:\n  friction:\n    coulomb_torque: = 800 N*m\n",
        3,
        "missing key swing.friction.breakaway_torque",
    ),
    (
        "c180",
        "swing:\n  backlash:\n    motor_inertia: = 0 kg*m2\n",
        4,
        "swing.backlash.motor_inertia = 0 kg*m2 is outside the range 1e-06 .. 10 kg*m2",
    ),
    (
        "c180_hoses",
        "boom:\n  elasticity:\n    stiffness: = -1e7 N*m/rad\n" + ROOT,
        4,
        "boom.elasticity.stiffness = -1e+07 N*m/rad is outside the range 10000 .. 1e+12 N*m/rad",
    ),
    (
        "c180_hoses",
        "stick:\n  elasticity:\n    stiffness: = 0 N*m/rad\n" + ROOT,
        4,
        "stick.elasticity.stiffness = 0 N*m/rad is outside the range",
    ),
    (
        "c180_hoses",
        "stick:\n  elasticity:\n    stiffness: = 2e5 N*m/rad\n" + ROOT,
        4,
        "the level stick's weight (3.858e+04 N*m) would deflect it by 0.193 rad; allowed: at most 0.1 rad",
    ),
    (
        "c180_hoses",
        "swing:\n  elasticity:\n    stiffness: = 1e5 N*m/rad\n" + ROOT,
        4,
        "swing.elasticity.stiffness (100000 N*m/rad): the motor at pump.supply_pressure",
    ),
    (
        "c180_hoses",
        "boom:\n  elasticity:\n    stiffness: = 1e7 N*m/rad\n",
        3,
        "missing key boom.elasticity.damping",
    ),
    (
        "c180",
        "boom:\n  chambers:\n    head_dead_volume: = 0 L\n",
        4,
        "= 0 L (0 m3) is outside the range 1e-06",
    ),
]


@pytest.mark.parametrize(
    ("base", "text", "line", "told"),
    [*((base, f"manipulator:\n  {text}\n", 3, told) for base, text, told in BODIES), *OTHERS],
)
def test_a_contradiction_is_refused_with_line_key_and_what_is_allowed(tmp_path, base, text, line, told):
    path = tmp_path / "mine.yaml"
    path.write_text(f"based_on: {base}\n{written(text)}", "utf-8")
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert told in str(caught.value)


def test_the_reach_that_a_complaint_names_is_enough(tmp_path):
    file = tmp_path / "chart.yaml"
    text = "based_on: c180_hoses\nmanipulator:\n  boom_length: = 4.1188 m\n"  # 8.5703 m in all
    file.write_text(written(text + CAPACITY.format(reach="4, 8.5", load="900, 500")))
    with pytest.raises(MachineError, match=r"allowed: at least 8\.570 m"):
        load_machine(str(file))
    file.write_text(written(text + CAPACITY.format(reach="4, 8.570", load="900, 500")))
    assert load_machine(str(file)).capacity.reach[-1] == 8.57


def test_an_inertia_that_is_not_told_stays_allowed_as_in_the_thesis(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(written("based_on: c180_thesis\nmanipulator:\n  head_mass: = 500 kg\n"), "utf-8")
    m = load_machine(path).manipulator
    assert (m.boom_xx, m.stick_xx, THESIS.manipulator.boom_xx) == (0.0, 0.0, 0.0)


def test_a_plane_body_is_a_body_however_its_numbers_are_rounded():
    m = C180.manipulator
    assert m.boom_xx + m.boom_yy == pytest.approx(m.boom_zz, rel=1e-12)
    dataclasses.replace(m, boom_xx=m.boom_xx * (1.0 - 5e-7))
    with pytest.raises(MachineError, match="no rigid body"):
        dataclasses.replace(m, boom_xx=m.boom_xx * 0.999)


def test_what_points_make_is_always_a_body_and_a_little_beyond_never():
    """Principal moments of a symmetric pair of points above and below the plane, at random."""
    rng = np.random.default_rng(4)
    for _ in range(200):
        count = int(rng.integers(2, 6))
        masses = rng.uniform(0.1, 5.0, count)
        x, y, z = rng.normal(0.0, 1.0, (3, count)) * rng.uniform(0.1, 2.0, (3, 1))
        x, y = x - masses @ x / masses.sum(), y - masses @ y / masses.sum()
        s_xx, s_yy, s_zz, s_xy = (masses @ a for a in (x * x, y * y, z * z, x * y))
        moments = (s_yy + s_zz, s_xx + s_zz, s_xx + s_yy)
        require_rigid("boom", masses.sum(), moments, s_xy)
        beyond = (s_yy + s_zz, s_xx + s_zz, s_xx + s_yy + 2.01 * s_zz + 1e-3)
        with pytest.raises(MachineError, match=r"boom_zz .* no rigid body"):
            require_rigid("boom", masses.sum(), beyond, s_xy)
        room = 1.01 * float(np.sqrt(s_xx * s_yy)) + 1e-3
        for product in (room, -room):
            with pytest.raises(MachineError, match=r"boom_xy"):
                require_rigid("boom", masses.sum(), moments, product)


def test_a_friction_without_peak_may_be_as_smooth_as_it_likes():
    assert Friction(500.0, 500.0, 1e-3, 5e-3).smoothing_speed == 5e-3


def test_what_is_allowed_of_a_pump_is_allowed_indeed():
    pump = C180.pump
    lowest = pump.supply_pressure / pump.flow_limit
    with pytest.raises(MachineError, match=r"allowed: above 5\.51576e\+09 Pa"):
        dataclasses.replace(pump, leakage_resistance=0.999 * lowest)
    needed = pump.supply_pressure**2 / pump.leakage_resistance / pump.mechanical_efficiency
    with pytest.raises(MachineError, match=r"allowed: above 2875\.22 W"):
        dataclasses.replace(pump, engine_power=0.999 * needed)
    dataclasses.replace(pump, engine_power=1.001 * needed)
    dataclasses.replace(pump, leakage_resistance=1.001 * lowest, engine_power=1e6)
