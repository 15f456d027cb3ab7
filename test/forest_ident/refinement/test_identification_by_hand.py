"""Parts of an identification on numbers made by hand: offsets, an axis' own valve, doubts, failures."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.estimators.calibration import Offset, updated
from forest_ident.estimators.parameter_estimate import Estimate
from forest_ident.measurements.parameter_path import part_of, with_directions
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error.fit_problem import Fit
from forest_ident.output_error.gaussian_estimate import EMPTY, GaussianEstimate
from forest_ident.output_error.residual_test import ResidualTest
from forest_ident.refinement import identification, refinement
from forest_ident.refinement.identification import identify
from forest_ident.refinement.refinement_task import Task
from forest_ident.refinement.result import Doubt, Refined, Result

C180, LOADER = load_machine("c180_hoses"), load_machine("loader")


def record(name):
    volts = np.zeros((100, 3))
    volts[50:, 1] = 4.0
    return Session(name, np.arange(100) * 0.005, volts, {})


def pressure(name, offset, error):
    return Offset(name, offset, error, "Pa")


def test_of_transducers_offsets_the_last_of_each_is_the_prior_of_the_first_fit():
    names = ("boom_pressure_1_valve", "supply_pressure", "stick_pressure_1_valve")
    offsets = [
        pressure(names[0], 5e3, 200.0),
        pressure(names[1], -1e3, 0.1),
        pressure(names[0], 6e3, 100.0),
        pressure(names[2], 9e3, math.inf),
        Offset("tank_temperature", 0.5, 0.1, "K"),
    ]
    found = identification._of_offsets(offsets)
    assert found.names == (f"{names[0]}.b", f"{names[1]}.b")
    assert found.mean.tolist() == [6e3, -1e3]
    assert np.sqrt(np.diag(found.covariance)).tolist() == [100.0, 1.0]  # a pascal at least
    assert found.covariance[0, 1] == 0.0
    assert identification._of_offsets(offsets[3:]) is EMPTY


def test_a_file_with_a_calibration_tells_offsets_with_the_noise_of_a_sample():
    units = updated(C180, [pressure("supply_pressure", 5e3, 1.0), Offset("tank_temperature", 1.0, 0.1, "K")])
    sensors = dataclasses.replace(C180.sensors, calibration=units)

    def told(part, facts=None):
        machine = dataclasses.replace(C180, sensors=dataclasses.replace(sensors, pressure=part))
        session = dataclasses.replace(record("gravity"), metadata=facts or {})
        return identification._offsets_of_file(machine, [session])

    part = C180.sensors.pressure
    assert told(part) == [Offset("supply_pressure", 5e3, part.noise, "Pa")]
    (silent,) = told(dataclasses.replace(part, noise=None))
    assert silent.offset_error == pytest.approx(part.full_scale * part.accuracy)
    (vague,) = told(dataclasses.replace(part, noise=None, accuracy=None))
    assert vague.offset_error == pytest.approx(1e-4 * part.full_scale)
    assert told(None) == told(part, {"exact_sensors": 1.0}) == []


def fitted(values, errors, posterior=EMPTY, converged=True):
    return Fit(values, errors, 7.0, posterior, {}, {}, 1, {}, converged)


@pytest.mark.parametrize(
    ("away", "error", "own"),
    [(0.0101, 0.0025, True), (0.0099, 1e-6, False), (0.02, 0.0051, False), (-0.0101, 0.0025, True)],
)
@pytest.mark.parametrize("way", ["", "backward."])
def test_an_axis_gets_its_own_valve_if_it_differs_by_4_errors_and_10_mv_either_way(away, error, own, way):
    result = Result(C180, with_directions(C180, "valve"))
    usual = C180.valve.deadband_voltage
    keys = ("boom.valve.deadband_voltage", "boom.valve.backward.deadband_voltage")
    values = dict.fromkeys(keys, usual) | {f"boom.valve.{way}deadband_voltage": usual + away}
    assert identification._takes_own_valve(result, "boom", fitted(values, dict.fromkeys(keys, error))) == own
    assert (part_of(result.machine, "boom.valve") is not None) == own
    assert [(e.key, e.value, e.standard_error, e.unit, e.initial) for e in result.linear] == [
        (key, values[key], error, "V", False) for key in keys
    ]


def test_an_axis_that_had_its_own_valve_keeps_it():
    result = Result(LOADER, with_directions(LOADER, "stick.valve"))
    law = result.machine.stick.valve.law
    keys = ("stick.valve.deadband_voltage", "stick.valve.backward.deadband_voltage")
    volts = (law.forward.deadband_voltage, law.backward.deadband_voltage)
    same = fitted(dict(zip(keys, volts, strict=True)), dict.fromkeys(keys, 1.0))
    assert identification._takes_own_valve(result, "stick", same)


def test_a_record_tells_a_number_that_it_knows_no_worse_than_it_was_known():
    def known(sd, names=("a",)):
        return GaussianEstimate(names, np.zeros(1), np.array([[sd**2]]))

    tells = identification._tells
    assert tells(known(0.1), known(0.2), "a")
    assert tells(known(0.2), known(0.2), "a")
    assert tells(known(0.209), known(0.2), "a")  # as well, but for what derivatives err
    assert not tells(known(0.211), known(0.2), "a")
    assert tells(known(9.0), known(0.1, ("b",)), "a")


def doubts(result, posterior, known=EMPTY, times=1.0, told=()):
    left = [ResidualTest("boom_resolver", times * 1e-3, times, 100, 0.9)]
    one = Refined(record("damping_boom"), fitted({}, {}, posterior), ("a", "b"), left)
    return identification._doubts(result, one, known, told)


def test_a_record_is_doubtful_by_itself_or_by_a_tenth_of_a_variance_that_it_owes():
    """a hangs on t by 0.3 and b by 0.33 of their deviations: 9 and 11 % of their variances."""
    names, tie = ("a", "b", "t"), np.array([0.3, 0.33, 1.0])
    rows = np.outer(tie, tie)
    np.fill_diagonal(rows, 1.0)
    posterior = GaussianEstimate(names, np.zeros(3), rows)
    result = Result(C180, C180)
    assert doubts(result, posterior) == []
    (own,) = doubts(result, posterior, GaussianEstimate(("b",), np.zeros(1), np.eye(1)), 2.0, ("t",))
    assert own.keys == ("a", "b", "t")
    assert own.told == {"a", "b", "t"}
    assert "2.0 times the noise of boom_resolver" in own.reason
    result.doubts = [Doubt("why not", ("t",), frozenset({"t"}))]
    (owed,) = doubts(result, posterior)
    assert owed == Doubt(
        "11 % of its variance comes from what is doubtful: why not", ("b",), frozenset({"b"})
    )


def test_a_record_that_cannot_be_refined_loses_nothing_of_the_others(monkeypatch):
    keys = ("boom.damping", "stick.damping")

    def refined(_machine, session, known, progress, _stated):
        progress()
        if session.name == "damping_boom":
            raise SessionError("damping_boom: no sensor moves")
        found = GaussianEstimate(keys[1:], np.log([3e4]), np.array([[0.01]]))
        done = fitted({keys[1]: 3e4}, {keys[1]: 3e3}, known.taken(found, keys[1:]))
        return Task(free=keys[1:], carried=(), channels=()), done

    said = []
    monkeypatch.setattr(refinement, "refine", refined)
    monkeypatch.setattr(identification.linear_estimates, "estimates", lambda *_: [])
    monkeypatch.setattr(identification.experiment_check, "demand", lambda *_: None)
    records = [
        dataclasses.replace(record(f"damping_{axis}"), whole=axis != "stick") for axis in ("boom", "stick")
    ]
    found = identify(C180, records, lambda text, share: said.append((text, round(share, 2))))
    assert found.failed == {"damping_boom": keys[:1]}
    assert "damping_boom: no sensor moves; its linear estimates stay" in found.remarks
    assert any(remark.startswith("damping_stick: the bag was cut off") for remark in found.remarks)
    assert list(found.estimates) == [keys[1]]
    assert found.machine.stick.damping == pytest.approx(3e4)
    assert found.machine.boom.damping == C180.boom.damping
    texts = [text for text, _ in said]
    assert texts[:2] == ["damping_boom: linear estimates", "damping_stick: linear estimates"]
    assert texts[2:] == [
        "damping_boom: refinement, simulation 1",
        "damping_stick: refinement, simulation 1",
        "done",
    ]
    shares = [share for _, share in said]
    assert shares[:2] == [0.0, 0.0]
    assert shares[-1] == 1.0
    assert 0.0 <= shares[2] < shares[3] < 1.0


def test_what_only_a_linear_estimator_found_is_taken_and_what_it_did_not_is_told():
    result = Result(C180, C180)

    def linear(key, value, **more):
        return Estimate(key, value, 0.01 * abs(value), "1", 3.0, "linear", **more)

    result.linear = [
        linear("boom.damping", 2e5),
        linear("stick.damping", -1.0),
        linear("hose.inertance", 3e7, initial=False),
        linear("swing.damping", 5e4),
    ]
    result.estimates["swing.damping"] = linear("swing.damping", 6e4)
    identification._conclude(result)
    assert {key: e.value for key, e in result.estimates.items()} == {
        "swing.damping": 6e4,
        "boom.damping": 2e5,
    }
    (remark,) = result.remarks
    assert remark.startswith("the records hold nothing of stick.damping; it takes the axis at several")
