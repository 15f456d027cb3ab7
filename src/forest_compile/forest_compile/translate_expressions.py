"""Expressions of the laws in LLVM's text: names, tuples, choices, and calls of known functions.

What is not in the subset is refused by name.
"""

import ast
import builtins
from collections.abc import Callable
from types import FunctionType
from typing import Any

from forest_compile.llvm_text import (
    DOUBLE,
    TRUTH,
    WHOLE,
    Record,
    Row,
    Scalar,
    Stored,
    Value,
    constant,
    scalars,
)
from forest_compile.translate_numbers import FALSE, TRUE, NotTranslatedError, Numbers


class Frame:
    """One call of a function: its variables, and what names mean outside it."""

    def __init__(self, variables: dict[str, Value], names: dict[str, Any]) -> None:
        self.variables, self.names = variables, names
        self.returns: list[tuple[str, Value]] = []
        self.breaks: list[list[tuple[str, dict[str, Value]]]] = []
        self.continues: list[list[tuple[str, dict[str, Value]]]] = []


class Expressions(Numbers):
    """Writes expressions into a function."""

    def value(self, node: ast.expr, frame: Frame) -> Value:
        """Return what an expression gives."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: {type(node).__name__} is not translated")
        result: Value = method(node, frame)
        return result

    def number(self, node: ast.expr, frame: Frame) -> Scalar:
        """Return what an expression gives, which must be a number."""
        value = self.value(node, frame)
        if not isinstance(value, Scalar):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is no number")
        return value

    def call(self, function: FunctionType, arguments: list[Value]) -> Value:
        """Return what a function of the laws gives."""
        raise NotImplementedError

    def jump_if(self, node: ast.expr, frame: Frame, yes: str, no: str) -> None:
        """Go on at one label or the other, looking only at what decides."""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.jump_if(node.operand, frame, no, yes)
        elif isinstance(node, ast.BoolOp):
            for part in node.values[:-1]:
                further = self.into.label()
                if isinstance(node.op, ast.And):
                    self.jump_if(part, frame, further, no)
                else:
                    self.jump_if(part, frame, yes, further)
                self.into.start(further)
            self.jump_if(node.values[-1], frame, yes, no)
        else:
            self.into.branch(self._truth(self.number(node, frame)), yes, no)

    def _constant(self, node: ast.Constant, _: Frame) -> Value:
        return constant(node.value)

    def _name(self, node: ast.Name, frame: Frame) -> Value:
        if node.id in frame.variables:
            return frame.variables[node.id]
        return constant(self._known(node, frame))

    def _known(self, node: ast.expr, frame: Frame) -> Any:
        """Return what a name means outside the function."""
        if isinstance(node, ast.Attribute):
            return getattr(self._known(node.value, frame), node.attr)
        if isinstance(node, ast.Name) and node.id not in frame.variables:
            found = frame.names.get(node.id, getattr(builtins, node.id, None))
            if found is not None:
                return found
        raise NotTranslatedError(f"{ast.unparse(node)!r} has no meaning outside the function, and none in it")

    def _attribute(self, node: ast.Attribute, frame: Frame) -> Value:
        root: ast.expr = node
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in frame.variables:
            return constant(self._known(node, frame))
        value = self.value(node.value, frame)
        sort: Any = value.sort if isinstance(value, Record) else type(getattr(value, "example", None))
        if node.attr not in getattr(sort, "_fields", ()):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no such field")
        return self.into.member(value, sort._fields.index(node.attr))

    def _subscript(self, node: ast.Subscript, frame: Frame) -> Value:
        value, index = self.value(node.value, frame), self.number(node.slice, frame)
        if isinstance(value, Row):
            return self.into.load(value.text, index)
        if index.text.lstrip("-").isdigit():
            return self.into.member(value, int(index.text))
        if not self._alike(value):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: only items alike have a variable index")
        return self.into.chosen(value, index)

    def _alike(self, value: Value) -> bool:
        """Tell whether a tuple's items are of one shape."""
        if isinstance(value, Stored):
            kinds = {str(_kinds(item)) for item in value.example}
        elif isinstance(value, Record):
            kinds = {str([number.kind for number in scalars(self.into.taken(item))]) for item in value.items}
        else:
            return False
        return len(kinds) == 1

    def _tuple(self, node: ast.Tuple, frame: Frame) -> Value:
        items: list[Value] = []
        for item in node.elts:
            if isinstance(item, ast.Starred):
                items += self.into.items(self.value(item.value, frame))
            else:
                items.append(self.value(item, frame))
        return Record(None, tuple(items))

    def _written_out(self, node: ast.Call, frame: Frame) -> Record | None:
        """Return `tuple([... for i in range(n)])`, n a constant, item by item; None if a call is none."""
        match node:
            case ast.Call(
                func=ast.Name("tuple"),
                args=[
                    ast.ListComp(
                        elt=item,
                        generators=[
                            ast.comprehension(
                                target=ast.Name(name),
                                iter=ast.Call(func=ast.Name("range"), args=[count]),
                                ifs=[],
                            )
                        ],
                    )
                ],
            ):
                number = self.number(count, frame).text
                if not number.isdigit():
                    raise NotTranslatedError(f"{ast.unparse(node)!r}: its length is not constant")
                items: list[Value] = []
                for i in range(int(number)):
                    inner = Frame(frame.variables | {name: Scalar(WHOLE, str(i))}, frame.names)
                    items.append(self.value(item, inner))
                return Record(None, tuple(items))
        return None

    def _unaryop(self, node: ast.UnaryOp, frame: Frame) -> Value:
        number = self.number(node.operand, frame)
        if isinstance(node.op, ast.Not):
            return self.into.emit(TRUTH, f"xor i1 {self._truth(number).text}, true")
        if not isinstance(node.op, ast.USub):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        if number.kind == WHOLE:
            if number.text.isdigit():
                return Scalar(WHOLE, f"-{number.text}")
            return self.into.emit(WHOLE, f"sub i64 0, {number.text}")
        return self.into.emit(DOUBLE, f"fneg double {self.into.converted(number, DOUBLE).text}")

    def _binop(self, node: ast.BinOp, frame: Frame) -> Value:
        left = self.number(node.left, frame)
        if isinstance(node.op, ast.Pow):
            power = node.right.value if isinstance(node.right, ast.Constant) else None
            if power == 2:
                return self.operation(ast.Mult(), left, left)
            if not isinstance(power, int | float) or left.kind != DOUBLE:
                raise NotTranslatedError(f"{ast.unparse(node)!r}: only constant powers are translated")
            return self._builtin(pow, [left, self.number(node.right, frame)], ast.unparse(node))
        return self.operation(node.op, left, self.number(node.right, frame))

    def _compare(self, node: ast.Compare, frame: Frame) -> Value:
        values = [self.value(item, frame) for item in (node.left, *node.comparators)]
        result: Scalar | None = None
        for operator, left, right in zip(node.ops, values[:-1], values[1:], strict=True):
            holds = self._compared(operator, left, right)
            result = holds if result is None else self._both(result, holds)
        return result or TRUE

    def _boolop(self, node: ast.BoolOp, frame: Frame) -> Value:
        return self._chosen(node, frame, lambda: TRUE, lambda: FALSE)

    def _ifexp(self, node: ast.IfExp, frame: Frame) -> Value:
        return self._chosen(
            node.test, frame, lambda: self.value(node.body, frame), lambda: self.value(node.orelse, frame)
        )

    def _chosen(
        self, test: ast.expr, frame: Frame, yes: Callable[[], Value], no: Callable[[], Value]
    ) -> Value:
        into = self.into
        first, second, end = into.label(), into.label(), into.label()
        self.jump_if(test, frame, first, second)
        arrivals = []
        for label, make in ((first, yes), (second, no)):
            into.start(label)
            value = make()
            arrivals.append((into.block, value))
            into.jump(end)
        into.start(end)
        return into.joined(arrivals)

    def _call(self, node: ast.Call, frame: Frame) -> Value:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(node, self.value(node.func.value, frame), frame)
        written = self._written_out(node, frame)
        if written is not None:
            return written
        function = self._known(node.func, frame)
        arguments = [self.value(item, frame) for item in node.args]
        if isinstance(function, type) and issubclass(function, tuple):
            named = {str(word.arg): self.value(word.value, frame) for word in node.keywords}
            fields: tuple[str, ...] = getattr(function, "_fields", ())
            given = {n: constant(v) for n, v in getattr(function, "_field_defaults", {}).items()} | named
            return Record(function, (*arguments, *(given[name] for name in fields[len(arguments) :])))
        if isinstance(function, FunctionType):
            named = {str(word.arg): self.value(word.value, frame) for word in node.keywords}
            names = function.__code__.co_varnames[: function.__code__.co_argcount]
            last = function.__defaults__ or ()
            missing = [name for name in names[len(arguments) :] if name not in named]
            default = dict(zip(names[len(names) - len(last) :], last, strict=True))
            named |= {name: constant(default[name]) for name in missing}
            return self.call(function, [*arguments, *(named[name] for name in names[len(arguments) :])])
        numbers = [item for item in arguments if isinstance(item, Scalar)]
        if len(numbers) != len(arguments) or node.keywords:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        return self._builtin(function, numbers, ast.unparse(node))

    def _replaced(self, node: ast.Call, value: Value, frame: Frame) -> Record:
        """Return a NamedTuple with some fields changed."""
        sort: Any = value.sort if isinstance(value, Record) else type(getattr(value, "example", None))
        items = dict(zip(getattr(sort, "_fields", ()), self.into.items(value), strict=True))
        for word in node.keywords:
            if word.arg not in items:
                raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no field {word.arg!r}")
            items[word.arg] = self.value(word.value, frame)
        return Record(sort, tuple(items.values()))


def _kinds(example: Any) -> list[Any]:
    """Return the types of a nested tuple's numbers."""
    if isinstance(example, tuple):
        return [kind for item in example for kind in _kinds(item)]
    return [type(example)]
