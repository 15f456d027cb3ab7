"""Expressions of the laws in LLVM's text: names, tuples, choices, and calls of known functions.

What is not in the subset is refused by name.
"""

import ast
import builtins
import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import PurePath
from types import CodeType, FunctionType
from typing import Any

from forest_compile.llvm_text import (
    DOUBLE,
    TRUTH,
    WHOLE,
    NotTranslatedError,
    Record,
    Row,
    Scalar,
    Stored,
    Value,
    constant,
    known,
    number,
    shape,
    sort_of,
)
from forest_compile.translate_numbers import Numbers


class Frame:
    """One call of a function: its variables, and what names mean outside it."""

    def __init__(
        self, variables: dict[str, Value], names: Mapping[str, Any], name: str, code: CodeType
    ) -> None:
        """Begin a call.

        Args:
            variables: the arguments.
            names: what names mean outside.
            name: of the function.
            code: Python's of it, which knows file and variables.
        """
        self.variables, self.names, self.name = variables, names, name
        self.file, self.own = PurePath(code.co_filename).name, {*code.co_varnames, *code.co_cellvars}
        self.line = code.co_firstlineno
        self.returns: list[tuple[str, Value]] = []
        self.breaks: list[list[tuple[str, dict[str, Value]]]] = []
        self.continues: list[list[tuple[str, dict[str, Value]]]] = []

    def place(self) -> str:
        """Return which line is being written."""
        return f"{self.name} ({self.file}, line {self.line})"


class Expressions(Numbers):
    """Writes expressions into a function."""

    frame: Frame
    """The call that is being written."""

    def place(self) -> str:
        """Return which function, file and line is being written."""
        return self.frame.place()

    def value(self, node: ast.expr, frame: Frame) -> Value:
        """Return what an expression gives."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        line, frame.line = frame.line, node.lineno
        if method is None:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: {type(node).__name__} is not translated")
        result: Value = method(node, frame)
        frame.line = line
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
            owner = self._known(node.value, frame)
            if hasattr(owner, node.attr):
                return getattr(owner, node.attr)
        elif isinstance(node, ast.Name) and node.id not in frame.variables:
            if node.id in frame.own:
                raise NotTranslatedError(f"{node.id!r} has no value of one kind on every way here")
            for names in (frame.names, vars(builtins)):
                if node.id in names:
                    return names[node.id]
        raise NotTranslatedError(f"{ast.unparse(node)!r} has no meaning outside the function, and none in it")

    def means(self, node: ast.expr, frame: Frame, function: Any) -> bool:
        """Tell whether an expression is a name of a function, one of Python's own, say."""
        return (
            isinstance(node, ast.Name) and node.id not in frame.own and self._known(node, frame) is function
        )

    def _attribute(self, node: ast.Attribute, frame: Frame) -> Value:
        root: ast.expr = node
        while isinstance(root, ast.Attribute):
            root = root.value
        if isinstance(root, ast.Name) and root.id not in frame.variables:
            return constant(self._known(node, frame))
        value = self.value(node.value, frame)
        fields: tuple[str, ...] = getattr(sort_of(value), "_fields", ())
        if node.attr not in fields:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no such field")
        return self.into.member(value, fields.index(node.attr))

    def _subscript(self, node: ast.Subscript, frame: Frame) -> Value:
        value, index = self.value(node.value, frame), self.whole(self.number(node.slice, frame))
        if isinstance(value, Row):
            return self.into.load(value.text, self.row_index(index))
        at = known(index)
        if at is not None:
            return self.into.member(value, at)
        items = value.example if isinstance(value, Stored) else self.into.items(value)
        shapes = {shape(constant(item) if isinstance(value, Stored) else item) for item in items}
        if len(shapes) != 1:
            raise NotTranslatedError(f"{ast.unparse(node)!r}: only items alike have a variable index")
        return self.into.chosen(value, self._item_index(index, len(items)))

    def row_index(self, index: Scalar) -> Scalar:
        """Return a whole number that is 0 or more; how long a row is, only its owner knows."""
        at = known(index)
        if at is not None and at < 0:
            raise NotTranslatedError(f"index {at}: a row has no length that it could be counted from")
        if at is None:
            fine = self.into.emit(TRUTH, f"icmp sge i64 {index.text}, 0")
            self.require(fine, "a negative index of a row")
        return index

    def _item_index(self, index: Scalar, count: int) -> Scalar:
        """Return a tuple's index from 0 to its length less 1; a negative one counts from the end."""
        into = self.into
        negative = into.emit(TRUTH, f"icmp slt i64 {index.text}, 0")
        from_end = into.emit(WHOLE, f"add i64 {index.text}, {count}")
        at = into.emit(WHOLE, f"select i1 {negative.text}, i64 {from_end.text}, i64 {index.text}")
        within = into.emit(TRUTH, f"icmp ult i64 {at.text}, {count}")
        self.require(within, f"an index beyond a tuple of {count}")
        return at

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
            ) if self.means(outer, frame, tuple) and self.means(inner, frame, range):
                length = known(self.whole(self.number(count, frame)))
                if length is None:
                    raise NotTranslatedError(f"{ast.unparse(node)!r}: its length is not constant")
                items, outside = [], frame.variables
                for i in range(length):
                    frame.variables = outside | {name: number(i)}
                    items.append(self.value(item, frame))
                frame.variables = outside
                return Record(None, tuple(items))
        return None

    def _unaryop(self, node: ast.UnaryOp, frame: Frame) -> Value:
        value = self.number(node.operand, frame)
        if isinstance(node.op, ast.Not):
            return self.into.emit(TRUTH, f"xor i1 {self._truth(value).text}, true")
        if not isinstance(node.op, ast.USub):
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        if value.kind == DOUBLE:
            return self.into.emit(DOUBLE, f"fneg double {value.text}")
        return self.negative(value)

    def _binop(self, node: ast.BinOp, frame: Frame) -> Value:
        return self.operation(node.op, self.number(node.left, frame), self.number(node.right, frame))

    def _compare(self, node: ast.Compare, frame: Frame) -> Value:
        left = self.value(node.left, frame)

        def holds(sort: ast.cmpop, item: ast.expr) -> Scalar:
            nonlocal left
            before, left = left, self.value(item, frame)
            return self._compared(sort, before, left)

        pairs = zip(node.ops, node.comparators, strict=True)
        return self._first_of([partial(holds, *pair) for pair in pairs], False)

    def _boolop(self, node: ast.BoolOp, frame: Frame) -> Value:
        parts = [partial(self.number, part, frame) for part in node.values]
        return self._first_of(parts, isinstance(node.op, ast.Or))

    def _first_of(self, parts: Sequence[Callable[[], Scalar]], decides: bool) -> Value:
        """Return the first number whose truth is `decides`, or the last; none after it is asked for."""
        into, arrivals, end = self.into, [], self.into.label()
        for part in parts[:-1]:
            value, further = part(), into.label()
            arrivals.append((into.block, value))
            into.branch(self._truth(value), *((end, further) if decides else (further, end)))
            into.start(further)
        if not arrivals:
            return parts[0]()
        last = parts[-1]()
        arrivals.append((into.block, last))
        into.jump(end)
        into.start(end)
        return into.joined(arrivals)

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
        if any(word.arg is None for word in node.keywords):
            raise NotTranslatedError(f"{ast.unparse(node)!r}: ** is not translated")
        if isinstance(node.func, ast.Attribute) and node.func.attr == "_replace":
            return self._replaced(node, self.value(node.func.value, frame), frame)
        written = self._written_out(node, frame)
        if written is not None:
            return written
        function = self._known(node.func, frame)
        arguments = [self.value(item, frame) for item in node.args]
        named = {str(word.arg): self.value(word.value, frame) for word in node.keywords}
        if isinstance(function, FunctionType):
            return self.call(function, self._bound(node, function, arguments, named))
        if isinstance(function, type) and function.__bases__ == (tuple,) and hasattr(function, "_fields"):
            return Record(function, tuple(self._bound(node, function, arguments, named)))
        numbers = [item for item in arguments if isinstance(item, Scalar)]
        if len(numbers) != len(arguments) or named:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        return self._builtin(function, numbers, ast.unparse(node))

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

    def _replaced(self, node: ast.Call, value: Value, frame: Frame) -> Record:
        """Return a NamedTuple with some fields changed."""
        fields: tuple[str, ...] = getattr(sort_of(value), "_fields", ())
        if not fields or node.args:
            raise NotTranslatedError(f"{ast.unparse(node)!r} is not translated")
        items = dict(zip(fields, self.into.items(value), strict=True))
        for word in node.keywords:
            if word.arg not in items:
                raise NotTranslatedError(f"{ast.unparse(node)!r}: there is no field {word.arg!r}")
            items[word.arg] = self.value(word.value, frame)
        return Record(sort_of(value), tuple(items.values()))


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
