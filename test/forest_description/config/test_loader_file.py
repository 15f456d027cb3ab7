"""Another crane is another YAML: what a slip in its file is answered with, one slip at a time."""

from importlib import resources

import pytest

from forest_description.config.parameter import MachineError
from forest_description.config.source_tree import Branch, read
from forest_description.machine import load_machine

LINES = (resources.files("forest_description") / "machines" / "loader.yaml").read_text("utf-8").splitlines()
TREE = read("loader")
DROPPED = None


def line_of(key):
    """Return the number of the line on which the shipped file says a key; "": where its keys begin."""
    item = TREE
    for part in key.split(".") if key else ():
        item = item.children[part]
    assert isinstance(item, Branch) or key
    return int(item.place.rpartition(":")[2])


def indent(line):
    return len(line) - len(line.lstrip())


def mutated(key, text):
    """Return the file with the line of a key said otherwise, or with all that it says dropped."""
    first = line_of(key) - 1
    if text is not DROPPED:
        return [*LINES[:first], " " * indent(LINES[first]) + text, *LINES[first + 1 :]]
    last = first + 1
    while last < len(LINES) and indent(LINES[last]) > indent(LINES[first]):
        last += 1
    return LINES[:first] + LINES[last:]


def number(value, unit):
    return f"{{value: {value}, unit: {unit}, source: x}}"


def row(values, unit):
    return f"{{values: [{values}], unit: {unit}, source: x}}"


PUMPS = "ideal, pressure_compensated, constant_flow, load_sensing"
TABLE = "stick.valve.curve"
# Changed key; what stands there instead; what the complaint says; the key on whose line; what is allowed.
MISSING = [
    ("pump.kind", "pump.kind", "pump", PUMPS),
    ("pump.margin", "pump.margin", "pump", "a number in 10000 .. 2e+07 Pa"),
    ("valve.curve", "valve.curve", "valve", "a section or null"),
    ("valve.backward.minimum_resistance", "valve.backward.minimum_resistance", "valve.backward", "1e+18"),
    ("hose.kind", "hose.kind", "hose", "measured, geometric"),
    ("swing.upper_limit", "swing.upper_limit", "swing", "-20 .. 20 rad"),
    ("boom.friction", "boom.friction", "boom", "a section or null"),
    ("boom.cushion.length", "boom.cushion.length", "boom.cushion", "0.001 .. 1 m"),
    (f"{TABLE}.voltages", f"{TABLE}.voltages", TABLE, "numbers in 0 .. 50 V"),
    ("manipulator.pendulum.damping", "manipulator.pendulum.damping", "manipulator.pendulum", "0 .. 1e+06"),
    ("port_valves", "port_valves", "", "a section or null"),
    ("command_timeout", "command_timeout", "", "0.005 .. 10 s"),
]
RENAMED = [
    ("boom.stroke", f"strok: {number(480, 'mm')}", "boom.strok", "retracted_length, stroke, pivot_to_base"),
    ("pump.margin", f"margn: {number(22, 'bar')}", "pump.margn", "engine, margin, response_time"),
    ("end_stops.swing_damping", f"swing_dampin: {number(1, 'N')}", "end_stops.swing_dampin", "swing_damping"),
    ("stick.flow_regime", "flow: turbulent", "stick.flow", "flow_regime, valve"),
    ("port_valves", "port_valve:", "port_valve", "port_valves, end_stops"),
    (
        "pump.displacement",
        "displacement: {size: 3, unit: m3/rad, source: x}",
        "displacement.size",
        "value, unit",
    ),
]
WRONG_UNIT = [
    ("boom.stroke", f"stroke: {number(480, 'kg')}", "boom.stroke", "m, mm, in"),
    ("pump.shaft_speed", f"shaft_speed: {number(24, 'Hz')}", "pump.shaft_speed", "rad/s, rpm"),
    ("valve.rated_voltage", f"rated_voltage: {number(8000, 'mV')}", "valve.rated_voltage", "allowed: V"),
    ("swing.damping", f"damping: {number(9, 'N*s/m')}", "swing.damping", "N*m*s/rad"),
    (f"{TABLE}.resistances", f"resistances: {row('2, 1', 'Pa')}", f"{TABLE}.resistances", "Pa*s2/m6"),
]
OUT_OF_RANGE = [
    ("hose.bore", f"bore: {number(12.7, 'm')}", "hose.bore = 12.7 m", "0.001 .. 0.5 m"),
    ("valve.port_2_area", f"port_2_area: {number(50, '1')}", "valve.port_2_area = 50 is", "0.05 .. 20"),
    (
        "pump.mechanical_efficiency",
        f"mechanical_efficiency: {number(91, '1')}",
        "efficiency = 91",
        "0.1 .. 1",
    ),
    ("boom.stroke", f"stroke: {number(480, 'm')}", "boom.stroke = 480 m", "0.01 .. 10 m"),
    ("manipulator.pendulum.length", f"length: {number(-0.4, 'm')}", "pendulum.length", "0.01 .. 20 m"),
    (
        "valve.spool_bandwidth",
        f"spool_bandwidth: {number(0, 'Hz')}",
        "valve.spool_bandwidth",
        "0.1 .. 500 Hz",
    ),
    (f"{TABLE}.voltages", f"voltages: {row('2, 80', 'V')}", f"{TABLE}.voltages = 80 V", "0 .. 50 V"),
    (
        "swing.lower_limit",
        f"lower_limit: {number(-2100, 'deg')}",
        "-2100 deg (-36.6519 rad)",
        "-20 .. 20 rad",
    ),
]
NOT_A_NUMBER = [
    ("boom.head_area", f"head_area: {number('eighty', 'cm2')}", "boom.head_area: 'eighty'", "1e-05 .. 1 m2"),
    (
        "manipulator.head_mass",
        "head_mass: heavy",
        "manipulator.head_mass = heavy",
        "{value: a number in 0 .. 1e+06",
    ),
    ("pump.count", "count: 1", "pump.count = 1", "{value: a number in 1 .. 20, unit: 1, source"),
    (f"{TABLE}.voltages", f"voltages: {row('2, lots', 'V')}", f"{TABLE}.voltages: 'lots'", "0 .. 50 V"),
    (f"{TABLE}.voltages", f"voltages: {number(3, 'V')}", f"{TABLE}.voltages.value", "values, unit, source"),
    ("manipulator.gravity", f"gravity: {number('.nan', 'm/s2')}", "manipulator.gravity", "0 .. 30 m/s2"),
    ("boom.stroke", "stroke: {value: 480, unit: mm}", "boom.stroke.source", "source: where it comes from"),
    ("manipulator.log", "log: 3", "manipulator.log", "mass, x, y, length or null"),
]
WORDS = [
    ("boom.flow_regime", "flow_regime: wild", "boom.flow_regime = 'wild'", "laminar, turbulent"),
    ("pump.kind", "kind: variable", "pump.kind = 'variable'", PUMPS),
    (f"{TABLE}.kind", "kind: spline", f"{TABLE}.kind = 'spline'", "polynomial, table, flow"),
    ("manipulator.head_folding", "head_folding: some", "manipulator.head_folding", "thesis, full"),
    (
        "valve.curve",
        "curve: straight",
        "valve.curve",
        "kind (polynomial, table, flow) and the kind's own or null",
    ),
]
# These values are each possible, but not together: the key named first is the one whose line is told.
CONTRADICTIONS = [
    ("boom.stroke", f"stroke: {number(600, 'mm')}", "boom.retracted_length", "only between 0.57 and 1.29 m"),
    (
        "boom.retracted_length",
        f"retracted_length: {number(0.5, 'm')}",
        "boom.retracted_length",
        "0.57 and 1.29",
    ),
    ("stick.pivot_to_rod", f"pivot_to_rod: {number(1.8, 'm')}", "stick.retracted_length", "0.83 and 2.77 m"),
    (
        "stick.rod_area",
        f"rod_area: {number(40, 'cm2')}",
        "stick.rod_area",
        "smaller than head_area (0.0038485 m2)",
    ),
    (
        "swing.upper_limit",
        f"upper_limit: {number(-220, 'deg')}",
        "swing.lower_limit",
        "smaller than upper_limit",
    ),
    (
        f"{TABLE}.voltages",
        f"voltages: {row('1, 2, 3, 4, 5, 7.5', 'V')}",
        f"{TABLE}.voltages",
        "to rated_voltage (8 V)",
    ),
    (
        f"{TABLE}.voltages",
        f"voltages: {row('2, 3, 5, 6, 8', 'V')}",
        f"{TABLE}.voltages",
        "must be equally many",
    ),
    (
        f"{TABLE}.resistances",
        f"resistances: {row('1e13, 1e12, 1e11, 1e10, 1e9, 1e10', 'Pa*s2/m6')}",
        f"{TABLE}.resistances",
        "fall with the voltage",
    ),
    (
        "pump.relief_pressure",
        f"relief_pressure: {number(150, 'bar')}",
        "pump.relief_pressure",
        "not be below supply_pressure (1.8e+07",
    ),
    (
        "pump.margin",
        f"margin: {number(190, 'bar')}",
        "pump.margin",
        "smaller than supply_pressure (1.8e+07 Pa)",
    ),
    (
        "boom.friction.breakaway_force",
        f"breakaway_force: {number(0.5, 'kN')}",
        "boom.friction.breakaway_force",
        "not be below coulomb_force (700 N)",
    ),
    (
        "boom.cushion.length",
        f"length: {number(300, 'mm')}",
        "boom.cushion.length",
        "at most half the stroke (0.24 m)",
    ),
    ("manipulator.head_mass", f"head_mass: {number(0, 'kg')}", "manipulator.head_mass", "above 0 kg"),
    (
        "boom.length_exponent",
        f"length_exponent: {number(2, '1')}",
        "boom.length_exponent",
        "must be 1 with a geometric",
    ),
]

# The stick's own valve inherits its overlap; the slip is in what it says itself.
INHERITED = [
    (
        "stick.valve.minimum_resistance",
        f"rated_voltage: {number(1, 'V')}",
        "stick.valve.deadband_voltage (1.4 V)",
        "smaller than rated_voltage (1 V)",
    ),
]
CASES = [
    *((key, DROPPED, said, at, allowed) for key, said, at, allowed in MISSING),
    *(
        (key, text, said, key, allowed)
        for key, text, said, allowed in RENAMED + WRONG_UNIT + OUT_OF_RANGE + NOT_A_NUMBER + WORDS + INHERITED
    ),
    *((key, text, said, said, allowed) for key, text, said, allowed in CONTRADICTIONS),
]


@pytest.mark.parametrize(
    ("key", "text", "said", "at", "allowed"), CASES, ids=[f"{case[0]}: {case[2]}" for case in CASES]
)
def test_a_slip_is_answered_with_file_line_key_and_what_is_allowed(tmp_path, key, text, said, at, allowed):
    path = tmp_path / "mine.yaml"
    path.write_text("\n".join(mutated(key, text)) + "\n", "utf-8")
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line_of(at)}: ")
    assert said in message
    assert allowed in message


def test_the_file_that_is_not_touched_loads(tmp_path):
    path = tmp_path / "loader.yaml"
    path.write_text("\n".join(LINES), "utf-8")
    assert load_machine(path) == load_machine("loader")
