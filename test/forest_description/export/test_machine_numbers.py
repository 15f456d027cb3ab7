"""Claims about the document of the shipped machines' numbers."""

import dataclasses
import subprocess
import sys
from pathlib import Path

from forest_description.config.schema import Quantity, parameters
from forest_description.export import machine_keys
from forest_description.export.machine_numbers import choices, document, number, table
from forest_description.hydraulics.valve_parameters import TableCurve
from forest_description.machine import Machine, load_machine

ROOT = Path(__file__).parents[3]
MACHINE, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")


def test_the_table_tells_rows_of_numbers_and_the_meaning_of_the_sort_that_is_there():
    assert number((1.0, 2.5e12), 6) == "1, 2.5e+12"
    pressure = Quantity("pump.supply_pressure", 3000.0, "psi", "assumed: x")
    assert "constant" in table([pressure], THESIS)
    assert "constant" not in table([pressure], MACHINE)
    curve = TableCurve((2.0, 10.0), (4e13, 1e12))
    measured = dataclasses.replace(MACHINE, valve=dataclasses.replace(MACHINE.valve, curve=curve))
    row = table([Quantity("valve.curve.voltages", (2.0, 10.0), "V", "Thesis 4.3.2")], measured)
    assert "| `valve.curve.voltages` | 2, 10 | V | rising" in row


def test_choices_are_told_by_their_names_and_absent_components_as_none():
    chosen, default = choices(THESIS), choices(MACHINE)
    assert (chosen["pump"], default["pump"]) == ("ideal", "pressure_compensated")
    assert (chosen["port_valves"], "port_valves" in default) == ("none", False)
    assert (chosen["swing.flow_regime"], chosen["boom.flow_regime"]) == ("laminar", "turbulent")
    assert (chosen["valve.spool_bandwidth"], "valve.spool_bandwidth" in default) == ("none", False)


def test_the_documented_table_is_up_to_date():
    assert (ROOT / "docs" / "reference" / "machine.md").read_text("utf-8") == document()


def test_the_module_prints_the_table():
    done = subprocess.run(
        [sys.executable, "-m", "forest_description.export.machine_numbers"],
        capture_output=True,
        check=True,
        timeout=300,
    )
    assert done.stdout.decode("utf-8") == document()


def test_the_documented_reference_is_up_to_date_and_knows_every_key():
    text = machine_keys.document()
    assert (ROOT / "docs" / "reference" / "machine-file.md").read_text("utf-8") == text
    for key in parameters(Machine):
        assert f"| `{key.rpartition('.')[2]}` |" in text, key
