"""Expressions: names, tuples, choices, and calls of known functions.

What is not in the subset is refused by name.
"""

import ast
import builtins
import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from types import FunctionType
from typing import Any

from forest_compile.entry import RuntimeNumber
from forest_compile.frontend.arithmetic import TRUE, Arithmetic
from forest_compile.frontend.integers import ZERO
from forest_compile.ir.values import (
    BOOLEAN,
    DOUBLE,
    Array,
    NotTranslatedError,
    Record,
    Scalar,
    Stored,
    Value,
    constant,
    fields,
    item_shapes,
    items,
    known,
    member,
    number,
)


class Expressions(Arithmetic, ABC):
    """Writes expressions of the innermost call into a function."""

    def value(self, node: ast.expr) -> Value:
        """Return what an expression gives."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        line, self.frame.line = self.frame.line, node.lineno
        if method is None:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: {type(node).__name__} is not translated")
        result: Value = method(node)
        self.frame.line = line
        return result

    def number(self, node: ast.expr) -> Scalar:
        """Return what an expression gives, which must be a number."""
        value = self.value(node)
        if not isinstance(value, Scalar):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is no number")
        return value

    def condition(self, node: ast.expr) -> Scalar:
        """Return whether an expression is true, looking only at what decides."""
        if isinstance(node, ast.BoolOp):
            parts = [partial(self.condition, part) for part in node.values]
            return self._first_of(parts, isinstance(node.op, ast.Or))
        return self.truth(self.number(node))

    @abstractmethod
    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a model function gives."""

    def _constant(self, node: ast.Constant) -> Value:
        return constant(node.value)

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.frame.variables:
            return self.frame.variables[node.id]
        return self._meant(self._outside(node))

    def _meant(self, value: Any) -> Value:
        """Return what a name means outside: numbers as they are, or as they will be when the kernel runs."""
        if isinstance(value, tuple):
            sort = type(value) if hasattr(value, "_fields") else None
            return Record(sort, tuple(map(self._meant, value)))
        return self.into.runtime(value.place) if isinstance(value, RuntimeNumber) else constant(value)

    def _outside(self, node: ast.expr) -> Any:
        """Return what a name means outside the function."""
        if isinstance(node, ast.Attribute):
            owner = self._outside(node.value)
            if hasattr(owner, node.attr):
                return getattr(owner, node.attr)
        elif isinstance(node, ast.Name) and node.id not in self.frame.variables:
            if node.id in self.frame.own:
                raise NotTranslatedError(f"{node.id!r} has no value of one kind on every way here")
            for names in (self.frame.names, vars(builtins)):
                if node.id in names:
                    return names[node.id]
        raise NotTranslatedError(f"{ast.unparse(node)!r} has no meaning outside the function, and none in it")

    def means(self, node: ast.expr, function: Any) -> bool:
        """Tell whether an expression is a name of a function, one of Python's own, say."""
        own = isinstance(node, ast.Name) and node.id in self.frame.own
        return isinstance(node, ast.Name) and not own and self._outside(node) is function

    def _attribute(self, node: ast.Attribute) -> Value:
        root = node.value
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in self.frame.variables:
            return self._meant(self._outside(node))
        value = self.value(node.value)
        if node.attr not in fields(value):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no such field")
        return member(value, fields(value).index(node.attr))

    def _subscript(self, node: ast.Subscript) -> Value:
        value, index = self.value(node.value), self.integer(self.number(node.slice))
        if isinstance(value, Array):
            return self.into.load(value.text, self.array_index(index))
        at = known(index)
        if at is not None:
            return member(value, at)
        if not isinstance(value, Record | Stored) or len(set(item_shapes(value))) != 1:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: only items alike have a variable index")
        return self.into.chosen(value, self._item_index(index, len(item_shapes(value))))

    def array_index(self, index: Scalar) -> Scalar:
        """Return an integer that is 0 or more; how long an array is, only its owner knows."""
        at = known(index)
        if at is not None and at < 0:
            raise NotTranslatedError(f"index {at}: a row has no length that it could be counted from")
        if at is None:
            self.require(self.into.operate("icmp sge", index, ZERO), "a negative index of a row")
        return index

    def _item_index(self, index: Scalar, count: int) -> Scalar:
        """Return a tuple's index from 0 to its length less 1; a negative one counts from the end."""
        into, length = self.into, number(count)
        from_end = into.operate("add", index, length)
        at = into.select(into.operate("icmp slt", index, ZERO), from_end, index)
        self.require(into.operate("icmp ult", at, length), f"an index beyond a tuple of {count}")
        return at

    def _tuple(self, node: ast.Tuple) -> Value:
        parts: list[Value] = []
        for item in node.elts:
            if isinstance(item, ast.Starred):
                parts += items(self.value(item.value))
            else:
                parts.append(self.value(item))
        return Record(None, tuple(parts))

    def _written_out(self, node: ast.Call) -> Record | None:
        """Return `tuple([... for i in range(n)])`, n a constant, item by item; None if a call is none."""
        match node:
            case ast.Call(
                func=outer,
                args=[
                    ast.ListComp(
                        elt=item,
                        generators=[
                            ast.comprehension(
                                target=ast.Name(name),
                                iter=ast.Call(func=inner, args=[count], keywords=[]),
                                ifs=[],
                            )
                        ],
                    )
                ],
                keywords=[],
            ) if self.means(outer, tuple) and self.means(inner, range):
                length = known(self.integer(self.number(count)))
                if length is None:
                    raise NotTranslatedError(f"{ast.unparse(node)!r}: its length is not constant")
                parts, outside = [], self.frame.variables
                for i in range(length):
                    self.frame.variables = outside | {name: number(i)}
                    parts.append(self.value(item))
                self.frame.variables = outside
                return Record(None, tuple(parts))
        return None

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return self.into.operate("xor", self.condition(node.operand), TRUE)
        value = self.number(node.operand)
        if not isinstance(node.op, ast.USub):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        if value.kind == DOUBLE:
            return self.into.emit(DOUBLE, f"fneg double {value.text}")
        return self.negative(value)

    def _binop(self, node: ast.BinOp) -> Value:
        return self.operation(node.op, self.number(node.left), self.number(node.right))

    def _compare(self, node: ast.Compare) -> Value:
        left = self.value(node.left)

        def holds(sort: ast.cmpop, item: ast.expr) -> Scalar:
            nonlocal left
            before, left = left, self.value(item)
            return self.compared(sort, before, left)

        pairs = zip(node.ops, node.comparators, strict=True)
        return self._first_of([partial(holds, *pair) for pair in pairs], False)

    def _boolop(self, node: ast.BoolOp) -> Value:
        parts = [partial(self.number, part) for part in node.values]
        return self._first_of(parts, isinstance(node.op, ast.Or))

    def _first_of(self, parts: Sequence[Callable[[], Scalar]], decides: bool) -> Scalar:
        """Return the first number whose truth is `decides`, or the last; none after it is asked for."""
        into = self.into
        arrivals: list[tuple[str, Scalar]] = []
        for part in parts[:-1]:
            value, decided, further = part(), into.label(), into.label()
            into.branch(self.truth(value), *((decided, further) if decides else (further, decided)))
            into.start(decided)
            arrivals.append((decided, number(decides) if value.kind == BOOLEAN else value))
            into.start(further)
        last = parts[-1]()
        if not arrivals:
            return last
        arrivals.append((into.block, last))
        into.meet([block for block, _ in arrivals])
        return into.joined_number(arrivals)

    def _ifexp(self, node: ast.IfExp) -> Value:
        into, arrivals = self.into, []
        yes, no = into.label(), into.label()
        into.branch(self.condition(node.test), yes, no)
        for label, part in ((yes, node.body), (no, node.orelse)):
            into.start(label)
            value = self.value(part)
            arrivals.append((into.block, value))
        into.meet([block for block, _ in arrivals])
        return into.joined(arrivals)

    def _call(self, node: ast.Call) -> Value:
        if any(word.arg is None for word in node.keywords):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: ** is not translated")
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(node, self.value(node.func.value))
        written = self._written_out(node)
        if written is not None:
            return written
        function = self._outside(node.func)
        arguments = [self.value(item) for item in node.args]
        named = {str(word.arg): self.value(word.value) for word in node.keywords}
        if isinstance(function, FunctionType):
            return self.call(function, self._bound(node, function, arguments, named))
        if isinstance(function, type) and function.__bases__ == (tuple,) and hasattr(function, "_fields"):
            return Record(function, tuple(self._bound(node, function, arguments, named)))
        numbers = [item for item in arguments if isinstance(item, Scalar)]
        if len(numbers) != len(arguments) or named:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        return self.builtin(function, numbers, ast.unparse(node))

    def _bound(
        self, node: ast.Call, function: Callable[..., Any], arguments: list[Value], named: dict[str, Value]
    ) -> list[Value]:
        """Return the value of each of a function's parameters, in their order."""
        parameters = _signature(function).parameters
        if any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters.values()):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: any number of arguments is not translated")
        try:
            given = _signature(function).bind(*arguments, **named).arguments
        except TypeError as error:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: {error}") from error
        return [given[name] if name in given else _default(node, parameters[name]) for name in parameters]

    def _replaced(self, node: ast.Call, value: Value) -> Record:
        """Return a NamedTuple with some fields changed."""
        if isinstance(value, Scalar | Array) or not fields(value) or node.args:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        parts = dict(zip(fields(value), items(value), strict=True))
        for word in node.keywords:
            if word.arg not in parts:
                raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no field {word.arg!r}")
            parts[word.arg] = self.value(word.value)
        return Record(value.sort, tuple(parts.values()))


@lru_cache(maxsize=1024)
def _signature(function: Callable[..., Any]) -> inspect.Signature:
    return inspect.signature(function, follow_wrapped=False)


def _default(node: ast.Call, parameter: inspect.Parameter) -> Value:
    """Return what a parameter is that a call does not give."""
    try:
        return constant(parameter.default)
    except NotTranslatedError as error:
        text = f"{ast.unparse(node)!r}: the default of {parameter.name!r}: {error}"
        raise NotTranslatedError(text) from error
