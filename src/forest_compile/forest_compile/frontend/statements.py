"""Statements: where branches meet, and where a loop begins, each variable becomes one again.

A variable lives on after a branch or a loop if every way there gives it a value of one kind.
"""

import ast
from collections.abc import Callable, Sequence
from contextlib import suppress

from forest_compile.frontend.expressions import Expressions
from forest_compile.frontend.frame import Arrival, Variables
from forest_compile.frontend.integers import ZERO
from forest_compile.ir.values import Array, NotTranslatedError, Scalar, Value, items, known, number


class Statements(Expressions):
    """Writes statements of the innermost call into a function."""

    def run(self, body: Sequence[ast.stmt]) -> list[Arrival]:
        """Write statements, up to one that leaves; return how they end if none does."""
        for node in body:
            if not self.into.open:
                return []
            self.frame.line = node.lineno
            method = getattr(self, f"_do_{type(node).__name__.lower()}", None)
            if method is None:
                raise NotTranslatedError(f"{type(node).__name__} is not translated")
            method(node)
        return [(self.into.block, self.frame.variables)] if self.into.open else []

    def returned(self) -> Value:
        """Return what the innermost call gives, whose statements are written, and go on after it."""
        arrivals = self.frame.returns
        if self.into.open or not arrivals:
            raise NotTranslatedError("a way through the function that returns nothing is not translated")
        self.into.meet([block for block, _ in arrivals])
        return self.into.joined(arrivals)

    def _do_expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            raise NotTranslatedError("an expression without use is not translated")

    def _do_assign(self, node: ast.Assign) -> None:
        value = self.value(node.value)
        for target in node.targets:
            self._assign(target, value)

    def _assign(self, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self.frame.variables[target.id] = value
        elif isinstance(target, ast.Tuple):
            if len(items(value)) != len(target.elts):
                raise NotTranslatedError(f"{ast.unparse(target)!r} is given a tuple of {len(items(value))}")
            for part, item in zip(target.elts, items(value), strict=True):
                self._assign(part, item)
        elif isinstance(target, ast.Subscript):
            array, index = self.value(target.value), self.integer(self.number(target.slice))
            if not (isinstance(array, Array) and isinstance(value, Scalar)):
                raise NotTranslatedError(f"{ast.unparse(target)!r}: only rows take numbers")
            self.into.store(self.double(value), array.text, self.array_index(index))
        else:
            raise NotTranslatedError(f"{ast.unparse(target)!r} is not assigned to")

    def _do_augassign(self, node: ast.AugAssign) -> None:
        before = self.number(node.target)
        self._assign(node.target, self.operation(node.op, before, self.number(node.value)))

    def _do_return(self, node: ast.Return) -> None:
        if node.value is None:
            raise NotTranslatedError("a return without value is not translated")
        value = self.settled(self.value(node.value))
        self.frame.returns.append((self.into.block, value))
        self.into.open = False

    def _do_break(self, _: ast.Break) -> None:
        self.frame.breaks[-1].append((self.into.block, self.frame.variables))
        self.into.open = False

    def _do_continue(self, _: ast.Continue) -> None:
        self.frame.continues[-1].append((self.into.block, self.frame.variables))
        self.into.open = False

    def _do_if(self, node: ast.If) -> None:
        into, before = self.into, self.frame.variables
        yes, no = into.label(), into.label()
        into.branch(self.condition(node.test), yes, no)
        arrivals = []
        for label, body in ((yes, node.body), (no, node.orelse)):
            into.start(label)
            self.frame.variables = dict(before)
            arrivals += self.run(body)
        self._meet(arrivals)

    def _meet(self, arrivals: list[Arrival]) -> None:
        """Go on where several blocks lead, with the variables that all have, and of one kind."""
        if not arrivals:
            return
        self.into.meet([block for block, _ in arrivals])
        self.frame.variables = {}
        for name in arrivals[0][1]:
            if all(name in variables for _, variables in arrivals):
                with suppress(NotTranslatedError):  # an error where it is used: `Expressions._outside`
                    values = [(block, variables[name]) for block, variables in arrivals]
                    self.frame.variables[name] = self.into.joined(values)

    def _do_while(self, node: ast.While) -> None:
        self._loop(node, {}, lambda: self.condition(node.test), dict)

    def _do_for(self, node: ast.For) -> None:
        call = node.iter
        if not (isinstance(call, ast.Call) and self.means(call.func, range)):
            raise NotTranslatedError("only ranges are gone through")
        if not isinstance(node.target, ast.Name) or call.keywords:
            raise NotTranslatedError(f"{ast.unparse(node.target)!r} is no counter, or the range is none")
        first, end, stride = self._range([self._settled(self.integer(self.number(n))) for n in call.args])
        into, target = self.into, node.target.id
        counter = f"{target}'{into.label()}"  # no name of Python's, so that the body cannot change it

        def here() -> Scalar:
            value = self.frame.variables[counter]
            assert isinstance(value, Scalar)
            return value

        def test() -> Scalar:
            up = into.operate("icmp sgt", stride, ZERO)
            upwards, downwards = into.operate("icmp slt", here(), end), into.operate("icmp sgt", here(), end)
            return into.select(up, upwards, downwards)

        def begin() -> Variables:
            return {target: here(), counter: into.operate("add nsw", here(), stride)}

        self._loop(node, {counter: first}, test, begin)

    def _range(self, numbers: list[Scalar]) -> tuple[Scalar, Scalar, Scalar]:
        """Return first number, end and stride of a range."""
        if len(numbers) not in (1, 2, 3):
            raise NotTranslatedError(f"a range of {len(numbers)} numbers is none")
        first, end = (ZERO, *numbers) if len(numbers) == 1 else numbers[:2]
        stride = numbers[2] if len(numbers) == 3 else number(1)
        if known(stride) == 0:
            raise NotTranslatedError("a range's stride is zero")
        if known(stride) is None:
            self.require(self.into.operate("icmp ne", stride, ZERO), "a range's stride is zero")
        return first, end, stride

    def _loop(
        self,
        node: ast.While | ast.For,
        counters: Variables,
        test: Callable[[], Scalar],
        begin: Callable[[], Variables],
    ) -> None:
        """Write a loop.

        Args:
            node: the loop.
            counters: variables that nobody sees, as they are before it.
            test: writes what decides whether there is another round.
            begin: returns variables that a round begins with.
        """
        into, frame = self.into, self.frame
        stored = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        variables = frame.variables | counters
        changed = [name for name in variables if name in stored or name in counters]
        settled = {name: self.settled(variables[name]) for name in changed}
        before = into.block
        head, body, done = into.label(), into.label(), into.label()
        into.jump(head)
        into.start(head)
        heads = {name: into.repeated(value, before) for name, value in settled.items()}
        frame.variables = variables | {name: value for name, (value, _) in heads.items()}
        into.branch(test(), body, done)
        outside = {name: value for name, value in frame.variables.items() if name not in counters}
        into.start(body)
        frame.breaks.append([])
        frame.continues.append([])
        frame.variables = frame.variables | begin()
        ends = self.run(node.body)
        self._meet(ends + frame.continues.pop())
        if not into.open:
            raise NotTranslatedError("a loop that never goes round is not translated")
        frame.line = node.lineno
        self._close({name: close for name, (_, close) in heads.items()})
        into.jump(head)
        into.start(done)
        frame.variables = outside
        ends = self.run(node.orelse)
        self._meet(ends + frame.breaks.pop())

    def _close(self, closing: dict[str, Callable[[str, Value], None]]) -> None:
        """Tell a loop's head what its variables are after a round."""
        after = {}
        for name in closing:
            if name not in self.frame.variables:
                raise NotTranslatedError(f"a loop makes something of another kind of {name!r}")
            after[name] = self.settled(self.frame.variables[name])
        for name, close in closing.items():
            close(self.into.block, after[name])
