"""Claims about machine files: what they may say, and what their errors say."""

import os
import re
from importlib import resources

import pytest

from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine, sources, uncertainties

BASE = "based_on: c180_hoses\n"
PRESSURE, UNITS, RANGE = "pump.supply_pressure", "Pa, MPa, bar, psi", "100000 .. 5e+07 Pa"
GOOD_TILT = 'platform_tilt: {value: 5, unit: deg, source: "measured"}'


@pytest.fixture
def write(tmp_path):
    """Write a machine file and return its path."""

    def write_text(text, name="mine.yaml"):
        path = tmp_path / name
        path.write_text(text, "utf-8")
        return path

    return write_text


def complaint(path):
    with pytest.raises(MachineError) as caught:
        load_machine(path)
    return str(caught.value)


def test_a_file_gives_only_what_differs_from_its_base(write):
    machine = load_machine(write(f"{BASE}manipulator:\n  {GOOD_TILT}\n"))
    assert machine.manipulator.platform_tilt == pytest.approx(0.0872664626)
    assert machine.manipulator.head_mass == 700.0
    assert machine.name == "mine"
    assert machine.description == load_machine("c180_hoses").description


def test_null_removes_an_optional_component(write):
    machine = load_machine(write(f"{BASE}port_valves: null\nvalve:\n  spool_bandwidth: null\n"))
    assert machine.port_valves is None
    assert machine.valve.spool_bandwidth is None
    assert machine.end_stops is not None


def test_null_removes_a_kind_of_sensor_or_what_is_not_known_of_it(write):
    sensors = load_machine(write(f"{BASE}sensors:\n  resolver: null\n  pressure: {{noise: null}}\n")).sensors
    assert sensors.resolver is None
    assert sensors.pressure.noise is None
    assert sensors.pressure.accuracy == 0.0001


def test_a_machine_must_say_which_sensors_it_has(write):
    text = re.sub(r"(?m)^sensors:\n(  .*\n)+", "", thesis_text())
    assert "missing key sensors: a section" in complaint(write(text))


def test_a_chain_of_files_is_followed_from_the_folder_of_each(write, tmp_path):
    (tmp_path / "below").mkdir()
    write(f"{BASE}manipulator:\n  {GOOD_TILT}\n", "below/one.yaml")
    write("based_on: one.yaml\nname: middle\n", "below/two.yaml")
    machine = load_machine(write("based_on: below/two.yaml\ndescription: third\n"))
    assert machine.manipulator.platform_tilt > 0.0
    assert (machine.name, machine.description) == ("mine", "third")


def test_sources_of_a_file_name_its_own_numbers_and_those_of_its_base(write):
    rows = {row.key: row for row in sources(write(f"{BASE}manipulator:\n  {GOOD_TILT}\n"))}
    assert rows["manipulator.platform_tilt"][1:4] == (5.0, "deg", "measured")
    assert rows["manipulator.gravity"].source == "Thesis Appendix B, g"


def quantity(text):
    """A file with ``text`` as the pump pressure, in line 3."""
    return f"{BASE}pump:\n  supply_pressure: {text}\n"


@pytest.mark.parametrize(
    ("text", "line", "parts"),
    [
        (
            quantity("{value: 9000, unit: psi, source: x}"),
            3,
            [f"{PRESSURE} = 9000 psi (6.20523e+07 Pa)", RANGE],
        ),
        (quantity("{value: 1, unit: kg, source: x}"), 3, [PRESSURE, "'kg'", UNITS]),
        (quantity("{value: 1, unit: furlong, source: x}"), 3, ["'furlong'", UNITS]),
        (quantity("{value: many, unit: Pa, source: x}"), 3, [PRESSURE, "'many' is not a number"]),
        (quantity("{value: .nan, unit: Pa, source: x}"), 3, ["is not a number", RANGE]),
        (quantity("{value: inf, unit: Pa, source: x}"), 3, ["'inf' is not a number"]),
        (quantity("{value: 2e7, unit: Pa}"), 3, [f"missing {PRESSURE}.source"]),
        (quantity("{value: 2e7, unit: Pa, source: ''}"), 3, [f"missing {PRESSURE}.source"]),
        (quantity("{value: 2e7, source: x}"), 3, [f"missing {PRESSURE}.unit", "unit: Pa"]),
        (quantity("{unit: Pa, source: x}"), 3, [f"missing {PRESSURE}.value", RANGE]),
        (
            quantity("{value: 2e7, unit: Pa, source: x, colour: red}"),
            3,
            [f"{PRESSURE}.colour", "value, unit"],
        ),
        (quantity("2e7"), 3, [f"{PRESSURE} = 2e7", "{value: a number in 100000 .. 5e+07 Pa"]),
        (quantity("[1, 2]"), 3, [f"{PRESSURE} = 1, 2: a number must be written {{value: "]),
        (f"{BASE}\n\npump:\n  speed: 3\n", 5, ["unknown key pump.speed", "allowed: supply_pressure"]),
        (f"{BASE}pumps: 3\n", 2, ["unknown key pumps", "pump, valve, hose, oil, swing, boom, stick"]),
        (f"{BASE}pump: 3\n", 2, ["pump must be a section with keys, not '3'"]),
        (f"{BASE}boom: null\n", 2, ["boom must be a section with keys"]),
        (f"{BASE}description: [a]\n", 2, ["description must be a text"]),
        (f"{BASE}description: null\n", 2, ["description must be a text"]),
        (f"{BASE}name: a\nname: b\n", 3, ["name stands here for the second time"]),
        (f"{BASE}pump: {{\n", 3, ["not valid YAML"]),
        ("based_on: {a: 1}\n", 1, ["based_on must be the name or the file of a machine"]),
        ("- 1\n", 1, ["a machine file is a mapping of keys"]),
        ("", 1, ["a machine file is a mapping of keys"]),
        ("description: x\n", 1, ["missing key pump: a section"]),
        (
            f"{BASE}sensors:\n  thermocouple:\n    lowest: {{value: -270, unit: degC, source: x}}\n",
            4,
            ["sensors.thermocouple.lowest: unit 'degC' does not fit; allowed: K"],
        ),
        (
            f"{BASE}sensors:\n  sample_rate: {{value: 250, unit: Hz, source: x}}\n",
            3,
            ["sensors.sample_rate = 250 Hz is outside the range 1 .. 200 Hz"],
        ),
        ("description: x\npump: {kind: ideal}\n", 2, [f"missing key {PRESSURE}", RANGE]),
        ("pump: {}\n", 1, ["missing key description: a text"]),
    ],
)
def test_error_names_file_line_key_and_what_is_allowed(write, text, line, parts):
    path = write(text)
    message = complaint(path)
    assert message.startswith(f"{path}:{line}: ")
    for part in parts:
        assert part in message


def test_missing_optional_component_is_asked_for_with_null_as_an_answer(write):
    text = "\n".join(line for line in thesis_text().splitlines() if "spool_bandwidth:" not in line)
    assert "missing key valve.spool_bandwidth: a number in 0.1 .. 500 Hz or null" in complaint(write(text))


def thesis_text():
    return (resources.files("forest_description") / "machines" / "c180_thesis.yaml").read_text("utf-8")


@pytest.mark.parametrize(
    ("section", "line", "message"),
    [
        ("swing:\n  upper_limit: {value: -200, unit: deg, source: x}\n", 3, "swing.lower_limit"),
        ("boom:\n  stroke: {value: 2, unit: m, source: x}\n", 3, "boom.retracted_length, stroke"),
        ("stick:\n  rod_area: {value: 190, unit: cm2, source: x}\n", 3, "stick.rod_area"),
        ("stick:\n  angle_offset: {value: 18, unit: deg, source: x}\n", 3, "stick.angle_offset: over the"),
        ("valve:\n  rated_voltage: {value: 1, unit: V, source: x}\n", 3, "valve.deadband_voltage"),
    ],
)
def test_contradicting_values_name_file_key_and_line(write, section, line, message):
    path = write(BASE + section)
    assert complaint(path).startswith(f"{path}:{line}: {message}")


def test_unknown_machine_is_answered_with_the_known_ones():
    assert complaint("c190") == (
        "no machine named 'c190': there are c180, c180_hoses, c180_thesis, forwarder, loader, unknown:SEED; "
        "a file needs its suffix (.yaml)"
    )


def test_a_base_that_is_no_machine_is_named_with_its_place(write):
    path = write("based_on: c18O\n")
    assert complaint(path).startswith(f"{path}:1: based_on: no machine named 'c18O'")


def test_unreadable_files_are_named_with_the_reason(tmp_path):
    absent = tmp_path / "absent.yaml"
    assert complaint(absent) == f"{absent}: cannot read the machine file: No such file or directory"
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00")
    assert complaint(binary) == f"{binary}: cannot read the machine file: not UTF-8 text"
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)  # without a writer, reading would wait
    assert complaint(pipe) == f"{pipe}: cannot read the machine file: not a regular file"
    endless = tmp_path / "endless.yaml"
    endless.touch()
    os.truncate(endless, 1 << 30)  # a file of holes takes no place on the disk
    assert complaint(endless) == f"{endless}: a machine file has at most 1000000 bytes, this one has more"


def test_a_control_character_is_reported_as_bad_yaml(write):
    assert re.search(r"mine\.yaml:1: not valid YAML", complaint(write("name: \x07\n")))


def test_a_circle_of_files_is_reported(write):
    write("based_on: mine.yaml\n", "other.yaml")
    assert complaint(write("based_on: other.yaml\n")).startswith("based_on goes round in a circle: ")


@pytest.mark.parametrize("text", ["[" * 30000, "".join(f"{' ' * i}b:\n" for i in range(1000)), "- " * 3000])
def test_a_file_that_is_nested_without_end_is_refused_with_its_name(write, text):
    assert re.fullmatch(
        r".*mine.yaml:1: not valid YAML: nested more than 50 levels deep", complaint(write(text))
    )


@pytest.mark.parametrize("uncertainty", ["0", "-1", "wide", "[1, 2]"])
def test_an_uncertainty_is_a_number_above_zero(write, uncertainty):
    tilt = GOOD_TILT.replace("}", f", uncertainty: {uncertainty}}}")
    said = complaint(write(f"{BASE}manipulator:\n  {tilt}\n"))
    assert "manipulator.platform_tilt.uncertainty" in said


def test_an_uncertainty_is_half_of_the_interval_in_the_unit_of_its_number(write):
    tilt = GOOD_TILT.replace("}", ", uncertainty: 0.5}")
    found = uncertainties(write(f"{BASE}manipulator:\n  {tilt}\n"))
    assert found == {"manipulator.platform_tilt": pytest.approx(0.0087266463)}
