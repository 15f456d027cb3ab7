import csv
import json
import math

import numpy as np
import pytest
from recorded import recorded

from forest_compile.kernel_cache import can_compile
from forest_ident.actuator import fit, kernel, model, steps
from forest_ident.actuator import record as actuator_record
from forest_ident.actuator.fit import CENTRE, WIDTHS, Columns, Fit, Problem
from forest_ident.actuator.priors import PRIORS, actuator
from forest_ident.cli import actuator_command
from forest_ident.cli.verbs import main
from forest_ident.validation.prediction_error import rms

compiled = pytest.mark.skipif(not can_compile(), reason="llvmlite is not installed: a fit would take minutes")
PLACE = {prior.name: place for place, prior in enumerate(PRIORS)}


def signal_of_an_operator(count):
    """Return levels held for 40 samples each, with ramps between, both ways, as a lever gives them."""
    levels = (0.8, 0.15, -1.0, 0.0, 1.2, 0.0, -0.2, 1.0, -0.9, 0.0)
    held = np.concatenate([np.zeros(8), np.repeat(levels, 40)])
    return np.convolve(held, np.ones(8) / 8.0)[:count]


@pytest.fixture(scope="module")
def truth():
    return CENTRE + 0.25 * WIDTHS * np.random.default_rng(11).standard_normal(len(CENTRE))


@pytest.fixture(scope="module")
def record(truth):
    """All 400 samples: pressure and position of a known actuator with the sensors' noise."""
    signal, noise = signal_of_an_operator(400), np.random.default_rng(5).standard_normal((2, 400))
    pressure, position = fit.simulate(truth, signal)
    return Columns(signal, pressure + 0.02 * noise[0], position + 0.002 * noise[1])


@pytest.fixture(scope="module")
def fitted(record):
    problem = Problem(Columns(*(column[:260] for column in record)))
    return problem, fit.fit_from_many_starts(problem, 2)


@compiled
def test_compiled_and_interpreted_simulations_agree_to_the_last_bit(truth):
    given, signal = actuator(truth.tolist()), signal_of_an_operator(60)
    compiled_run = kernel.simulate(signal, given.dead_time, given.parameters)
    pressures, positions = np.zeros(60), np.zeros(60)
    at_substeps = kernel.delayed(signal, given.dead_time)
    kernel._interpreted(at_substeps, 60, given.parameters, pressures, positions)
    assert np.array_equal(compiled_run[0], pressures)
    assert np.array_equal(compiled_run[1], positions)
    assert np.ptp(pressures) > 0.5


def test_an_actuator_at_rest_stays_there():
    p = actuator(CENTRE.tolist()).parameters
    still = model.rate(model.at_rest(p), 0.0, p)
    assert all(value == 0.0 for value in still)


def test_edge_is_the_root_off_zero_and_odd():
    assert model.edge(2.0, 4.0) == pytest.approx(4.0, rel=1e-4)
    assert model.edge(2.0, -4.0) == -model.edge(2.0, 4.0)


def test_nothing_flows_back_through_the_load_check():
    p = actuator(CENTRE.tolist()).parameters
    loaded = model.at_rest(p)._replace(spool=1.0, supply=1.0, pressure_1=8.0)
    assert model.valve_flows(loaded, p).into_1 == 0.0


def test_oil_is_kept_with_the_valve_shut():
    """C_1 dP_1 = -v and C_2 dP_2 = a v: what the piston displaces is what the pressures store."""
    p = actuator(CENTRE.tolist()).parameters
    moving = model.at_rest(p)._replace(speed=0.01)
    by = model.rate(moving, 0.0, p)
    assert by.pressure_1 * p.capacitance_1 == pytest.approx(-0.01)
    assert by.pressure_2 * p.capacitance_2 == pytest.approx(p.area_ratio * 0.01)


def test_steps_converge(truth):
    given, signal = actuator(truth.tolist()), signal_of_an_operator(40)
    ends = []
    for substeps in (8, 16, 32):
        pressures, positions = np.zeros(40), np.zeros(40)
        at_substeps = kernel.delayed(signal, given.dead_time, substeps)
        steps.run(at_substeps.tolist(), 40, substeps, given.parameters, pressures, positions)
        ends.append(pressures)
    assert rms(ends[1] - ends[2]) < 0.6 * rms(ends[0] - ends[2]) < 0.05


@compiled
def test_a_known_actuator_is_foretold_over_samples_that_the_fit_did_not_see(record, fitted):
    _, fits = fitted
    foretold = fit.predicted(fit.similar(fits), record.signal)
    assert rms(record.pressure) > 0.5
    assert rms((foretold - record.pressure)[260:]) < 0.12 * rms(record.pressure[260:])


@compiled
def test_what_the_record_tells_is_found_within_its_interval(truth, fitted):
    problem, fits = fitted
    errors = fit.standard_errors(problem, fits[0])
    away = np.abs(fits[0].z - truth) / errors
    assert np.sum(errors < 0.5 * WIDTHS) >= 12
    assert np.mean(away < 1.96) > 0.8
    assert np.max(away) < 4.0
    for name in ("flow_limit_extend", "flow_limit_retract"):
        assert fits[0].z[PLACE[name]] == pytest.approx(truth[PLACE[name]], abs=0.02)


@compiled
def test_derivatives_do_not_depend_on_the_difference(record, truth):
    problem = Problem(Columns(*(column[:120] for column in record)))
    left = problem.weighted(truth)
    place = PLACE["arm_stiffness"]
    aside = truth.copy()
    aside[place] += 1e-3
    coarse = (problem.weighted(aside) - left) / 1e-3
    fine = fit.derivatives(problem.weighted, truth, left)[:, place]
    assert rms(fine - coarse) < 0.02 * rms(fine)


def test_memory_of_white_noise_is_one_sample_and_of_a_moving_mean_is_its_length():
    white = np.random.default_rng(1).standard_normal(4000)
    assert fit.correlation_length(white) == pytest.approx(1.0, abs=0.3)
    assert fit.correlation_length(np.convolve(white, np.ones(10))) == pytest.approx(10.0, rel=0.4)


def test_fits_far_from_the_best_do_not_count_in_the_mean():
    fits = [Fit(CENTRE, cost, 1) for cost in (10.0, 12.0, 14.0)]
    assert len(fit.similar(fits)) == 2


def test_a_fit_that_runs_away_does_not_spoil_the_mean():
    wild = CENTRE.copy()
    wild[PLACE["mass"]] = -30.0
    signal = signal_of_an_operator(30)
    sound, mad = (Fit(z, 1.0, 1) for z in (CENTRE, wild))
    assert np.max(np.abs(fit.simulate(wild, signal)[0])) == kernel.BEYOND
    together = fit.predicted([sound, mad], signal)
    assert np.array_equal(together, fit.simulate(CENTRE, signal)[0])


@pytest.mark.parametrize(
    ("first", "lead", "said"),
    [
        (100, 100, "carried on"),  # TEST follows TRAIN
        (60, 60, "carried on"),  # TEST begins within TRAIN
        (0, 0, "at rest"),  # both halves in one file
        (101, 0, "at rest"),  # a sample is missing between them
    ],
)
def test_the_state_is_carried_on_only_if_train_leads_up_to_test(first, lead, said, tmp_path):
    none = None, None
    train = actuator_record.Record(tmp_path, np.arange(100), np.arange(100.0), *none)
    test = actuator_record.Record(tmp_path, np.arange(first, first + 5), np.zeros(5), *none)
    signal, how = actuator_command.before(train, test)
    assert np.array_equal(signal, np.arange(float(lead)))
    assert said in how


def write(path, record, rows, first=0, pressure=True):
    """Write a record as a file whose valve is the other way round and in other units."""
    names = ["sample", "valve", "pressure", "position"] if pressure else ["sample", "valve"]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for i in rows:
            row = [first + i, -10.0 * record.signal[i], 3.0 + 50.0 * record.pressure[i]]
            writer.writerow([*row, 7.0 + 0.2 * record.position[i]][: len(names)])
    return path


@compiled
def test_the_command_writes_a_prediction_with_state_carried_on(record, tmp_path, capsys):
    train = write(tmp_path / "train.csv", record, range(260), first=1000)
    test = write(tmp_path / "test.csv", record, range(260, 400), first=1000)
    blind = write(tmp_path / "blind.csv", record, range(260, 400), first=1000, pressure=False)
    found = []
    for name, file in (("out", test), ("blind_out", blind)):
        out = tmp_path / name
        arguments = ["--fit", str(train), "--simulate", str(file), "--out", str(out), "--starts", "1"]
        assert main(["actuator", *arguments]) == 0
        found.append(((out / "prediction.csv").read_text(), json.loads((out / "actuator.json").read_text())))
    assert found[0][0] == found[1][0], "pressures of TEST may not be used"
    rows = list(csv.DictReader(found[0][0].splitlines()))
    assert [int(row["sample"]) for row in rows] == list(range(1260, 1400))
    told = found[0][1]
    assert told["rms_test"] < 0.15 * 50.0 * rms(record.pressure[260:])
    assert found[1][1]["rms_test"] is None
    assert told["scales"]["valve"] < 0.0
    limit = told["parameters"]["flow_limit_extend"]
    assert limit["interval_95"][0] < limit["value"] < limit["interval_95"][1]
    assert limit["unit"] == "position sample^-1"
    assert "start 1 of 1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("sample,valve,pressure\n0,1,2\n", "line 1: column 'position' is missing"),
        ("sample,valve,pressure,position\n0,1,x,3\n", "line 2, column 'pressure': 'x' is no finite number"),
        (
            "sample,valve,pressure,position\n0,1,2,3\n2,1,2,3\n",
            "line 3, column 'sample': 2 does not follow 0",
        ),
        ("sample,valve,pressure,position\n0,nan,2,3\n", "line 2, column 'valve': 'nan' is no finite number"),
        ("sample,valve,pressure,position\n0,1\n", "line 2: ends before column 'pressure'"),
        ("sample,valve,pressure,position\n", "has a head but no samples"),
        ("", "line 1: column 'sample' is missing"),
        (
            "sample;valve;pressure;position\n0;1;2;3\n",
            "allowed: a head with sample, valve, pressure, position,",
        ),
        (
            "sample,valve,valve,pressure,position\n0,1,1,2,3\n",
            "'valve' stands there twice; allowed: each once",
        ),
        ("sample,valve,pressure,position\n0,1,2,3\n", "has 1 samples; a fit needs at least 60"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_sentence(text, sentence, tmp_path, capsys):
    path = tmp_path / "train.csv"
    path.write_text(text)
    out = tmp_path / "out"
    assert main(["actuator", "--fit", str(path), "--simulate", str(path), "--out", str(out)]) == 1
    assert sentence in capsys.readouterr().err
    assert not out.exists()


def test_a_column_that_stands_still_is_refused(tmp_path):
    record = actuator_record.Record(tmp_path, np.arange(80), np.zeros(80), np.arange(80.0), np.arange(80.0))
    with pytest.raises(actuator_record.RecordError, match="'valve': does not change"):
        actuator_record.scales(record)


@compiled
def test_half_of_the_real_crane_foretells_the_rest_of_it():
    whole = actuator_record.read(recorded("hydraulic_crane_first_half.csv"))
    s = actuator_record.scales(whole)
    columns = Columns(
        whole.valve / s.valve,
        (whole.pressure - s.pressure_zero) / s.pressure,
        (whole.position - s.position_zero) / s.position,
    )
    fits = fit.fit_from_many_starts(Problem(columns, np.arange(512) < 430), 4)
    foretold = fit.predicted(fit.similar(fits), columns.signal)
    assert math.isfinite(rms(foretold))
    assert rms((foretold - columns.pressure)[430:]) < 0.35
