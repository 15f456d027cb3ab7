"""Symbols and laws in LaTeX."""

import pytest

from forest_sim.linear_graph.actuation_graphs import cylinder, swing
from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind
from forest_sim.linear_graph.notation import latex, law, symbol_names, two_port_laws
from forest_sim.linear_graph.symbols import across_symbol, through_symbol


@pytest.mark.parametrize(
    ("name", "text"),
    [("C_R'", "C_{R}'"), ("qdot_sw", r"\dot q_{sw}"), ("gy_1", r"\mathit{gy}_{1}"), ("B", "B")],
)
def test_symbols_are_set_as_in_the_thesis(name, text):
    assert latex(name) == text


def test_variables_carry_their_domains_letter_and_their_branchs_name():
    graph = swing()
    names = symbol_names(graph)
    assert names[through_symbol(graph.branch("C_R'"))] == "Q_{C_{R}'}"
    assert names[across_symbol(graph.branch("2"))] == "W_{2}"
    assert names[across_symbol(graph.branch("qdot_sw"))] == r"\dot q_{sw}"
    assert names[through_symbol(graph.branch("qdot_sw"))] == r"t_{\dot q_{sw}}"


def test_laws_are_those_of_3_4_and_3_10():
    graph = cylinder()
    names = symbol_names(graph)
    assert law(graph.branch("R_1"), names) == r"P_{R_{1}} = R_{1}\,Q_{R_{1}}\,\lvert Q_{R_{1}}\rvert"
    assert law(graph.branch("B"), names) == r"F_{B} = B\,V_{B}"
    assert law(graph.branch("C_1"), names) == r"C_{1}\,\tfrac{d}{dt}P_{C_{1}} = Q_{C_{1}}"
    assert law(graph.branch("xdot"), names) == "input"
    one, two = graph.pairs()[0]
    assert two_port_laws(one, two, names) == (
        r"Q_{1} = \mathit{gy}_{1}\,V_{2}",
        r"F_{2} = -\mathit{gy}_{1}\,P_{1}",
    )
    gear = swing().pairs()[1]
    assert two_port_laws(*gear, symbol_names(swing())) == (r"W_{3} = N\,W_{4}", r"t_{4} = -N\,t_{3}")


def test_a_spring_multiplies_and_an_inertance_divides():
    spring = Branch("k", Kind.T_TYPE, "a", "b", "k", Domain.TRANSLATION)
    inertance = Branch("I", Kind.T_TYPE, "a", "b", "I")
    names = {across_symbol(b): "a" for b in (spring, inertance)}
    names |= {through_symbol(b): "f" for b in (spring, inertance)}
    assert law(spring, names) == r"\tfrac{d}{dt}f = k\,a"
    assert law(inertance, names) == r"I\,\tfrac{d}{dt}f = a"
