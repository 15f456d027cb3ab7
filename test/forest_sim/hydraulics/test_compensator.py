"""Claims about a compensator's balance: against roots of its force balance, written out anew."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from forest_sim.hydraulics.compensator import (
    AFTER,
    BEFORE,
    LEAST,
    Compensator,
    balance,
    in_series,
    opening_after,
)

SETTING, RANGE, RESISTANCE = 1e6, 4e5, 5e10
KINDS = [pytest.param(sort, id=name) for sort, name in ((BEFORE, "before"), (AFTER, "after"))]


def made(sort):
    return Compensator(sort, SETTING, RANGE, RESISTANCE, 0.015)


def imbalance(x, drop, edge, aim):
    """Spring and edge against each other at an opening, from the flow through both resistances [Pa]."""
    flow = math.copysign(math.sqrt(abs(drop) / (edge + RESISTANCE / x**2)), drop)
    return RANGE * x + edge * flow * abs(flow) - aim


@pytest.mark.parametrize("sort", KINDS)
def test_the_opening_is_where_spring_and_pressures_balance(sort):
    rng, inside = np.random.default_rng(1), 0
    for _ in range(300):
        drop, edge = 10.0 ** rng.uniform(5, 7.4), 10.0 ** rng.uniform(10.5, 15)
        supply, greatest = rng.uniform(5e6, 24e6), rng.uniform(0.0, 24e6)
        aim = SETTING if sort == BEFORE else supply - greatest - SETTING
        found = balance(drop, edge, supply, greatest, made(sort))
        if aim <= imbalance(1e-9, drop, edge, 0.0):
            assert found == pytest.approx(0.0, abs=1e-6)
        elif imbalance(1.0, drop, edge, aim) <= 0.0:
            assert found == 1.0
        else:
            inside += 1
            assert found == pytest.approx(brentq(imbalance, 1e-9, 1.0, (drop, edge, aim)), rel=1e-6)
    assert inside > 30


def test_before_the_spool_a_flow_does_not_ask_what_its_load_is():
    edge = 4e11
    flows = []
    for drop in np.linspace(2e6, 2e7, 10):
        x = balance(drop, edge, 0.0, 0.0, made(BEFORE))
        flows.append(math.sqrt(drop / (edge + in_series(x, made(BEFORE)))))
    least = math.sqrt((SETTING - RANGE) / edge)
    assert least < min(flows) <= max(flows) < math.sqrt(SETTING / edge)
    assert max(flows) / min(flows) < 1.1  # without: a factor of 3.2


def test_behind_the_spool_all_edges_share_one_drop():
    """Flows are as the openings, whatever each load and however little the pump leaves."""
    supply, edges, loads = 15e6, (4e11, 1.6e12, 9e11), (12.5e6, 3e6, 0.5e6)
    ratios = []
    for edge, load in zip(edges, loads, strict=True):
        x = balance(supply - load, edge, supply, max(loads), made(AFTER))
        ratios.append(math.sqrt(edge) * math.sqrt((supply - load) / (edge + in_series(x, made(AFTER)))))
    assert max(ratios) / min(ratios) < 1.12  # what its range of 4 bar of 15 leaves; without: 2.4


def test_a_shut_spool_shuts_it_up_to_its_clearance():
    for sort in (BEFORE, AFTER):
        assert balance(15e6, math.inf, 15e6, 14.5e6, made(sort)) == 0.0
    assert in_series(0.0, made(BEFORE)) == RESISTANCE / LEAST**2


def test_it_follows_its_balance_as_a_lag_does():
    c, x = made(BEFORE), 0.1
    for _ in range(15):
        x = opening_after(x, 0.7, 1e-3, c)
    assert x == pytest.approx(0.7 - 0.6 * math.exp(-1.0), rel=1e-12)
