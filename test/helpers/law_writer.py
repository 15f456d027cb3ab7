"""Random laws in the subset of Python that `forest_compile` translates, as source.

Kinds of expressions: d double, w whole number, t truth, v tuple of three doubles, r `Row`. Nearly all that is
written is in the subset; what is not, such as a variable that a loop may have left without a value, is there
to be refused.
"""

import random

HEAD = """
import math
from typing import NamedTuple

SCALE, COUNT, TABLE = -0.75, 3, (0.5, -0.0, 2.5, -1.5)


class Row(NamedTuple):
    a: float
    b: float = -0.0
    n: int = 2


class Pair(NamedTuple):
    first: Row = Row(0.5, n=1)
    scale: float = SCALE


class Given(NamedTuple):
    x: float
    y: float
    n: int
    m: int
    on: bool
    v: tuple[float, float, float]
    rows: tuple[Row, Row]
"""
PARAMETERS = {"p.x": "d", "p.y": "d", "p.n": "w", "p.m": "w", "p.on": "t", "p.v": "v"}
CONSTANTS = {
    "d": ("0.0", "-0.0", "1.0", "0.5", "-1.5", "2.0", "1e-3", "3e7", "SCALE", "math.pi"),
    "w": ("0", "1", "2", "-1", "-3", "5", "COUNT"),
    "t": ("True", "False"),
    "v": ("(0.0, -0.0, 1.5)",),
    "r": ("Row(0.5)",),
}
RESULTS = "dwtvr"


class Writer:
    """Writes one module of laws."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.helpers: dict[str, tuple[str, int, str]] = {}  # kinds of arguments, required, kind of result
        self.known: dict[str, str] = {}  # variable to kind
        self.counters: set[str] = set()  # of loops under way
        self.count = 0

    def module(self) -> str:
        """Return the source; the law is `law(p)`, p a `Given`."""
        parts = [HEAD]
        for i in range(self.random.randint(1, 3)):
            kinds, result = self.random.choices("dwtvr", k=4), self.random.choice(RESULTS)
            required = self.random.randint(0, 4)
            parts.append(f"\n\ndef helper_{i}({self.parameters(kinds, required)}):")
            self.known = {f"a{k}": kind for k, kind in enumerate(kinds)}
            parts += [*self.body(result, 2), ""]
            self.helpers[f"helper_{i}"] = "".join(kinds), required, result
        self.known = dict(PARAMETERS)
        parts += ["\n\ndef law(p):", *self.statements(1, 5)]
        given = ", ".join(self.expression(kind, 2) for kind in "dwtvr")
        changed = [name for name in self.known if "." not in name]
        return "\n".join([*parts, f"    return ({', '.join([given, *changed])})", ""])

    def parameters(self, kinds: list[str], required: int) -> str:
        """Return parameters: `required` of them without default, the last one or two by keyword alone."""
        names = [f"a{k}" if k < required else f"a{k}={self.constant(kind)}" for k, kind in enumerate(kinds)]
        names.insert(self.random.randint(2, 3), "*")
        return ", ".join(names)

    def body(self, result: str, count: int) -> list[str]:
        """Return a function's statements."""
        return [*self.statements(1, count), f"    return {self.expression(result, 2)}"]

    def constant(self, kind: str) -> str:
        """Return a constant."""
        return self.random.choice(CONSTANTS[kind])

    def expression(self, kind: str, depth: int) -> str:
        """Return an expression of a kind."""
        names = [name for name, sort in self.known.items() if sort == kind]
        if depth == 0 or self.random.random() < 0.2:
            return self.random.choice(names) if names and self.random.random() < 0.8 else self.constant(kind)
        helpers = [name for name, (*_, result) in self.helpers.items() if result == kind]
        if helpers and self.random.random() < 0.2:
            return self.call(self.random.choice(helpers), depth - 1)
        if self.random.random() < 0.1:
            test, yes, no = (self.expression(sort, depth - 1) for sort in f"t{kind}{kind}")
            return f"({yes} if {test} else {no})"
        forms = FORMS[kind]
        form = self.random.choice(forms)
        pieces = form.split("$")
        return pieces[0] + "".join(self.expression(p[0], depth - 1) + p[1:] for p in pieces[1:])

    def call(self, name: str, depth: int) -> str:
        """Return a call of a helper: some arguments by place, others by keyword in any order, or left out."""
        kinds, required, _ = self.helpers[name]
        by_place = self.random.randint(0, 2)
        named = [k for k in range(by_place, len(kinds)) if k < required or self.random.random() < 0.5]
        self.random.shuffle(named)
        given = [self.expression(kind, depth) for kind in kinds[:by_place]]
        given += [f"a{k}={self.expression(kinds[k], depth)}" for k in named]
        return f"{name}({', '.join(given)})"

    def statements(self, depth: int, count: int) -> list[str]:
        """Return some statements, indented."""
        lines: list[str] = []
        for _ in range(count):
            lines += [f"    {line}" for line in self.statement(depth)]
        return lines

    def statement(self, depth: int) -> list[str]:
        """Return a statement."""
        sorts = ("set", "set", "add", "unpack", "if", "for", "while") if depth < 3 else ("set",)
        sort = self.random.choice(sorts)
        if sort == "if":
            return self.branches(depth)
        if sort in ("for", "while"):
            return self.loop(sort, depth)
        own = [name for name in self.variables() if self.known[name] in "dw"]
        if sort == "add" and own:
            name = self.random.choice(own)
            operator = self.random.choice(("+=", "-=", "*=", "%="))
            if self.known[name] == "w":
                return [f"{name} {operator} {self.expression('w', 1)}", f"{name} %= 11"]
            return [f"{name} {operator} {self.expression('d', 2)}"]
        if sort == "unpack":
            names = [self.new() for _ in range(3)]
            lines = [f"{', '.join(names)} = {self.expression('v', 2)}"]
            self.known |= dict.fromkeys(names, "d")
            return lines
        kind = self.random.choice(RESULTS)
        same = [name for name in self.variables() if self.known[name] == kind]
        name = self.random.choice(same) if same and self.random.random() < 0.5 else self.new()
        line = f"{name} = {self.expression(kind, 3)}"
        self.known[name] = kind
        return [line]

    def variables(self) -> list[str]:
        """Return the variables that may change."""
        return [name for name in self.known if "." not in name and name not in self.counters]

    def new(self) -> str:
        """Return a name that no variable has."""
        self.count += 1
        return f"v{self.count}"

    def branches(self, depth: int) -> list[str]:
        """Return an if with its branches; what only one of them sets is known no more after it."""
        before, lines, ways = dict(self.known), [], []
        words = ("if", "elif", "else")[: self.random.randint(1, 3)]
        for word in words if self.random.random() < 0.5 else (words[0], "else"):
            self.known = dict(before)
            test = "" if word == "else" else f" {self.expression('t', 2)}"
            lines += [f"{word}{test}:", *self.statements(depth + 1, 2)]
            ways.append(self.known)
        self.known = {n: kind for n, kind in before.items() if all(way.get(n) == kind for way in ways)}
        return lines

    def loop(self, sort: str, depth: int) -> list[str]:
        """Return a loop that ends, perhaps with an else."""
        before, name = dict(self.known), self.new()
        if sort == "for":
            stride = self.random.choice(("", "", ", 2", ", -1", ", 1 - 2 * (p_n % 2)"))
            ends = self.random.choice(("3", "-1", "COUNT", f"{self.expression('w', 1)} % 5"))
            starts = self.random.choice(("0, ", "4, ", "-2, ")) if stride else ""
            stride = stride.replace("p_n", self.expression("w", 0))
            head, lines = f"for {name} in range({starts}{ends}{stride}):", []
        else:
            lines = [f"{name} = {self.random.randint(0, 3)}"]
            head = f"while {name} < 5 and {self.expression('t', 2)}:"
        self.known[name] = "w"
        lines.append(head)
        if sort == "while":
            lines.append(f"    {name} += 1")
        self.counters.add(name)
        lines += self.statements(depth + 1, 1)
        test = self.expression("t", 2)
        lines += [f"    if {test}:", f"        {self.random.choice(('break', 'continue'))}"]
        lines += self.statements(depth + 1, 1)
        self.counters.remove(name)
        self.known = {n: k for n, k in before.items() if self.known.get(n) == k}
        if self.random.random() < 0.3:
            lines += ["else:", *self.statements(depth + 1, 1)]
            self.known = {n: k for n, k in before.items() if self.known.get(n) == k}
        if sort == "while" or self.random.random() < 0.03:
            self.known[name] = "w"
        return lines


# Divisors that are never zero and indices that are never beyond: what raises is tried by name elsewhere.
FORMS = {
    kind: tuple(form.strip() for line in forms.strip().splitlines() for form in line.split(" | "))
    for kind, forms in {
        "d": """
($d + $d) | ($d - $d) | ($d * $d) | ($d / (abs($d) + 0.5)) | ($d / $d) | ($d + $w) | ($w * $d) | ($t * $d)
($d % (abs($d) + 0.5)) | ($d % -(abs($d) + 0.5)) | ($d % 2) | (1.5 * $w % -3) | ($w % 0.75) | -$d | abs($d)
max($d, $d) | min($d, $d, $d) | math.copysign($d, $d) | float($w) | math.sqrt(abs($d)) | math.sin($d)
math.cos($d) | math.atan2($d, $d) | math.exp(min($d, 9.0)) | math.acos(max(-1.0, min(1.0, $d)))
math.fmod($d, abs($d) + 0.5) | math.fabs($w) | $d ** 2 | abs($d) ** 0.5 | $d ** 3 | (abs($d) + 0.1) ** -0.25
pow(abs($d) + 0.1, math.sin($d)) | ($w / (2 * $w + 1)) | ($d or $d) | ($d and $d) | $v[0] | $v[-1]
$v[$w % 3] | $v[$w % 3 - 3] | $v[int($t)] | $r.a | $r.b | TABLE[$w % 4] | TABLE[-$w % 4 - 4]
(Row(0.25), Row($d, $d))[$w % 2].b | Pair($r).first.a | Pair(scale=$d, first=$r).scale | Pair().first.a * $d
Pair(scale=$d)._replace(first=$r).first.b | $r._replace(b=$d, a=$d).a
""",
        "w": """
($w + $w) | ($w - $w) | ($w * $w) % 97 | ($w % (2 * $w + 1)) | -$w | -$t | abs($w) | ($w * $t) | max($w, $w)
min($w, $w) | int($t) | int(max(-9.0, min(9.0, $d))) | abs(-$t) | ($t + $t) | ($t - $w) | int($d)
math.floor(min(max($d, -99.0), 99.0)) | ($w or $w) | ($w and $w) | $r.n
""",
        "t": """
($d < $d) | ($d >= $d) | ($d == $d) | ($d != $w) | ($w <= $w) | ($w == $t) | (not $t) | (not $d) | ($t and $t)
($t or $t) | ($d < $d <= $d) | ($w < $w != $w) | bool($w) | bool($d) | ($v == (0.0, 1.5, 1.5))
math.isnan($d) | math.isfinite($d) | ($d > $w) | (not $w or $t) | ($w == $d == $w) | ($r != Row($w))
""",
        "v": """
($d, $d, $d) | tuple([$d for i in range(3)]) | (*($d, $d), $d) | ($v, $v)[$w % 2]
tuple([TABLE[i] * $d + i for i in range(3)])
""",
        "r": """
Row($d) | Row($d, $d) | Row(n=$w % 9, a=$d) | Row($d, n=$w % 5) | Row(b=$d, n=$w % 3, a=$d)
$r._replace(b=$d) | $r._replace(a=$d, n=$w % 7) | $r._replace(n=$w % 7, b=$d, a=$d) | $r._replace()
(Row($d), $r)[$w % 2] | Pair($r, $d).first | Pair()._replace(first=$r).first | Pair().first
""",
    }.items()
}
