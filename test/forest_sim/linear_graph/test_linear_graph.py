"""Claims about circuits as data: what makes no circuit is refused by name."""

import pytest

from forest_sim.linear_graph.linear_graph import Branch, Domain, GraphError, Kind, LinearGraph

SOURCE = Branch("P_s", Kind.ACROSS_SOURCE, "supply", "tank", "P_s")
RESISTANCE = Branch("R", Kind.D_TYPE, "supply", "port", "R")
CAPACITANCE = Branch("C", Kind.A_TYPE, "port", "tank", "C")
MODULATED = (
    Branch("1", Kind.GYRATOR, "port", "tank", "D", partner="2", modulated=True),
    Branch("2", Kind.GYRATOR, "shaft", "frame", "D", Domain.ROTATION, "1", modulated=True),
)
MOTOR_1 = Branch("1", Kind.GYRATOR, "port", "tank", "D", partner="2")
MOTOR_2 = Branch("2", Kind.GYRATOR, "shaft", "frame", "D", Domain.ROTATION, "1")


def graph(*branches):
    return LinearGraph("test", branches)


def test_a_circuit_keeps_its_branches_in_order():
    g = graph(SOURCE, RESISTANCE, CAPACITANCE, MOTOR_1, MOTOR_2)
    assert [branch.name for branch in g.branches] == ["P_s", "R", "C", "1", "2"]
    assert g.of(Kind.A_TYPE, Kind.ACROSS_SOURCE) == (SOURCE, CAPACITANCE)
    assert g.pairs() == ((MOTOR_1, MOTOR_2),)
    assert g.domains == (Domain.HYDRAULIC, Domain.ROTATION)
    assert (Domain.HYDRAULIC.across, Domain.TRANSLATION.through) == ("P", "F")


@pytest.mark.parametrize(
    ("branches", "told"),
    [
        ([SOURCE, RESISTANCE, CAPACITANCE, CAPACITANCE], "more than one branch is called C"),
        ([SOURCE, Branch("R", Kind.D_TYPE, "tank", "tank", "R")], "R begins and ends at node tank"),
        ([SOURCE, Branch("R", Kind.D_TYPE, "supply", "tank", "R", partner="C")], "R is no two-port"),
        ([SOURCE, RESISTANCE, CAPACITANCE, MOTOR_1], "gyrator branch 1 needs a partner.*not 2"),
        (
            [SOURCE, RESISTANCE, CAPACITANCE, MOTOR_1, Branch("2", Kind.GYRATOR, "a", "b", "N", partner="1")],
            "gyrator branch 1 needs a partner of the same kind and parameter",
        ),
        ([SOURCE, RESISTANCE, CAPACITANCE, MODULATED[0], MOTOR_2], "1 needs a partner of the same kind"),
        (
            [SOURCE, Branch("R", Kind.D_TYPE, "supply", "port", "R", modulated=True), CAPACITANCE],
            "R cannot take an input as parameter; allowed: two-ports",
        ),
        (
            [SOURCE, Branch("R", Kind.D_TYPE, "supply", "port", "D"), CAPACITANCE, *MODULATED],
            "R cannot take an input as parameter",
        ),
        ([SOURCE, CAPACITANCE, Branch("I", Kind.T_TYPE, "a", "b", "I")], "no path leads from P_s to I"),
        (
            [SOURCE, Branch("B", Kind.D_TYPE, "supply", "frame", "B", Domain.ROTATION)],
            "node supply lies in the hydraulic domain, B takes it into the rotation domain",
        ),
    ],
)
def test_what_is_no_circuit_is_refused_by_name(branches, told):
    with pytest.raises(GraphError, match=told):
        graph(*branches)


def test_a_changed_circuit_has_the_new_branches_in_the_place_of_the_old():
    two = (
        Branch("R_a", Kind.D_TYPE, "supply", "middle", "R_a"),
        Branch("R_b", Kind.D_TYPE, "middle", "port", "R_b"),
    )
    changed = graph(SOURCE, RESISTANCE, CAPACITANCE).changed("two", remove=["R"], add=two)
    assert [branch.name for branch in changed.branches] == ["P_s", "R_a", "R_b", "C"]
    assert changed.name == "two"


def test_only_branches_that_are_there_can_be_removed():
    with pytest.raises(GraphError, match="test has no branch L, X to remove"):
        graph(SOURCE, RESISTANCE, CAPACITANCE).changed("other", remove=["X", "R", "L"])
