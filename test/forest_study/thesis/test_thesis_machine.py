"""The thesis' study on the full machine: what the schemes reach there, and the command's files."""

import json

import pytest

from forest_control.servo.schemes import LABELS, Scheme
from forest_study.cli import main
from forest_study.thesis import thesis_machine, thesis_machine_report
from forest_study.thesis.thesis_machine import PLANTS, Trial, found, machine_of, settings_of


@pytest.fixture(scope="module")
def as_built():
    return {scheme: found(Trial(scheme)) for scheme in Scheme}


def test_coordinated_has_less_than_half_the_error_of_any_scheme_of_the_thesis(as_built):
    ours = as_built[Scheme.COORDINATED]
    for scheme in list(Scheme)[:-1]:
        for quantity in ("position_error", "position_rms", "velocity_error_y"):
            assert ours[quantity] < 0.6 * as_built[scheme][quantity]
    assert ours["position_rms"] < 0.02


def test_velocity_servos_lag_less_than_position_servos_on_the_machine_that_they_know(as_built):
    for velocity, position in (("IK_VELOCITY", "IK_POSITION"), ("JACOBIAN_VELOCITY", "JACOBIAN_POSITION")):
        assert as_built[Scheme[velocity]]["position_rms"] < as_built[Scheme[position]]["position_rms"]


def test_on_valves_that_are_off_velocity_servos_drift_and_position_feedback_does_not():
    for scheme in (Scheme.JACOBIAN_VELOCITY, Scheme.IK_POSITION, Scheme.COORDINATED):
        drift = abs(found(Trial(scheme, mismatch=-0.2))["drift_x"])
        assert (drift > 0.1) == (scheme == Scheme.JACOBIAN_VELOCITY)
        assert drift > 0.1 or drift < 0.01


def test_coordinated_stands_valves_a_fifth_off_either_way():
    """A loop on the pose alone rings here on the swing's hoses: 130 mm."""
    for mismatch in (-0.2, 0.2):
        assert found(Trial(Scheme.COORDINATED, mismatch=mismatch))["position_error"] < 0.05


def test_coordinated_waits_for_no_spool_that_is_on_its_way():
    """Spools of 0.2 Hz are asked for full voltage nearly always: the tip stayed 0.9 m back."""
    ours = found(Trial(Scheme.COORDINATED, "0.2 Hz"))
    assert ours["position_rms"] < 0.05
    assert ours["position_error"] < 0.1


def test_a_mismatch_changes_the_valves_flow_and_the_spools_but_not_what_is_believed():
    exact, wrong = machine_of("2 Hz"), machine_of("2 Hz", 0.25)
    assert wrong.valve.spool_bandwidth == pytest.approx(2.5)
    assert wrong.valve.minimum_resistance == pytest.approx(1.25**2 * exact.valve.minimum_resistance)
    assert machine_of("as built") == thesis_machine.load_machine("c180_hoses")


def test_gains_for_slow_spools_are_the_thesis_own():
    made = settings_of(Scheme.JACOBIAN_POSITION, "2 Hz")
    assert made.velocity_gain == pytest.approx((0.313,) * 3, rel=2e-3)
    assert made.position_gain == pytest.approx((21.66,) * 3, rel=1e-3)
    assert made.damping_gain == pytest.approx((3.307,) * 3, rel=1e-3)
    assert made.jacobian_at_joints
    assert settings_of(Scheme.JOINT, "as built").position_gain == (2.5, 5.0, 5.0)


def test_the_command_writes_numbers_tables_and_pictures(tmp_path, monkeypatch, capsys):
    """With one trial for all: the study takes a minute and a half."""
    one, moved = found(Trial(Scheme.JOINT)), thesis_machine.motion(Trial(Scheme.JOINT))
    monkeypatch.setattr(thesis_machine, "found", lambda _: one)
    monkeypatch.setattr(thesis_machine_report, "motion", lambda _: moved)
    assert main(["thesis", "--plant", "machine", "--out", str(tmp_path / "out")]) == 0
    result = json.loads((tmp_path / "out" / "study.json").read_text("utf-8"))
    assert set(result["plants"]) == {*PLANTS, "2 Hz -20%", "2 Hz +20%"}
    assert [row["mismatch"] for row in result["mismatch_sweep"]] == [
        round(0.1 * k - 0.5, 1) for k in range(11)
    ]
    assert set(result["plants"]["as built"]) == set(LABELS)
    names = {path.name for path in (tmp_path / "out").glob("*.png")}
    assert names == {"as_built.png", "2_Hz.png", "0_2_Hz.png", "mismatch.png"}
    assert "| `coordinated` |" in capsys.readouterr().out


def test_an_unknown_plant_is_refused(tmp_path, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["thesis", "--plant", "paper", "--out", str(tmp_path / "out")])
    assert stopped.value.code == 2
    assert "linear" in capsys.readouterr().err
