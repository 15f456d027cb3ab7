"""Linear graphs: a circuit of lumped elements, in any energy domain, as data.

A branch goes from node to node. Along its arrow the across variable is the drop a = φ(start) -
φ(end), and the through variable f flows from start to end; for sources, too, so that a pump's own
flow counts negative while it delivers. `normal_tree` chooses the states, `state_equations` derives
their equations, `drawing` draws, `actuation_graphs` holds the thesis' circuits.

| domain | across variable a | through variable f | storage and loss |
|---|---|---|---|
| hydraulic | pressure P, Pa | flow Q, m^3/s | capacitance C, inertance I, resistance R |
| rotation | angular velocity W, rad/s | torque t, N m | inertia J, stiffness k, damping B |
| translation | velocity V, m/s | force F, N | mass m, stiffness k, damping B |

| kind | law, hydraulic | law, mechanical |
|---|---|---|
| A-type | C da/dt = f | J da/dt = f |
| T-type | I df/dt = a | df/dt = k a |
| D-type | a = R f | f = B a |
| quadratic D-type | a = R f abs(f) | f = B a abs(a) |

Two-ports are pairs of branches 1, 2 that take in as much power as they give: a transformer of ratio
n, a_1 = n a_2 and f_2 = -n f_1; a gyrator of ratio r, f_1 = r a_2 and f_2 = -r a_1. A modulated
two-port has an input as its ratio, such as a joint's lever arm, which goes with the angle.
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class GraphError(ValueError):
    """A circuit that cannot be: the message names the elements."""


class Domain(Enum):
    """An energy domain with the letters of its across and its through variable."""

    HYDRAULIC = ("P", "Q")
    ROTATION = ("W", "t")
    TRANSLATION = ("V", "F")

    @property
    def across(self) -> str:
        """Letter of the across variable."""
        return self.value[0]

    @property
    def through(self) -> str:
        """Letter of the through variable."""
        return self.value[1]


class Kind(Enum):
    """What a branch stands for."""

    ACROSS_SOURCE = "across source"
    THROUGH_SOURCE = "through source"
    A_TYPE = "A-type storage"
    T_TYPE = "T-type storage"
    D_TYPE = "D-type"
    QUADRATIC = "quadratic D-type"
    TRANSFORMER = "transformer"
    GYRATOR = "gyrator"


TWO_PORTS = (Kind.TRANSFORMER, Kind.GYRATOR)


@dataclass(frozen=True)
class Branch:
    """One element, or one port of a two-port.

    The parameter is the element's constant, or the input of a source; two branches with one
    parameter share it. Of a two-port both branches name each other as partner, and the one that is
    listed first is port 1. The parameter of a modulated two-port is an input, given over time.
    """

    name: str
    kind: Kind
    start: str
    end: str
    parameter: str
    domain: Domain = Domain.HYDRAULIC
    partner: str | None = None
    modulated: bool = False


@dataclass(frozen=True)
class LinearGraph:
    """A circuit. Nodes are what the branches name; every domain has one connected part."""

    name: str
    branches: tuple[Branch, ...]

    def __post_init__(self) -> None:
        """Check that the branches make a circuit at all."""
        counts = Counter(branch.name for branch in self.branches)
        if repeated := [name for name, count in counts.items() if count > 1]:
            raise GraphError(f"{self.name}: more than one branch is called {_listed(repeated)}")
        for branch in self.branches:
            self._check(branch)
        self._check_modulated()
        for domain in self.domains:
            self._check_connected(domain)

    @property
    def domains(self) -> tuple[Domain, ...]:
        """The domains in order of appearance."""
        return tuple(dict.fromkeys(branch.domain for branch in self.branches))

    def branch(self, name: str) -> Branch:
        """Return the branch of that name."""
        return next(branch for branch in self.branches if branch.name == name)

    def of(self, *kinds: Kind) -> tuple[Branch, ...]:
        """Return the branches of these kinds, in the graph's order."""
        return tuple(branch for branch in self.branches if branch.kind in kinds)

    def pairs(self) -> tuple[tuple[Branch, Branch], ...]:
        """Return port 1 and port 2 of every two-port."""
        ports = self.of(*TWO_PORTS)
        order = {branch.name: place for place, branch in enumerate(ports)}
        return tuple(
            (branch, self.branch(branch.partner))
            for branch in ports
            if branch.partner is not None and order[branch.name] < order[branch.partner]
        )

    def changed(self, name: str, remove: Iterable[str] = (), add: Iterable[Branch] = ()) -> "LinearGraph":
        """Return another circuit: without some branches, with others in the place of the first of them.

        Raises:
            GraphError: a branch to remove is not there, or what is left is no circuit.
        """
        gone = set(remove)
        if missing := gone - {branch.name for branch in self.branches}:
            raise GraphError(f"{self.name} has no branch {_listed(sorted(missing))} to remove")
        place = next((k for k, b in enumerate(self.branches) if b.name in gone), len(self.branches))
        left = [branch for branch in self.branches if branch.name not in gone]
        return LinearGraph(name, (*left[:place], *add, *left[place:]))

    def _check(self, branch: Branch) -> None:
        if branch.start == branch.end:
            raise GraphError(f"{self.name}: {branch.name} begins and ends at node {branch.start}")
        partners = [other for other in self.branches if other.name == branch.partner]
        if branch.kind not in TWO_PORTS:
            if branch.partner is not None:
                raise GraphError(f"{self.name}: {branch.name} is no two-port, it cannot have a partner")
        elif not any(
            (p.partner, p.kind, p.parameter, p.modulated)
            == (branch.name, branch.kind, branch.parameter, branch.modulated)
            for p in partners
        ):
            raise GraphError(
                f"{self.name}: {branch.kind.value} branch {branch.name} needs a partner of the same kind and "
                f"parameter that names it, not {branch.partner}"
            )

    def _check_modulated(self) -> None:
        """Check that what is an input is no constant elsewhere."""
        ratios = {branch.parameter for branch in self.branches if branch.modulated}
        constant = [b.name for b in self.branches if b.parameter in ratios and not b.modulated]
        constant += [b.name for b in self.branches if b.modulated and b.kind not in TWO_PORTS]
        if constant:
            raise GraphError(
                f"{self.name}: {_listed(constant)} cannot take an input as parameter; allowed: two-ports, "
                "both branches modulated"
            )

    def _check_connected(self, domain: Domain) -> None:
        branches = [branch for branch in self.branches if branch.domain is domain]
        nodes = {node for branch in branches for node in (branch.start, branch.end)}
        for other in self.branches:
            if other.domain is not domain and (strange := nodes & {other.start, other.end}):
                raise GraphError(
                    f"{self.name}: node {_listed(sorted(strange))} lies in the {domain.name.lower()} domain, "
                    f"{other.name} takes it into the {other.domain.name.lower()} domain"
                )
        reached = component(branches[0].start, branches)
        if lost := [branch.name for branch in branches if branch.start not in reached]:
            raise GraphError(
                f"{self.name} is not connected: no path leads from {branches[0].name} to {_listed(lost)}"
            )


def component(node: str, branches: Iterable[Branch]) -> set[str]:
    """Return the nodes that paths along these branches lead to, the node itself included."""
    reached, grown, edges = {node}, True, list(branches)
    while grown:
        ends = {end for b in edges if {b.start, b.end} & reached for end in (b.start, b.end)}
        grown = not ends <= reached
        reached |= ends
    return reached


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
