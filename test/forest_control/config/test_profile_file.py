"""Claims about operator profiles: files that say what is wrong with them."""

import os
from pathlib import Path

import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.config.profile_file import KEYS, load_profile, shipped
from forest_control.config.setting_file import SettingFileError
from forest_control.operator.joystick_watch import WatchParameters
from forest_control.operator.levers import Levers
from forest_control.operator.operator_profile import shaped
from forest_description.machine import load_machine
from forest_msgs_py.runtime.parameter_table import table_of, typed_values


def settings_with(profile):
    return table_of(Settings, typed_values(Settings()) | profile)


def test_every_shipped_profile_loads_into_settings():
    assert shipped() == ("default", "exact", "fine", "operator")
    for name in shipped():
        profile = load_profile(name)
        assert set(profile) == set(KEYS)
        made = typed_values(settings_with(profile))
        assert {key: made[key] for key in KEYS} == profile


def test_the_exact_profile_is_what_studies_assume_and_the_default_has_a_deadzone_besides():
    typed = typed_values(Settings())
    exact = {key: typed[key] for key in KEYS}
    assert load_profile("exact") == exact
    assert exact["deadzone"] == (0.0, 0.0, 0.0)
    assert load_profile("default") == exact | {"deadzone": (0.05, 0.05, 0.05)}


def shaped_by(name, *levers):
    settings = settings_with(load_profile(name))
    return shaped(Levers(*levers), parameters(load_machine("c180_hoses"), settings).profile)


@pytest.mark.parametrize("name", ["default", "fine", "operator"])
def test_a_stick_that_may_be_armed_and_one_that_rests_beside_its_centre_do_not_creep(name):
    centre = WatchParameters().centre
    for rest in (-0.034, centre, -centre):
        assert shaped_by(name, rest, rest, rest) == Levers(0.0, 0.0, 0.0)
    assert min(shaped_by(name, 0.1, 0.1, 0.1)) > 0.0
    assert shaped_by(name, 1.0, -1.0, 1.0) == Levers(1.0, -1.0, 1.0)
    assert shaped_by("exact", -0.034, 0.0, 0.0).swing == -0.034


def test_what_a_file_does_not_name_is_as_in_the_default_profile_and_one_number_serves_three_levers(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("expo: 0.4\ndeadzone: [0, 0.1, 0.2]\ntip_speed: 1\n")
    profile = load_profile(str(file))
    assert profile["expo"] == (0.4, 0.4, 0.4)
    assert profile["deadzone"] == (0.0, 0.1, 0.2)
    assert profile["tip_speed"] == 1.0
    assert profile["mode"] == "rate"
    file.write_text("tip_speed: 1\n")
    assert load_profile(str(file))["deadzone"] == (0.05, 0.05, 0.05)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("gain: 1", "unknown key 'gain'; allowed: mode, axis_frame, deadzone"),
        ("expo: 1.5", r"expo is 1.5; allowed: one number for all levers or three .*, each 0 .. 1"),
        ("expo: [0.1, 0.2]", r"expo is \[0.1, 0.2\]; allowed"),
        ("tip_speed: fast", "tip_speed is 'fast'; allowed: 0.01 .. 3 m/s"),
        ("tip_speed: .nan", "tip_speed is nan; allowed"),
        ("tip_speed: yes", "tip_speed is True; allowed"),
        ("mode: fly", "mode is 'fly'; allowed: rate, position"),
        ("mode: [rate]", r"mode is \['rate'\]; allowed: rate, position"),
        ("- 1", "allowed: a mapping of mode"),
        ("", "allowed: a mapping of mode"),
        ("a: [", "not YAML"),
        ("tip_speed: " + 400 * "9", "tip_speed is 9*[.]{3}; allowed: 0.01 .. 3 m/s"),
        ("tip_speed: " + 5000 * "9", "not YAML: Exceeds the limit"),
        ("tip_speed: 0x" + 5000 * "f", "tip_speed is a number of thousands of digits; allowed: 0.01"),
        ("tip_speed: 2001-99-99", "not YAML: month must be in 1..12"),
        ("mode: &a [*a]", "not YAML: its aliases stand for more than 1000000 values, or for themselves"),
        (" " * 1_000_001, "1000001 bytes; allowed: up to 1000000"),
    ],
)
def test_a_wrong_profile_names_file_key_and_what_is_allowed(tmp_path, text, said):
    file = tmp_path / "mine.yaml"
    file.write_text(text)
    with pytest.raises(SettingFileError, match=said) as error:
        load_profile(str(file))
    assert "mine.yaml" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_profile_is_told_which_are_shipped():
    with pytest.raises(
        SettingFileError, match=r"'nobody': neither shipped \(default, exact, fine, operator\)"
    ):
        load_profile("nobody")


def test_a_pipe_or_a_folder_is_refused_instead_of_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    for path in (tmp_path / "pipe.yaml", tmp_path, Path("/dev/zero")):
        with pytest.raises(SettingFileError, match="allowed: a regular file"):
            load_profile(str(path))
