"""Claims about the shipped machines, and their ranges."""

import dataclasses
import math

import pytest

from forest_description.config.parameter import MachineError
from forest_description.config.schema import parameters
from forest_description.config.source_tree import shipped_machines
from forest_description.config.units import UNITS
from forest_description.export.machine_numbers import declared
from forest_description.hydraulics.pump import IdealPump, PressureCompensatedPump
from forest_description.hydraulics.valve_characteristic import symmetric_valve
from forest_description.hydraulics.valve_parameters import PortValves
from forest_description.machine import Machine, load_machine, sources
from forest_description.mechanics.end_stops import EndStops
from forest_description.sensors.sensor_kinds import (
    CaseDrain,
    FlowMeter,
    Inclinometer,
    LinearTransducer,
    PressureTransducer,
    Resolver,
    Sensors,
    SpoolSensor,
    Tachometer,
    Thermocouple,
)

GALLON_PER_MINUTE, RPM = UNITS["gal/min"].factor, UNITS["rpm"].factor
MACHINE, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")


def test_five_machines_are_shipped_and_c180_is_the_default():
    assert shipped_machines() == ["c180", "c180_hoses", "c180_thesis", "forwarder", "loader"]
    assert load_machine() == load_machine("c180")
    assert (MACHINE.name, THESIS.name) == ("c180_hoses", "c180_thesis")


def test_c180_hoses_adds_to_the_thesis_machine_only_what_its_file_says():
    changed = dataclasses.replace(
        THESIS,
        name=MACHINE.name,
        description=MACHINE.description,
        stick=dataclasses.replace(THESIS.stick, length_exponent=1.0),
        manipulator=dataclasses.replace(
            THESIS.manipulator, boom_xx=77.6049, stick_xx=331.97606, head_folding="full"
        ),
        sensors=dataclasses.replace(
            THESIS.sensors,
            resolver=dataclasses.replace(THESIS.sensors.resolver, noise=2e-4),
            linear_transducer=dataclasses.replace(THESIS.sensors.linear_transducer, noise=0.18 * 1e-3),
            pressure=dataclasses.replace(THESIS.sensors.pressure, noise=0.5 * 6894.7),
            flow_meter=dataclasses.replace(THESIS.sensors.flow_meter, noise=0.025 * GALLON_PER_MINUTE),
            thermocouple=dataclasses.replace(THESIS.sensors.thermocouple, noise=0.05),
            tachometer=Tachometer(2.5 * RPM, 1.0 * RPM),
            spool_sensor=SpoolSensor(0.05, 0.005),
            inclinometer=Inclinometer(0.1 * math.pi / 180.0, 0.02 * math.pi / 180.0),
            case_drain=CaseDrain(0.01, 0.01 * UNITS["L/min"].factor),
        ),
        port_valves=PortValves(24.1e6, 1e-8, 0.0, 1e-7),
        end_stops=EndStops(3e8, 2e6, 5e7, 1e6),
        valve=dataclasses.replace(THESIS.valve, spool_bandwidth=12.0),
        pump=MACHINE.pump,
        oil=MACHINE.oil,
    )
    assert changed == MACHINE
    two_pumps = PressureCompensatedPump(
        supply_pressure=THESIS.pump.supply_pressure,
        count=2.0,
        displacement=45e-6 / (2.0 * math.pi),
        shaft_speed=2500.0 * 2.0 * math.pi / 60.0,
        engine_power=152.0 * 745.7,
        mechanical_efficiency=0.93,
        leakage_resistance=1.6e11,
        manifold_capacitance=5e-12,
        relief_pressure=3300 * 6894.7,
        relief_conductance=1e-8,
        compensator_band=5e5,
    )
    for field in dataclasses.fields(two_pumps):
        expected = getattr(two_pumps, field.name)
        if expected is not None:
            expected = pytest.approx(expected, rel=1e-15, abs=0.0)
        assert getattr(MACHINE.pump, field.name) == expected


def test_thesis_machine_has_none_of_the_components_that_the_thesis_lacks():
    assert (THESIS.port_valves, THESIS.end_stops, THESIS.oil) == (None, None, None)
    assert isinstance(THESIS.pump, IdealPump)
    valve = THESIS.valve
    assert (valve.spool_bandwidth, valve.spool_damping, valve.backward, valve.curve) == (None,) * 4
    assert valve.law == symmetric_valve(1.0, 10.0, 1.04e12)
    for drive in (THESIS.swing, THESIS.boom, THESIS.stick):
        assert drive.valve is None
        assert drive.flow_regime == ("laminar" if drive is THESIS.swing else "turbulent")
    assert {THESIS.boom.friction, THESIS.stick.friction, THESIS.boom.cushion, THESIS.stick.cushion} == {None}


def test_thesis_machine_has_the_sensors_of_table_4_2_and_section_4_2_2_as_printed():
    assert THESIS.sensors == Sensors(
        resolver=Resolver(2.0 * math.pi, 7 / 60 * UNITS["deg"].factor, None),
        linear_transducer=LinearTransducer(36.5 * 0.0254, 0.0004, None),
        pressure=PressureTransducer(5000 * 6894.7, 0.0001, None),
        flow_meter=FlowMeter(0.85 * GALLON_PER_MINUTE, 50 * GALLON_PER_MINUTE, 0.0005, 0.01, None),
        thermocouple=Thermocouple(3.15, 1633.15, 0.2, None),
        tachometer=Tachometer(None, None),
        spool_sensor=SpoolSensor(None, None),
        inclinometer=Inclinometer(None, None),
        case_drain=None,
        calibration=None,
        sample_rate=200.0,
    )


def test_numbers_in_conventional_units_arrive_in_si():
    assert THESIS.pump.supply_pressure == 3000 * 6894.7
    assert THESIS.swing.motor_displacement == pytest.approx(4.5064e-5 / (2.0 * math.pi), rel=1e-15)
    assert THESIS.swing.gear_ratio == pytest.approx(35.16 * 82 / 13, rel=1e-15)
    assert THESIS.hose.turbulent_resistance == 4.987e5**2
    assert THESIS.boom.angle_offset == pytest.approx((61.7 + 0.31) * math.pi / 180.0, rel=1e-15)
    assert THESIS.stick.angle_offset == pytest.approx(math.pi + 2.5 * math.pi / 180.0, rel=1e-15)
    assert THESIS.boom.stroke == pytest.approx(0.9144, rel=1e-15)


@pytest.mark.parametrize(
    ("axis", "port", "ratio"),
    [(0, 1, 1 / 4), (0, 2, 1 / 4), (1, 1, 1.6 / 4), (1, 2, 2.2 / 4), (2, 1, 3.8 / 4), (2, 2, 4.9 / 4)],
)
def test_lines_are_the_printed_pieces_of_the_measured_hose(axis, port, ratio):
    resistance = (3.0329e8 if axis == 0 else 4.987e5**2) * ratio
    assert MACHINE.line(axis, port) == pytest.approx(
        (resistance, 3.062e7 * ratio, 1.585e-12 * ratio), rel=1e-14, abs=0.0
    )
    power = ratio**2 if axis == 2 else ratio
    assert THESIS.line(axis, port) == pytest.approx(
        (resistance, 3.062e7 * power, 1.585e-12 * power), rel=1e-14, abs=0.0
    )


@pytest.mark.parametrize(("axis", "port"), [(3, 1), (-1, 1), (0, 0), (0, 3)])
def test_a_line_that_is_not_there_is_refused(axis, port):
    with pytest.raises(ValueError, match="axes are 0, 1, 2 and ports 1, 2"):
        MACHINE.line(axis, port)


def test_every_number_has_a_source_in_the_thesis_or_a_reason_to_assume_it():
    for name in shipped_machines():
        for row in sources(name):
            kind, reason = row.source.split(" ", 1)
            assert kind in ("Thesis", "assumed:"), row
            assert len(reason) > 4, row


def numbers(part, prefix=""):
    """Dotted keys of every number that a machine holds."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            yield from numbers(value, f"{prefix}{field.name}.")
        elif isinstance(value, float):
            yield prefix + field.name


@pytest.mark.parametrize("machine", [MACHINE, THESIS], ids=["c180_hoses", "thesis"])
def test_sources_list_every_number_of_the_machine_and_each_is_declared(machine):
    keys = [row.key for row in sources(machine.name)]
    assert len(keys) == len(set(keys))
    assert set(keys) == set(numbers(machine))
    assert set(keys) <= set(parameters(Machine))
    assert set(keys) <= set(declared(machine))


def test_sources_are_in_the_units_of_the_file():
    rows = {row.key: row for row in sources("c180_thesis")}
    assert rows["pump.supply_pressure"][1:3] == (3000.0, "psi")
    assert "port_valves.relief_pressure" not in rows


def test_every_parameter_has_an_si_unit_a_range_and_a_meaning():
    for key, allowed in parameters(Machine).items():
        assert UNITS[allowed.unit] == (allowed.unit, 1.0), key
        assert allowed.low < allowed.high, key
        assert len(allowed.doc) > 5, key


def test_machine_cannot_be_changed_in_place():
    with pytest.raises(dataclasses.FrozenInstanceError):
        MACHINE.command_timeout = 1.0


@pytest.mark.parametrize("value", [-1.0, 200.0, math.nan, math.inf, "4", True])
def test_a_variant_outside_the_range_is_refused_and_the_range_named(value):
    with pytest.raises(MachineError, match=r"Hose\.length: .*(0\.1 \.\. 100 m|not a finite number \[m\])"):
        dataclasses.replace(MACHINE.hose, length=value)


def test_whole_numbers_become_floats():
    length = dataclasses.replace(MACHINE.hose, length=3).length
    assert (length, type(length)) == (3.0, float)


@pytest.mark.parametrize(
    ("part", "change", "message"),
    [
        (
            MACHINE.boom,
            {"rod_area": 0.02},
            r"rod_area \(0.02 m2\) must be smaller than head_area \(0.01824 m2\)",
        ),
        (
            MACHINE.boom,
            {"stroke": 1.1},
            "from 1.3 to 2.4 m, the linkage closes only between 1.22384 and 2.34892",
        ),
        (MACHINE.boom, {"retracted_length": 1.2}, "the linkage closes only between"),
        (MACHINE.swing, {"upper_limit": -4.0}, "lower_limit .* must be smaller than upper_limit"),
        (MACHINE.sensors.flow_meter, {"lowest": 0.01}, "lowest .* must be smaller than highest"),
        (MACHINE.sensors.thermocouple, {"highest": 250.0, "lowest": 300.0}, "lowest .* must be smaller"),
        (MACHINE.valve, {"rated_voltage": 1.0}, "deadband_voltage .* must be smaller than rated_voltage"),
    ],
)
def test_values_that_contradict_each_other_are_refused(part, change, message):
    with pytest.raises(MachineError, match=message):
        dataclasses.replace(part, **change)


@pytest.mark.parametrize("name", ["", "../up", "a/b", "back\\slash", "two\nlines"])
def test_a_name_by_which_no_file_can_be_named_is_refused(name):
    with pytest.raises(MachineError, match="files are named by it; allowed: printable characters"):
        dataclasses.replace(MACHINE, name=name)


def test_units_that_convert_agree_with_their_definitions():
    assert UNITS["deg"].factor * 180.0 == pytest.approx(math.pi)
    assert UNITS["m3/rev"].factor * 2.0 * math.pi == pytest.approx(1.0)
    assert UNITS["cm3/rev"].factor == pytest.approx(1e-6 * UNITS["m3/rev"].factor)
    assert UNITS["psi"].factor == pytest.approx(0.45359237 * 9.80665 / 0.0254**2, rel=1e-4)
    assert UNITS["gal/min"].factor == pytest.approx(3.785411784e-3 / 60.0)
    assert UNITS["L/min"].factor == pytest.approx(1e-3 / 60.0)
    assert UNITS["rpm"].factor * 60.0 == pytest.approx(2.0 * math.pi)
    assert UNITS["percent"].factor == 0.01
    assert UNITS["L/(min*bar)"].factor == pytest.approx(1e-3 / (60.0 * 1e5), rel=1e-12, abs=0.0)
    assert all(UNITS[unit.si] == (unit.si, 1.0) for unit in UNITS.values())
