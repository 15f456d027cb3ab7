"""When a record's residuals are a doubt, and when it alone is a stranger."""

import numpy as np
import pytest

from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement import data_quality

SESSION = Session("damping_boom", np.arange(3) * 0.5, np.zeros((3, 3)), {"boom_resolver": np.zeros(3)})


def left(times, correlation=0.0, channel="boom_resolver"):
    return ResidualTest(channel, times * 1e-3, times, 100, correlation)


def fitted(converged=True, asked=()):
    return Fit({}, {}, 1.0, EMPTY, {}, {}, 12, {}, converged, np.array(asked))


def doubt(*tests, fit=None, stated=()):
    return data_quality.doubt(SESSION, fit or fitted(), tests, stated)


def test_residuals_are_a_doubt_if_they_are_half_as_much_again_as_noise_and_correlated():
    assert doubt(left(1.4, 0.9), left(9.0, 0.19), left(9.0, None)) == ""
    assert doubt(left(1.6, 0.21), left(1.7, 0.5, "stick_resolver")).endswith(
        "damping_boom are 1.7 times the noise of stick_resolver and correlated (0.50)"
    )
    assert "broken off after 12 steps" in doubt(left(1.0), fit=fitted(converged=False))


def test_a_told_number_is_a_doubt_if_the_record_asks_for_more_than_five_deviations():
    stated = ("boom.stroke", "stick.stroke")
    assert doubt(fit=fitted(asked=[-4.9, 3.0]), stated=stated) == ""
    assert "asks for boom.stroke 6 standard deviations" in doubt(fit=fitted(asked=[-6.1, 5.5]), stated=stated)


def test_a_record_five_times_above_its_noise_is_not_explained_and_names_its_worst_channel():
    assert data_quality.is_explained([left(4.9), left(1.0)])
    assert not data_quality.is_explained([left(1.0), left(5.1)])
    assert data_quality.not_explained(SESSION, [left(4.9)]) == []
    (remark,) = data_quality.not_explained(SESSION, [left(7.0), left(30.0, channel="stick_resolver")])
    assert "0.03 rad are left at stick_resolver, 30 times the sensor's noise" in remark


def test_one_record_of_four_may_be_a_stranger():
    good, bad = [left(1.0)], [left(1.0), left(9.0)]
    assert data_quality.stranger({"a": good, "b": bad, "c": good, "d": good}) == "b"
    assert data_quality.stranger({"a": good, "b": bad, "c": good}) == ""
    assert data_quality.stranger({"a": bad, "b": bad, "c": good, "d": good}) == ""
    assert data_quality.stranger({"a": good, "b": good, "c": good, "d": good}) == ""
    assert data_quality.cut_off(SESSION).endswith("what is whole of it (1.0 s) was used")


@pytest.mark.parametrize("error", [ZeroDivisionError, IndexError, ValueError, np.linalg.LinAlgError])
def test_what_cannot_be_evaluated_names_the_record(error):
    told = "damping_boom: the record cannot be evaluated"
    with pytest.raises(SessionError, match=told), data_quality.evaluated(SESSION):
        raise error("any")
    with pytest.raises(SessionError, match=r"^own words$"), data_quality.evaluated(SESSION):
        raise SessionError("own words")
