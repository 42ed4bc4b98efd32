"""Text of an expression to operations of a stack, and their value in NumPy."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.kernels.algebra.operations import BINARY, DEEPEST, UNARY

LONGEST = 2000  # characters
NESTED = 50  # parentheses in each other
TOKEN = re.compile(r"\s*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|([-+*/^(),]))", re.ASCII)
FUNCTIONS = (*(name for name in UNARY if name != "negative"), "min", "max", "square", "cube", "recip")
NUMPY: dict[str, Callable[..., Any]] = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "^": np.power, "min": np.minimum,
    "max": np.maximum, "negative": np.negative, "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "sin": np.sin,
    "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh,
    "cosh": np.cosh, "tanh": np.tanh, "abs": np.abs, "step": lambda a: np.where(a >= 0.0, 1.0, 0.0),
}  # fmt: skip


class BadExpression(ValueError):
    """Text that is no expression of what it may be of."""


class Operation(NamedTuple):
    """What a program does next: push a number or a variable, call a curve, or one of `BINARY` and `UNARY`."""

    kind: str  # constant, variable, curve, or the name of an operation
    number: float = 0.0
    name: str = ""


def parse(text: str, variables: Sequence[str], curves: Collection[str] = ()) -> tuple[Operation, ...]:
    """The operations of an expression, in the order of a stack.

    `+ - * / ^` as in mathematics, `^` first and from the right, before a sign: -x^2 is -(x^2). See `FUNCTIONS`.

    Raises:
        BadExpression: it is none, too long, or of a name that is neither a variable, a curve nor a function.
    """
    if len(text) > LONGEST:
        raise BadExpression(f"it has more than {LONGEST} characters")
    reader = _Reader(_tokens(text), variables, curves)
    reader.sum(0)
    if reader.rest:
        raise BadExpression(f"{reader.rest[-1]!r} is not understood there")
    height = 0
    for operation in reader.made:
        height += 1 if operation.kind in ("constant", "variable") else -1 if operation.kind in BINARY else 0
        if height > DEEPEST:
            raise BadExpression(f"more than {DEEPEST} numbers wait for each other in it; put it otherwise")
    return tuple(reader.made)


def evaluate(
    program: Sequence[Operation], values: Mapping[str, Any], curves: Mapping[str, Callable[[Any], Any]]
) -> Any:
    """The value of a program in float64, of numbers or arrays of them."""
    stack: list[Any] = []
    with np.errstate(all="ignore"):
        for operation in program:
            if operation.kind == "constant":
                stack.append(operation.number)
            elif operation.kind == "variable":
                stack.append(values[operation.name])
            elif operation.kind == "curve":
                stack.append(curves[operation.name](stack.pop()))
            elif operation.kind in BINARY:
                last = stack.pop()
                stack.append(NUMPY[operation.kind](np.float64(stack.pop()), last))
            else:
                stack.append(NUMPY[operation.kind](np.float64(stack.pop())))
    return stack[0]


def _tokens(text: str) -> list[str]:
    """Numbers, names and signs, the first one last."""
    found, place = [], 0
    text = text.strip()
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None:
            raise BadExpression(f"{text[place:].split()[0][:40]!r} is not understood")
        found.append(match.group().strip())
        place = match.end()
    if not found:
        raise BadExpression("it is empty")
    return found[::-1]


class _Reader:
    """Reads tokens one after the other, and puts operations behind what they are of."""

    def __init__(self, tokens: list[str], variables: Sequence[str], curves: Collection[str]) -> None:
        self.rest, self.made = tokens, list[Operation]()
        self._variables, self._curves = variables, curves

    def sum(self, depth: int) -> None:
        self._product(depth)
        while self.rest and self.rest[-1] in "+-":
            sign = self.rest.pop()
            self._product(depth)
            self.made.append(Operation(sign))

    def _product(self, depth: int) -> None:
        self._signed(depth)
        while self.rest and self.rest[-1] in "*/":
            sign = self.rest.pop()
            self._signed(depth)
            self.made.append(Operation(sign))

    def _signed(self, depth: int) -> None:
        negative = False
        while self.rest and self.rest[-1] in "+-":
            negative ^= self.rest.pop() == "-"
        self._power(depth)
        if negative:
            self.made.append(Operation("negative"))

    def _power(self, depth: int) -> None:
        self._factor(depth)
        if self.rest and self.rest[-1] == "^":
            if depth > NESTED:
                raise BadExpression(f"it has more than {NESTED} powers or parentheses in each other")
            self.rest.pop()
            negative = False
            while self.rest and self.rest[-1] in "+-":
                negative ^= self.rest.pop() == "-"
            self._power(depth + 1)
            self.made += [Operation("negative")] * negative + [Operation("^")]

    def _factor(self, depth: int) -> None:
        if not self.rest:
            raise BadExpression("it ends too early")
        token = self.rest.pop()
        if token == "(":
            self._inner(depth)
            self._close()
        elif token[0].isdigit() or token[0] == ".":
            number = float(token)
            if number > GREATEST_NUMBER:
                raise BadExpression(f"{token} is beyond {GREATEST_NUMBER:g}")
            self.made.append(Operation("constant", number))
        elif token in self._variables:
            self.made.append(Operation("variable", float(self._variables.index(token)), token))
        elif token in self._curves or token in FUNCTIONS:
            self._call(token, depth)
        else:
            curves = f", curves are {', '.join(self._curves)}" if self._curves else ""
            raise BadExpression(f"{token[:40]!r} is not known; it may be of {', '.join(self._variables)}{curves}")

    def _call(self, name: str, depth: int) -> None:
        if not self.rest or self.rest.pop() != "(":
            raise BadExpression(f"{name!r} is a function: write {name}(...)")
        self._inner(depth)
        if name in ("min", "max"):
            if not self.rest or self.rest.pop() != ",":
                raise BadExpression(f"{name!r} takes two numbers")
            self._inner(depth)
        self._close()
        if name in self._curves:
            self.made.append(Operation("curve", name=name))
        elif name == "recip":
            self.made += [Operation("constant", -1.0), Operation("^")]
        elif name in ("square", "cube"):
            self.made += [Operation("constant", 2.0 if name == "square" else 3.0), Operation("^")]
        else:
            self.made.append(Operation(name))

    def _inner(self, depth: int) -> None:
        if depth > NESTED:
            raise BadExpression(f"it has more than {NESTED} parentheses in each other")
        self.sum(depth + 1)

    def _close(self) -> None:
        if not self.rest or self.rest.pop() != ")":
            raise BadExpression("a parenthesis is not closed")
