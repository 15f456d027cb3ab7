"""Each candidate is a machine that can be written, and that simulates otherwise than the crane without it."""

import pytest

from forest_description.machine import load_machine
from forest_ident.model_choice.candidates import CANDIDATES, NAMES

CRANES = ("c180_hoses", "loader", "forwarder")


@pytest.mark.parametrize("name", CRANES)
def test_every_candidate_can_be_added_to_every_crane(name):
    machine = load_machine(name)
    for candidate in CANDIDATES:
        richer = candidate.add(machine)
        assert candidate.add(richer) == richer, candidate.name


def test_a_crane_that_has_the_physics_stays_as_it_is():
    forwarder = load_machine("forwarder")
    same = {candidate.name for candidate in CANDIDATES if candidate.add(forwarder) == forwarder}
    assert same == set(NAMES) - {"curve"}


def test_a_plain_crane_is_changed_by_every_candidate():
    plain = load_machine("c180_hoses")
    assert all(candidate.add(plain) != plain for candidate in CANDIDATES)
