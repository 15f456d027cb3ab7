import pytest

from forest_description.machine import load_machine
from forest_ident.diagnosis import monitor, residual_parameters
from forest_ident.diagnosis.findings import Alarms, alarms, findings
from forest_ident.diagnosis.residual_limits import LIMITS
from forest_ident.diagnosis.residuals import NAMES
from forest_ident.diagnosis.signatures import CAUSES

P = monitor.Parameters(residual_parameters.parameters(load_machine("c180")), LIMITS)


def named(residuals=None, **others):
    told = Alarms(
        residuals or {}, others.pop("frozen", ()), others.pop("missing", ()), others.pop("at_start", ())
    )
    return [(one.part, one.cause) for one in findings(told)]


@pytest.mark.parametrize(
    ("residuals", "expected"),
    [
        ({"boom_spool": 1.2, "boom_lost_1": -3.0, "boom_deadband_forward": -2.0}, ("boom", "spool")),
        ({"boom_lost_1": -1.2, "boom_lost_2": 1.1, "boom_gain_backward": -1.5}, ("boom", "piston")),
        ({"stick_lost_1": -1.2}, ("stick", "holding")),
        ({"swing_meter": 1.2}, ("swing", "piston")),
        ({"boom_pressure_2_pair": -1.2, "boom_lost_2": 5.0}, ("boom", "pressure")),
        ({"stick_agree": 1.2, "stick_gain_backward": 1.1}, ("stick", "length")),
        ({"swing_deadband_backward": 1.4, "swing_follow": 1.1}, ("swing", "deadband")),
        ({"boom_follow": 1.1}, ("boom", "motion")),
        ({"boom_stiff_2": 1.1}, ("boom", "stiffness")),
        ({"supply": -1.3}, ("machine", "pump")),
        ({"cold": 1.3, "drain": -2.0}, ("machine", "cold")),
    ],
)
def test_a_pattern_has_one_cause_which_hides_what_follows_from_it(residuals, expected):
    assert named(residuals) == [expected]


def test_two_axes_may_each_have_their_own_fault():
    assert named({"boom_spool": 1.5, "stick_agree": 2.0}) == [("boom", "spool"), ("stick", "length")]


def test_sensors_that_are_out_are_named_and_their_axis_is_not_judged():
    told = {"boom_agree": 3.0, "boom_gain_forward": 2.0}
    assert named(told, frozen=("boom_transducer",)) == [("sensors", "frozen")]
    many = findings(Alarms({}, (), tuple(f"sensor_{i}" for i in range(9))))
    assert "sensor_3 and 5 more: no readings" in str(many[0])


def test_several_axes_that_were_out_from_the_start_mean_another_machine():
    told = {"boom_gain_forward": -1.5, "stick_agree": 1.4, "stick_gain_backward": -1.2}
    assert ("machine", "machine file") not in named(told)  # it has come later
    assert named(told, at_start=tuple(told)) == [("machine", "machine file")]
    assert ("machine", "machine file") not in named(told, at_start=("boom_gain_forward",))
    frozen = named(told, at_start=tuple(told), frozen=("boom_transducer",))
    assert ("machine", "machine file") not in frozen


def test_a_meter_that_was_off_from_the_start_names_the_file_first_and_no_leak():
    told = {"stick_meter": 4.0, "supply": -1.2}
    assert named(told) == [("stick", "piston"), ("machine", "pump")]
    assert named(told, at_start=("stick_meter",)) == [("machine", "machine file")]
    leaks = told | {"stick_lost_1": -2.0, "stick_lost_2": 2.0}
    assert named(leaks, at_start=("stick_meter",)) == [("machine", "machine file"), ("stick", "piston")]


def test_each_pattern_is_of_residuals_that_there_are():
    known = {name.removeprefix("boom_") for name in NAMES}
    for cause in CAUSES:
        for pattern in cause.patterns:
            for part in pattern:
                what = part[:-1].replace("pair_1", "pressure_1_pair").replace("pair_2", "pressure_2_pair")
                assert what.replace("meter", "agree") in known, part


def test_what_is_told_says_what_to_do_and_what_it_may_be_confused_with():
    text = str(findings(Alarms({"boom_spool": 1.2}, (), ()))[0])
    assert text.startswith("boom: the spool does not follow its voltage")
    assert "(or its position sensor, its amplifier)" in text
    assert text.endswith("then clean the spool")


def test_a_new_monitor_finds_nothing():
    assert findings(alarms(monitor.BEGIN, P)) == []
