"""Two quadratic elements that share a flow: the closed form, and an underlapped valve's port."""

import numpy as np
import pytest

from forest_sim.hydraulics.port import Port, port_pressure
from forest_sim.linear_graph.actuation_graphs import cylinder_with_underlap
from forest_sim.linear_graph.linear_graph import Branch, Kind, LinearGraph
from forest_sim.linear_graph.quadratic import shunt_flow
from forest_sim.linear_graph.state_equations import state_equations

UNDERLAPPED = state_equations(cylinder_with_underlap())


def test_the_closed_form_fulfils_its_equation():
    """Over twelve decades of either resistance, both directions, and at its corners."""
    rng = np.random.default_rng(4)
    for _ in range(5000):
        series, shunt = 10.0 ** rng.uniform(4.0, 16.0, 2)
        flow, drop = rng.normal(0.0, 1e-3), rng.normal(0.0, 1e7) * rng.choice((0.0, 1e-6, 1.0))
        for q, d in ((flow, drop), (0.0, drop), (flow, 0.0), (flow, series * flow * abs(flow))):
            z = shunt_flow(q, d, series, shunt)
            terms = np.array([series * (q + z) * abs(q + z), shunt * z * abs(z), -d])
            slope = 2.0 * (series * abs(q + z) + shunt * abs(z))
            assert abs(terms.sum()) <= 1e-14 * (np.abs(terms).sum() + slope * (abs(q) + abs(z)))


def test_equal_edges_and_no_flow_are_no_trouble():
    assert shunt_flow(0.0, 0.0, 1e12, 1e12) == 0.0
    assert shunt_flow(0.0, 2e12, 1e12, 1e12) == pytest.approx(1.0)
    assert shunt_flow(1.0, 0.0, 1e12, 1e12) == pytest.approx(-0.5)


def random_states(count):
    """Yield pressures and flows of both hoses, the four edges and the supply."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        pressures, flows = rng.uniform(0.0, 3e7, 2), rng.normal(0.0, 2e-3, 2)
        yield pressures, flows, 10.0 ** rng.uniform(11.0, 16.0, 4), rng.uniform(1e7, 3e7)


def test_an_underlapped_valves_ports_are_those_of_the_simulator():
    """The graph's port pressures against the simulator's Newton, with the flow both ways."""
    hoses = {f"{letter}_{port}": 1.0 for letter in "RIC" for port in (1, 2)}
    others = hoses | {"gy_1": 2e-2, "gy_2": 1e-2, "B": 1e5}
    ports = UNDERLAPPED.function(UNDERLAPPED.across["C_T1"], UNDERLAPPED.across["C_R'"])
    outside = 0
    for pressures, flows, (c_r, c_t1, c_s2, c_back), supply in random_states(1000):
        edges = {"C_R": c_r, "C_T1": c_t1, "C_S2": c_s2, "C_R'": c_back}
        derived = ports([*pressures, *flows], [supply, 0.0], others | edges)
        coded = (
            port_pressure(pressures[0], flows[0], Port(c_r, c_t1, 0.0), supply),
            port_pressure(pressures[1], -flows[1], Port(c_s2, c_back, 0.0), supply),
        )
        reach = supply + max(map(abs, coded))
        np.testing.assert_allclose(derived, coded, rtol=0.0, atol=1e-9 * reach)
        outside += not 0.0 <= coded[0] <= supply
    assert 100 < outside < 900


def test_a_pair_may_stand_either_way_round():
    """The arrow and the order of the two orifices change signs only."""
    edges = [Branch("a", Kind.QUADRATIC, "supply", "p", "a"), Branch("b", Kind.QUADRATIC, "p", "tank", "b")]
    rest = (
        Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s"),
        Branch("I", Kind.T_TYPE, "p", "c", "I"),
        Branch("C", Kind.A_TYPE, "c", "tank", "C"),
    )
    turned = [Branch(b.name, b.kind, b.end, b.start, b.parameter) for b in edges]
    given = ([2e6, 3e-4], [1e7], {"a": 3e12, "b": 5e13, "I": 1e7, "C": 1e-12})
    graphs = [LinearGraph("test", (*rest, *pair)) for pair in (edges, edges[::-1], turned)]
    first, *others = (state_equations(graph).function()(*given) for graph in graphs)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-12)
