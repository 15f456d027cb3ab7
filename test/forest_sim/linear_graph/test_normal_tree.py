"""The normal tree: the classical rule, and the circuits that have none."""

import pytest

from forest_sim.linear_graph.actuation_graphs import cylinder, swing
from forest_sim.linear_graph.layouts import CIRCUITS
from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, Kind, LinearGraph
from forest_sim.linear_graph.normal_tree import normal_tree

TURNING = Domain.ROTATION
PUMP = Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s")
ALL = pytest.mark.parametrize("circuit", CIRCUITS, ids=lambda c: c.file)


def element(name, kind, start, end, domain=Domain.HYDRAULIC):
    return Branch(name, kind, start, end, name, domain)


def gear(ratio, one, two, names=("3", "4")):
    return (
        Branch(names[0], Kind.TRANSFORMER, one, "frame", ratio, TURNING, names[1]),
        Branch(names[1], Kind.TRANSFORMER, two, "frame", ratio, TURNING, names[0]),
    )


def tree_of(*branches):
    return {branch.name for branch in normal_tree(LinearGraph("test", branches)).tree}


def test_the_swings_tree_is_that_of_the_thesis():
    """3.4 gives P of C_R, R_in, R_2, C_R' from Q, and Q of R_1, R_e1, R_e2 from P."""
    tree = {branch.name for branch in normal_tree(swing()).tree}
    assert tree == {"P_s", "qdot_sw", "C_1", "C_2", "3", "C_R", "R_in", "R_2", "C_R'"}


def test_the_cylinders_tree_is_that_of_the_thesis():
    tree = {branch.name for branch in normal_tree(cylinder()).tree}
    assert tree == {"P_s", "xdot", "C_1", "C_2", "C_R", "R_1", "R_2", "C_R'"}


@ALL
def test_every_tree_obeys_the_rule(circuit):
    graph = circuit.graph()
    tree = normal_tree(graph)
    inside = {branch.name for branch in tree.tree}
    nodes = {node for branch in graph.branches for node in (branch.start, branch.end)}
    assert len(inside) == len(nodes) - len(graph.domains)
    assert inside | {branch.name for branch in tree.links} == {branch.name for branch in graph.branches}
    for branch in graph.of(Kind.ACROSS_SOURCE, Kind.A_TYPE):
        assert branch.name in inside
    for branch in graph.of(Kind.T_TYPE):
        assert branch.name not in inside
    for one, two in graph.pairs():
        count = (one.name in inside) + (two.name in inside)
        assert count == 1 if one.kind is Kind.TRANSFORMER else count in (0, 2)


@ALL
def test_loops_close_and_cut_sets_hold_what_they_must(circuit):
    """Compatibility against node potentials, continuity against the sums at every node."""
    graph = circuit.graph()
    tree = normal_tree(graph)
    nodes = sorted({node for branch in graph.branches for node in (branch.start, branch.end)})
    potential = {node: 3.0**k for k, node in enumerate(nodes)}
    drop = {b.name: potential[b.start] - potential[b.end] for b in graph.branches}
    for link, signs in tree.compatibility().items():
        assert drop[link] == pytest.approx(sum(s * drop[name] for name, s in signs.items()))
    flow = {branch.name: 2.0**k for k, branch in enumerate(tree.links)}
    flow |= {
        name: sum(s * flow[link] for link, s in signs.items()) for name, signs in tree.continuity().items()
    }
    for node in nodes:
        total = sum(flow[b.name] * ((b.start == node) - (b.end == node)) for b in graph.branches)
        assert total == pytest.approx(0.0, abs=1e-9)


def test_of_a_gyrator_both_branches_enter_when_that_frees_a_storage():
    """A flow source drives a motor, whose shaft turns an inertia: both or none, and none leaves a gap."""
    motor = (
        Branch("1", Kind.GYRATOR, "port", "tank", "D", partner="2"),
        Branch("2", Kind.GYRATOR, "shaft", "frame", "D", TURNING, "1"),
    )
    pump = Branch("Q_s", Kind.THROUGH_SOURCE, "tank", "port", "Q_s")
    spring = element("k", Kind.T_TYPE, "shaft", "frame", TURNING)
    assert tree_of(pump, *motor, spring) == {"1", "2"}


def test_of_a_transformer_the_branch_enters_that_leaves_the_inertia_its_state():
    for driven, turned, port in (("motor", "joint", "3"), ("joint", "motor", "4")):
        torque = Branch("t_s", Kind.THROUGH_SOURCE, "frame", driven, "t_s", TURNING)
        wheel = element("J", Kind.A_TYPE, turned, "frame", TURNING)
        damper = element("B", Kind.D_TYPE, driven, "frame", TURNING)
        assert tree_of(torque, *gear("N", "motor", "joint"), damper, wheel) == {"J", port}


@pytest.mark.parametrize(
    ("branches", "told"),
    [
        (
            [
                PUMP,
                Branch("P_a", Kind.ACROSS_SOURCE, "supply", "port", "P_a"),
                Branch("P_b", Kind.ACROSS_SOURCE, "tank", "port", "P_b"),
                element("R", Kind.D_TYPE, "port", "tank"),
            ],
            "P_s, P_a, P_b are a loop of across sources",
        ),
        (
            [
                Branch("Q_a", Kind.THROUGH_SOURCE, "tank", "a", "Q_a"),
                element("C", Kind.A_TYPE, "a", "b"),
                Branch("Q_b", Kind.THROUGH_SOURCE, "b", "tank", "Q_b"),
                element("R", Kind.D_TYPE, "tank", "c"),
            ],
            "Q_a, Q_b are a cut-set of through sources",
        ),
        (
            [
                Branch("w_a", Kind.ACROSS_SOURCE, "motor", "frame", "w_a", TURNING),
                *gear("N", "motor", "joint"),
                Branch("w_b", Kind.ACROSS_SOURCE, "joint", "frame", "w_b", TURNING),
            ],
            r"two-ports 3-4 \(N\) prescribe a variable twice",
        ),
    ],
)
def test_circuits_without_a_normal_tree_are_refused_by_element(branches, told):
    with pytest.raises(GraphError, match=told):
        normal_tree(LinearGraph("test", tuple(branches)))


def test_storages_that_depend_on_others_are_told():
    wheels = (
        element("J_a", Kind.A_TYPE, "motor", "frame", TURNING),
        element("J_b", Kind.A_TYPE, "joint", "frame", TURNING),
    )
    tree = normal_tree(LinearGraph("test", (wheels[0], *gear("N", "motor", "joint"), wheels[1])))
    assert (tree.dependent, tree.storages) == (wheels[:1], wheels[1:])
    stiff = normal_tree(cylinder().changed("stiff hose", remove=["C_1"]))
    assert [branch.name for branch in stiff.dependent] == ["I_1"]
    assert [branch.name for branch in stiff.storages] == ["C_2", "I_2"]
