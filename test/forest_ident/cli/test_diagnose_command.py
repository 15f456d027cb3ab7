"""The monitor over bags: a standing crane that is well, and one whose sensors are not."""

import json

import numpy as np

from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_ident.cli import verbs
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import Session

MACHINE = load_machine("c180_hoses")
ANGLES = 0.1, 0.4, -1.4
ROWS, PERIOD = 5000, 0.005


def bag(path, **changes):
    """Write 25 s of a standing crane whose sensors jitter; changes: by channel, of its column."""
    rng = np.random.default_rng(3)
    level = {
        "swing_resolver": ANGLES[0],
        "boom_resolver": ANGLES[1],
        "stick_resolver": ANGLES[2],
        "boom_transducer": cylinder_length(ANGLES[1], MACHINE.boom.linkage),
        "stick_transducer": cylinder_length(ANGLES[2], MACHINE.stick.linkage),
    }
    level |= {
        f"{axis}_pressure_{port}_{place}": 4e6
        for axis in ("swing", "boom", "stick")
        for port in (1, 2)
        for place in ("valve", "actuator")
    }
    columns = {name: x + 1e-4 * max(1.0, abs(x)) * rng.normal(size=ROWS) for name, x in level.items()}
    for name, change in changes.items():
        columns[name] = change(columns[name])
    session = Session("motion", PERIOD * np.arange(ROWS), np.zeros((ROWS, 3)), columns)
    session_bag.write(session, path)
    return str(path)


def biased(column):
    return column + np.where(np.arange(ROWS) > 1000, 0.02, 0.0)


def diagnose(capsys, *arguments):
    code = verbs.main(["diagnose", *arguments, "--machine", "c180_hoses"])
    return code, capsys.readouterr().out


def test_a_biased_transducer_is_found_in_a_bag_with_what_to_do(tmp_path, capsys):
    report = tmp_path / "found.json"
    given = bag(tmp_path / "ill", boom_transducer=biased)
    code, out = diagnose(capsys, given, "--out", str(report))
    assert code == 1
    assert "boom: cylinder's length and joint's angle do not belong together" in out
    assert "calibrate the sensor" in out
    found = json.loads(report.read_text())["findings"]
    assert ("boom", "length") in {(one["part"], one["cause"]) for one in found}
    assert all(5.0 < one["first_s"] < 20.0 for one in found if one["cause"] == "length")


def test_of_a_sound_crane_only_what_is_not_recorded_is_told(tmp_path, capsys):
    code, out = diagnose(capsys, bag(tmp_path / "well"))
    assert code == 1  # the file has sensors of which the bag has nothing
    assert out.count("\n    ") == 1
    assert "supply_pressure, swing_spool, boom_spool, stick_spool and 2 more: no readings" in out


def test_a_frozen_transducer_is_found(tmp_path, capsys):
    frozen = lambda column: np.where(np.arange(ROWS) > 3000, column[3000], column)  # noqa: E731
    _, out = diagnose(capsys, bag(tmp_path / "ill", stick_transducer=frozen))
    assert "stick_transducer: repeats its last reading" in out


def test_what_a_sound_machine_has_taught_is_the_reference(tmp_path, capsys):
    off = lambda column: column + 1.5e-3  # noqa: E731  within what sensors may be off
    sound = bag(tmp_path / "sound", boom_transducer=off)
    after = bag(tmp_path / "after")
    assert "length" not in diagnose(capsys, after)[1]
    assert "boom: cylinder's length" in diagnose(capsys, after, "--healthy", sound)[1]


def test_a_bag_without_angles_is_refused(tmp_path, capsys):
    session = Session("motion", PERIOD * np.arange(10), np.zeros((10, 3)), {"supply_pressure": np.ones(10)})
    session_bag.write(session, tmp_path / "bare")
    assert verbs.main(["diagnose", str(tmp_path / "bare"), "--machine", "c180_hoses"]) != 0
    assert "no topic joint_states; the monitor needs angles and voltages" in capsys.readouterr().err


def test_a_machine_without_resolvers_at_boom_and_stick_is_refused(tmp_path, capsys):
    file = tmp_path / "cable.yaml"
    file.write_text("based_on: c180\nsensors:\n  joint_angles: linear_transducer\n", encoding="utf-8")
    assert verbs.main(["diagnose", "nowhere", "--machine", str(file)]) == 1
    assert "cable has the angles of boom and stick by its linear_transducer" in capsys.readouterr().err
