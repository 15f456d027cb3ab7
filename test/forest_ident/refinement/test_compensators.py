"""What records tell of pressure compensators, before the spool and behind it."""

import dataclasses

import pytest

from forest_description.hydraulics.compensator_parameters import CompensatorBeforeSpool
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.parameter_path import value_of, with_part, with_values
from forest_ident.refinement.extension_keys import COMPENSATOR
from forest_ident.refinement.identification import identify
from forest_ident.refinement.refinement_task import task
from forest_ident.refinement.result import Result, unidentified

WRONG = dict(zip(COMPENSATOR, (1.3, 0.75, 1.25, 0.8), strict=True))
"""The crane's numbers over those of the start."""


def crane(kind):
    plain, donor = load_machine("c180_hoses"), load_machine("forwarder")
    own = {field.name: getattr(plain.pump, field.name) for field in dataclasses.fields(plain.pump)}
    pump = LoadSensingPump(**own, margin=donor.pump.margin, response_time=donor.pump.response_time)
    behind = donor.valve.compensator
    before = CompensatorBeforeSpool(8e5, 3e5, behind.minimum_resistance, behind.response_time)
    made = dataclasses.replace(plain, pump=pump)
    return with_part(made, "valve.compensator", before if kind == "before_spool" else behind)


def drawn(start, factors):
    return with_values(start, {f"valve.{k}": f * value_of(start, f"valve.{k}") for k, f in factors.items()})


@pytest.mark.parametrize("kind", ["before_spool", "after_spool"])
def test_a_load_that_takes_the_pump_s_pressure_tells_a_compensator_s_four_numbers(kind):
    start = crane(kind)
    truth = drawn(start, WRONG)
    found = identify(start, [experiment("compensator", truth, seed=1)]).estimates
    for name in COMPENSATOR:
        e, true = found[f"valve.{name}"], value_of(truth, f"valve.{name}")
        assert abs(e.value - true) < 3.0 * e.standard_error, name
        assert e.standard_error < 0.02 * true, name
        assert not e.warning


def test_the_valve_s_rig_tells_a_setting_and_says_what_it_cannot_tell():
    """A compensator 35 % off in silence put C_R 47 % off."""
    start = crane("before_spool")
    truth = drawn(start, {"compensator.setting": 0.65, "minimum_resistance": 0.8})
    found = identify(start, [experiment("valve", truth, seed=1)]).estimates
    for key in ("valve.compensator.setting", "valve.minimum_resistance"):
        e, true = found[key], value_of(truth, key)
        assert abs(e.value - true) < 3.0 * e.standard_error, key
        assert e.standard_error < 0.02 * true, key
    untold = found["valve.compensator.minimum_resistance"]
    assert "cannot tell" in untold.warning
    assert "all of the pump's pressure" in untold.warning


def test_only_valves_with_a_compensator_get_its_experiment():
    assert not [name for name in experiment_plan.names(load_machine("loader")) if "compensator" in name]
    names = experiment_plan.names(load_machine("forwarder"))
    assert [name for name in names if "compensator" in name] == [
        name.replace("valve", "compensator") for name in names if name.startswith("valve")
    ]


def test_without_such_a_record_the_motion_is_named():
    start = crane("after_spool")
    said = dict(unidentified(Result(start, start)))
    for name in COMPENSATOR:
        assert "all of the pump's pressure" in said[f"valve.{name}"]


@pytest.mark.parametrize("name", ["hose", "deadband_boom", "motor_external", "damping_stick"])
def test_a_compensator_goes_along_in_every_later_record(name):
    start = crane("after_spool")
    work = task(start, experiment(name, start, longest=3.0))
    assert {f"valve.{key}" for key in COMPENSATOR} <= set(work.carried)
