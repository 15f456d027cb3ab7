"""Claims about machine files with sorts of components, rows, choices, and about an axis' own valve."""

import dataclasses
import re

import pytest

from forest_description.config.parameter import MachineError
from forest_description.config.schema import parameters
from forest_description.hydraulics.pump import (
    ConstantFlowPump,
    IdealPump,
    LoadSensingPump,
    PressureCompensatedPump,
)
from forest_description.hydraulics.valve_parameters import BackwardValve, PolynomialCurve, TableCurve
from forest_description.machine import Machine, load_machine, sources
from forest_description.mechanics.drives import Cushion, Friction

C180 = load_machine("c180_hoses")
IDEAL = "pump:\n  kind: ideal\n  supply_pressure: {value: 18, unit: MPa, source: x}\n"
SENSING = """pump:
  kind: load_sensing
  supply_pressure: {value: 3000, unit: psi, source: x}
  count: {value: 1, unit: "1", source: x}
  displacement: {value: 100, unit: cm3/rev, source: x}
  shaft_speed: {value: 2000, unit: rpm, source: x}
  engine_power: {value: 100, unit: kW, source: x}
  mechanical_efficiency: {value: 0.9, unit: "1", source: x}
  leakage_resistance: {value: 1e12, unit: Pa*s/m3, source: x}
  manifold_capacitance: {value: 1e-12, unit: m3/Pa, source: x}
  relief_pressure: {value: 250, unit: bar, source: x}
  relief_conductance: {value: 1e-8, unit: m3/(s*Pa), source: x}
  compensator_band: {value: 5, unit: bar, source: x}
  margin: {value: 20, unit: bar, source: x}
  response_time: {value: 0.05, unit: s, source: x}
"""
TABLE = """    kind: table
    voltages: {values: [2, 5, 10], unit: V, source: measured}
    resistances: {values: [9e13, 8.0e12, 1000000000000], unit: Pa*s2/m6, source: measured}
"""
POLYNOMIAL = "    kind: polynomial\n    coefficients: {values: [121, -22, 1], unit: '1', source: fit}\n"


@pytest.fixture
def write(tmp_path):
    """Write a machine file based on another and return its path."""

    def write_text(text, base="c180_hoses", name="mine.yaml"):
        path = tmp_path / name
        path.write_text(f"based_on: {base}\n{text}", "utf-8")
        return path

    return write_text


def complaint(path):
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    return str(caught.value)


def test_another_sort_replaces_the_whole_section(write):
    assert load_machine(write(IDEAL)).pump == IdealPump(18e6)
    pump = load_machine(write(SENSING, "c180_thesis")).pump
    assert isinstance(pump, LoadSensingPump)
    assert pump.flow_limit == pytest.approx(0.2 / 60.0)
    assert (pump.margin, pump.engine_power, pump.relief_pressure) == pytest.approx((2e6, 1e5, 2.5e7))


def test_the_same_sort_with_or_without_its_name_gives_only_what_differs(write):
    for kind in ("", "  kind: pressure_compensated\n"):
        text = f"pump:\n{kind}  engine_power: {{value: 50, unit: kW, source: x}}\n"
        assert load_machine(write(text)).pump == dataclasses.replace(C180.pump, engine_power=5e4)


def test_a_sort_that_lacks_a_number_of_its_own_is_asked_for_it(write):
    path = write("pump:\n  kind: load_sensing\n")
    assert complaint(path) == f"{path}:2: missing key pump.supply_pressure: a number in 100000 .. 5e+07 Pa"
    path = write(SENSING.replace("  margin: {value: 20, unit: bar, source: x}\n", ""))
    assert complaint(path) == f"{path}:2: missing key pump.margin: a number in 10000 .. 2e+07 Pa"


@pytest.mark.parametrize(
    ("text", "line", "parts"),
    [
        ("pump:\n  kind: magic\n", 3, ["pump.kind = 'magic' is unknown", "ideal, pressure_compensated"]),
        ("pump:\n  kind: null\n", 3, ["pump.kind", "allowed: ideal, pressure_compensated, constant_flow"]),
        ("pump:\n  kind: [ideal]\n", 3, ["pump.kind", "allowed: ideal"]),
        (
            "valve:\n  curve:\n    voltages: {values: [1], unit: V, source: x}\n",
            3,
            ["missing key valve.curve.kind"],
        ),
        ("boom:\n  kind: cylinder\n", 3, ["boom.kind", "has only one"]),
        ("kind: crane\n", 2, ["unknown key kind"]),
        (
            f"{IDEAL}  count: {{value: 1, unit: '1', source: x}}\n",
            5,
            ["unknown key pump.count", "supply_pressure, kind"],
        ),
        ("boom:\n  flow_regime: wild\n", 3, ["boom.flow_regime = 'wild' is unknown", "laminar, turbulent"]),
        ("boom:\n  flow_regime: null\n", 3, ["boom.flow_regime must be a text"]),
        ("boom:\n  flow_regime: [laminar]\n", 3, ["boom.flow_regime must be a text"]),
        ("boom:\n  friction: 3\n", 3, ["boom.friction must be a section with keys, not '3'"]),
        ("boom:\n  friction: [3, 4]\n", 3, ["boom.friction must be a section with keys, not ['3', '4']"]),
        ("boom:\n  friction: {}\n", 3, ["missing key boom.friction.coulomb_force: a number in 0 .. 1e+07 N"]),
        (
            "boom:\n  stroke: {values: [1, 2], unit: m, source: x}\n",
            3,
            ["unknown key boom.stroke.values", "value"],
        ),
        ("boom:\n  stroke: {value: [1, 2], unit: m, source: x}\n", 3, ["missing boom.stroke.value"]),
    ],
)
def test_error_names_file_line_key_and_what_is_allowed(write, text, line, parts):
    path = write(text)
    message = complaint(path)
    assert message.startswith(f"{path}:{line}: ")
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("row", "parts"),
    [
        ("{values: [2, 5], unit: V, source: x}", ["valve.curve.voltages (2) and curve.resistances (3)"]),
        (
            "{values: [2, 5, 70], unit: V, source: x}",
            ["valve.curve.voltages = 70 V is outside the range 0 .. 50 V"],
        ),
        ("{values: [2, 5, ten], unit: V, source: x}", ["valve.curve.voltages: 'ten' is not a number"]),
        ("{values: [2, 5, .nan], unit: V, source: x}", ["is not a number", "0 .. 50 V"]),
        ("{values: [2, 5, 10], unit: Pa, source: x}", ["unit 'Pa' does not fit", "V"]),
        ("{values: [2, 5, 10], unit: V}", ["missing valve.curve.voltages.source", "[numbers in 0 .. 50 V]"]),
        ("{values: [], unit: V, source: x}", ["missing valve.curve.voltages.values"]),
        ("{values: 7, unit: V, source: x}", ["missing valve.curve.voltages.values"]),
        (
            "{value: 7, unit: V, source: x}",
            ["unknown key valve.curve.voltages.value", "values, unit, source"],
        ),
        ("[2, 5, 10]", ["valve.curve.voltages = 2, 5, 10: a number must be written {values: "]),
        ("[[2], 5]", ["valve.curve.voltages must be a list of numbers"]),
    ],
)
def test_a_row_of_numbers_is_checked_as_numbers_are(write, row, parts):
    path = write("valve:\n  curve:\n" + TABLE.replace("{values: [2, 5, 10], unit: V, source: measured}", row))
    message = complaint(path)
    assert re.match(rf"{re.escape(str(path))}:[2-6]: ", message)
    for part in parts:
        assert part in message


def test_rows_arrive_as_they_stand_and_in_si(write):
    path = write("valve:\n  curve:\n" + TABLE)
    curve = load_machine(path).valve.curve
    assert curve == TableCurve((2.0, 5.0, 10.0), (9e13, 8e12, 1e12))
    rows = {row.key: row for row in sources(path)}
    assert rows["valve.curve.voltages"][1:] == ((2.0, 5.0, 10.0), "V", "measured", None)


def test_a_curve_is_replaced_by_one_of_another_sort_and_taken_away_by_null(write):
    write("valve:\n  curve:\n" + TABLE, name="table.yaml")
    fitted = load_machine(write("valve:\n  curve:\n" + POLYNOMIAL, "table.yaml"))
    assert fitted.valve.curve == PolynomialCurve((121.0, -22.0, 1.0))
    assert load_machine(write("valve:\n  curve: null\n", "table.yaml")).valve.curve is None


def test_an_axis_own_valve_gives_what_differs_from_the_shared_one(write):
    own = "boom:\n  valve:\n    deadband_voltage: {value: 1.4, unit: V, source: measured}\n"
    machine = load_machine(write(own))
    assert machine.boom.valve == dataclasses.replace(C180.valve, deadband_voltage=1.4)
    assert machine.valve_of(1) == machine.boom.valve
    assert machine.valve_of(0) == machine.valve_of(2) == machine.valve == C180.valve
    keys = [row.key for row in sources(write(own))]
    assert "boom.valve.deadband_voltage" in keys
    assert "stick.valve.deadband_voltage" not in keys


def test_an_axis_own_valve_may_lack_what_the_shared_one_has_and_have_what_it_lacks(write):
    edge, c_r = "{value: 2, unit: V, source: x}", "{value: 2e12, unit: Pa*s2/m6, source: x}"
    back = f"{{deadband_voltage: {edge}, minimum_resistance: {c_r}}}"
    text = f"valve:\n  backward: {back}\nboom:\n  valve:\n    backward: null\nstick:\n  valve:\n    curve:\n"
    machine = load_machine(write(text + TABLE.replace("    ", "      ")))
    assert machine.valve.backward == BackwardValve(2.0, 2e12)
    assert machine.boom.valve.backward is None
    assert machine.stick.valve.backward == machine.valve.backward
    assert (machine.stick.valve.curve.kind, machine.valve.curve) == ("table", None)


def test_an_error_in_an_axis_own_valve_names_its_line_and_key(write):
    path = write("boom:\n  valve:\n    rated_voltage: {value: 1, unit: V, source: x}\n")
    assert complaint(path).startswith(f"{path}:4: boom.valve.deadband_voltage (1 V) must be smaller")
    path = write("stick:\n  valve:\n    lap: 3\n")
    assert complaint(path).startswith(f"{path}:4: unknown key stick.valve.lap; allowed: deadband_voltage")


def test_friction_cushion_and_flow_regime_are_chosen_per_axis(write):
    text = """boom:
  flow_regime: laminar
  friction:
    coulomb_force: {value: 4, unit: kN, source: x}
    breakaway_force: {value: 7, unit: kN, source: x}
    stribeck_speed: {value: 0.02, unit: m/s, source: x}
    smoothing_speed: {value: 1e-3, unit: m/s, source: x}
  cushion:
    length: {value: 80, unit: mm, source: x}
    resistance: {value: 3e7, unit: N*s2/m2, source: x}
"""
    machine = load_machine(write(text))
    assert machine.boom.friction == Friction(4e3, 7e3, 0.02, 1e-3)
    assert machine.boom.cushion == Cushion(0.08, 3e7)
    assert (machine.stick.friction, machine.stick.cushion) == (None, None)
    assert machine.line(1, 1).resistance == pytest.approx(C180.hose.laminar_resistance * 1.6 / 4.0)
    assert machine.line(2, 1) == C180.line(2, 1)


def test_every_sort_of_every_component_declares_its_parameters():
    declared = parameters(Machine)
    for sort in (IdealPump, PressureCompensatedPump, ConstantFlowPump, LoadSensingPump):
        assert {f"pump.{field.name}" for field in dataclasses.fields(sort)} <= {*declared, "pump.engine"}
    for key in (
        "pump.engine.droop",
        "valve.curve.coefficients",
        "valve.curve.voltages",
        "stick.valve.backward.deadband_voltage",
    ):
        assert key in declared


@pytest.mark.parametrize(
    ("part", "change"),
    [(C180.boom, {"flow_regime": "wild"}), (C180.swing, {"flow_regime": None})],
    ids=["unknown", "none"],
)
def test_a_variant_with_an_unknown_word_is_refused(part, change):
    with pytest.raises(MachineError, match=r"\.flow_regime: .* is none of laminar, turbulent"):
        dataclasses.replace(part, **change)
