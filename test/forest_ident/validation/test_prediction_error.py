"""How far a prediction is off: over a signal's range, over its variance, and at what its sensor can show."""

import numpy as np
import pytest

from forest_ident.measurements.session import Session
from forest_ident.validation import prediction_error
from forest_ident.validation.prediction_error import Signal

RAMP = np.arange(0.0, 5.0)


def signal(name, off, measured=RAMP):
    return Signal("boom", name, "1", measured, measured + off)


def test_an_error_is_told_over_the_range_and_over_the_variance():
    assert signal("angle", 0.04).nrmse == pytest.approx(0.01)
    assert signal("angle", 0.04).vaf == pytest.approx(1.0)  # an offset has no variance
    zigzag = np.array([1.0, -1.0, 0.0, -1.0, 1.0])
    assert signal("angle", zigzag).nrmse == pytest.approx(np.sqrt(0.8) / 4.0)
    assert signal("angle", zigzag).vaf == pytest.approx(1.0 - 0.8 / 2.0)
    still = signal("angle", 0.0, np.zeros(5))
    assert (still.nrmse, still.vaf) == (0.0, 1.0)


def test_a_signal_beyond_its_limit_is_missed_and_named():
    for name, limit in {"angle": 0.02, "velocity": 0.05, "flow": 0.05, "pressure 1": 0.1}.items():
        assert not prediction_error.is_missed(signal(name, 3.999 * limit))
        assert prediction_error.is_missed(signal(name, 4.001 * limit))
        assert prediction_error.is_missed(signal(name, np.nan))
    good, bad = signal("angle", 0.0), signal("pressure 1", 0.8)
    (text,) = prediction_error.over_limit([good, bad])
    assert text.startswith("boom pressure 1 is 20.0 % off, limit ")
    *_, first, second = prediction_error.text_table([good, bad]).splitlines()
    assert first.startswith("| boom angle | 0.00 | ")
    assert first.endswith(" | 100.00 |")
    assert second.startswith("| boom pressure 1 | 20.00 | ")
    assert " missed | 100.00 |" in second


def test_flows_and_pressures_are_compared_as_meters_and_transducers_show_them():
    """A meter shows its floor at rest, and either sign of it; a transducer may show nothing below zero."""
    flow, exact = [0.1, 0.1, 0.1, -0.5, 0.4], [0.05, -0.02, -0.3, -0.6, 0.3]
    read = {
        "boom_resolver": np.zeros(5),
        "boom_flow": np.array(flow),
        "boom_pressure_1_actuator": np.array([0.0, 1.0, 2.0, 3.0, 4.0]),
        "boom_pressure_2_actuator": np.array([-1.0, 1.0, 2.0, 3.0, 4.0]),
    }
    below = np.array([-2.0, 1.0, 2.0, 3.0, 4.0])
    told = {
        "boom_resolver": np.full(5, 0.5),
        "boom_flow": np.array(exact),
        "boom_pressure_1_actuator": below,
        "boom_pressure_2_actuator": below,
    }
    session = Session("validation", np.arange(5) * 0.005, np.zeros((5, 3)), read)
    found = {one.name: one for one in prediction_error._axis("boom", session, told)}
    assert [*found] == ["angle", "velocity", "flow", "pressure 1", "pressure 2"]
    assert [*found["flow"].predicted] == [0.1, 0.1, -0.3, -0.6, 0.3]
    assert found["pressure 1"].predicted[0] == 0.0
    assert found["pressure 2"].predicted[0] == -2.0
    assert [*found["angle"].predicted] == [0.5] * 5
    assert {one.axis for one in found.values()} == {"boom"}
