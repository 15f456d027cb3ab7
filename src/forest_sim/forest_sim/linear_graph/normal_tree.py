"""The normal tree of a linear graph, and with it the independent energy storages: the states.

The classical rule: a tree is filled in the order across sources, A-type storages, two-ports,
D-types, T-type storages; through sources stay outside. Of a transformer exactly one branch is in
the tree, of a gyrator both or none, and among these choices the one is taken that leaves most
A-types inside and most T-types outside. An A-type that finds no place in the tree, or a T-type that
is needed to complete it, depends on the others: it has no state of its own (`merging`).

What is outside is a link. A link closes one loop of tree branches (compatibility: its across
variable is the sum along the path), and cutting a tree branch leaves one set of links to cross
(continuity). The tree of a graph with several domains is one tree per domain.

| symbol | name |
|---|---|
| a, f | across, through variable of a branch |
| s_lb | +1, -1: link l's loop runs along, against tree branch b |
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

from forest_sim.linear_graph.linear_graph import Branch, GraphError, Kind, LinearGraph, component

STORAGES = (Kind.A_TYPE, Kind.T_TYPE)


@dataclass(frozen=True)
class NormalTree:
    """A graph's branches, parted into tree and links, with the signs s_lb of every link's loop."""

    graph: LinearGraph
    tree: tuple[Branch, ...]
    links: tuple[Branch, ...]
    loops: dict[str, dict[str, int]]

    @property
    def storages(self) -> tuple[Branch, ...]:
        """Return the storages with a state of their own: A-types in the tree, then T-types in the links."""
        dependent = self.dependent
        return tuple(b for k in STORAGES for b in self.graph.of(k) if b not in dependent)

    @property
    def dependent(self) -> tuple[Branch, ...]:
        """Return the storages whose variable the tree's others determine."""
        return tuple(_dependent(self.graph, self.tree))

    def compatibility(self) -> dict[str, dict[str, int]]:
        """Return for every link the tree branches that add up to its across variable.

        a_l = sum over b of s_lb a_b. Thesis eq. 3.6, 3.12.
        """
        return self.loops

    def continuity(self) -> dict[str, dict[str, int]]:
        """Return for every tree branch the links that add up to its through variable.

        f_b = - sum over l of s_lb f_l, from the same signs, because no circuit makes power
        (Tellegen). Thesis eq. 3.5, 3.11.
        """
        return {
            b.name: {link: -signs[b.name] for link, signs in self.loops.items() if b.name in signs}
            for b in self.tree
        }


def normal_tree(graph: LinearGraph) -> NormalTree:
    """Return the normal tree. Thesis section 3.3, 3.4: so its states are chosen, without saying so.

    Raises:
        GraphError: a loop of across sources, a cut-set of through sources, or two-ports that leave
            no choice.
    """
    _check_sources(graph)
    candidates = [tree for chosen in _two_port_choices(graph) if (tree := _filled(graph, chosen)) is not None]
    if not candidates:
        names = ", ".join(f"{one.name}-{two.name} ({one.parameter})" for one, two in graph.pairs())
        raise GraphError(
            f"{graph.name}: no normal tree holds one branch of every transformer and both or none of every "
            f"gyrator; sources and two-ports {names} prescribe a variable twice"
        )
    # min() keeps the first of equals: the result depends on the order of the branches alone.
    best = min(candidates, key=lambda tree: len(_dependent(graph, tree)))
    inside = {branch.name for branch in best}
    links = tuple(branch for branch in graph.branches if branch.name not in inside)
    loops = {link.name: _path(link, best) for link in links}
    return NormalTree(graph, tuple(best), links, loops)


def _check_sources(graph: LinearGraph) -> None:
    entered: list[Branch] = []
    for source in graph.of(Kind.ACROSS_SOURCE):
        if source.end in component(source.start, entered):
            loop = [*_path(source, entered), source.name]
            raise GraphError(f"{graph.name}: {', '.join(loop)} are a loop of across sources")
        entered.append(source)
    others = [branch for branch in graph.branches if branch.kind is not Kind.THROUGH_SOURCE]
    for source in graph.of(Kind.THROUGH_SOURCE):
        side = component(source.start, others)
        if source.end not in side:
            cut = [s.name for s in graph.of(Kind.THROUGH_SOURCE) if (s.start in side) != (s.end in side)]
            raise GraphError(f"{graph.name}: {', '.join(cut)} are a cut-set of through sources")


def _two_port_choices(graph: LinearGraph) -> Iterator[list[Branch]]:
    """Yield the two-port branches in the tree, for every choice that the rule allows."""
    options: list[tuple[list[Branch], list[Branch]]] = []
    for one, two in graph.pairs():
        options.append(([one], [two]) if one.kind is Kind.TRANSFORMER else ([], [one, two]))
    for choice in product(*options):
        yield [branch for ports in choice for branch in ports]


def _filled(graph: LinearGraph, two_ports: list[Branch]) -> list[Branch] | None:
    """Return the tree around the chosen two-port branches, None if they close a loop or leave a gap."""
    sources = list(graph.of(Kind.ACROSS_SOURCE))
    tree: list[Branch] = []
    for branch in sources + two_ports:
        if branch.end in component(branch.start, tree):
            return None
        tree.append(branch)
    rest = (graph.of(Kind.A_TYPE), graph.of(Kind.D_TYPE, Kind.QUADRATIC), graph.of(Kind.T_TYPE))
    for branch in (branch for group in rest for branch in group):
        if branch.end not in component(branch.start, tree):
            tree.append(branch)
    nodes = {node for branch in graph.branches for node in (branch.start, branch.end)}
    return tree if len(tree) == len(nodes) - len(graph.domains) else None


def _dependent(graph: LinearGraph, tree: Iterable[Branch]) -> list[Branch]:
    """Return the storages without a state of their own: A-types outside the tree, T-types inside."""
    inside = {branch.name for branch in tree}
    return [b for b in graph.of(*STORAGES) if (b.kind is Kind.T_TYPE) == (b.name in inside)]


def _path(link: Branch, tree: Iterable[Branch]) -> dict[str, int]:
    """Return the tree branches on the way from the link's start to its end, +1 where along the arrow."""
    ways: dict[str, dict[str, int]] = {link.start: {}}
    edges = list(tree)
    while link.end not in ways:
        for branch in edges:
            if branch.start in ways and branch.end not in ways:
                ways[branch.end] = {**ways[branch.start], branch.name: 1}
            elif branch.end in ways and branch.start not in ways:
                ways[branch.start] = {**ways[branch.end], branch.name: -1}
    return ways[link.end]
