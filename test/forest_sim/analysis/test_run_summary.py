"""Claims about what a run is told to be worth."""

import copy

import pytest

from forest_sim.analysis.run_summary import run_warnings
from forest_sim.simulation.energy_account import Account
from forest_sim.solver.integrator import Events

SOUND = {
    "step_s": 1e-3,
    "energy_j": {
        **dict.fromkeys(Account._fields, 0.0),
        "engine": 1e5,
        "throttling": 1e5,
        "unaccounted": 100.0,
    },
    "events": dict.fromkeys(Events._fields, 0),
    "beyond_joint_limit_deg": {"swing": 0.0, "boom": 0.4, "stick": 0.0},
}


def test_a_sound_run_leaves_no_doubt():
    assert run_warnings(SOUND) == []


@pytest.mark.parametrize(
    ("part", "key", "value", "said"),
    [
        ("energy_j", "unaccounted", -2.6e6, "are unaccounted for"),
        ("events", "unconverged_stages", 3, "3 stages of the integrator did not converge"),
        ("beyond_joint_limit_deg", "boom", 89.0, "the boom went 89.0 deg beyond its limits"),
    ],
)
def test_what_cannot_be_believed_is_told(part, key, value, said):
    result = copy.deepcopy(SOUND)
    result[part][key] = value
    (sentence,) = run_warnings(result)
    assert said in sentence
