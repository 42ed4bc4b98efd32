"""Expressions of the forces of bushings as straight functions of angles and shifts; nothing of them is run."""

from __future__ import annotations

import re

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER

VARIABLES = ("theta_x", "theta_y", "theta_z", "delta_x", "delta_y", "delta_z")
LONGEST = 2000  # characters
DEEPEST = 50  # parentheses
TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|([A-Za-z_]\w*)|([-+*/()]))", re.ASCII)


class NotStraight(ValueError):
    """An expression is no straight function of the variables, or not understood."""


def straight(text: str) -> Floats:
    """Constant and factors (7,) of `VARIABLES` in an expression of sums, products and quotients.

    Raises:
        NotStraight: it is none, or with functions or powers.
    """
    if len(text) > LONGEST:
        raise NotStraight(f"it has more than {LONGEST} characters")
    reader = _Reader(_tokens(text))
    with np.errstate(over="ignore", invalid="ignore"):
        value = reader.sum(0)
    if reader.rest:
        raise NotStraight(f"{reader.rest[-1]!r} is not understood")
    if not np.all(np.abs(value) <= GREATEST_NUMBER):
        raise NotStraight(f"a factor is beyond {GREATEST_NUMBER:g}")
    return value


def _tokens(text: str) -> list[str]:
    """Numbers, names and signs, the first one last."""
    found, place = [], 0
    text = text.strip()
    while place < len(text):
        match = TOKEN.match(text, place)
        if match is None:
            raise NotStraight(f"{text[place:].split()[0]!r} is not understood")
        found.append(match.group().strip())
        place = match.end()
    if not found:
        raise NotStraight("it is empty")
    return found[::-1]


class _Reader:
    """Reads tokens one after the other, each rule as constant and factors."""

    def __init__(self, tokens: list[str]) -> None:
        self.rest = tokens

    def sum(self, depth: int) -> Floats:
        value = self._product(depth)
        while self.rest and self.rest[-1] in "+-":
            sign = 1.0 if self.rest.pop() == "+" else -1.0
            value = value + sign * self._product(depth)
        return value

    def _product(self, depth: int) -> Floats:
        value = self._factor(depth)
        while self.rest and self.rest[-1] in "*/":
            divides = self.rest.pop() == "/"
            other = self._factor(depth)
            if divides:
                if np.any(other[1:]) or other[0] == 0.0:
                    raise NotStraight("it divides by a variable or by 0")
                value = value / other[0]
            elif np.any(value[1:]) and np.any(other[1:]):
                raise NotStraight("it multiplies variables with each other")
            else:
                value = value * other[0] if not np.any(other[1:]) else other * value[0]
        return np.asarray(value)

    def _factor(self, depth: int) -> Floats:
        sign = 1.0
        while self.rest and self.rest[-1] in "+-":
            sign = -sign if self.rest.pop() == "-" else sign
        if not self.rest:
            raise NotStraight("it ends too early")
        token = self.rest.pop()
        value: Floats = np.zeros(1 + len(VARIABLES))
        if token == "(":
            if depth > DEEPEST:
                raise NotStraight(f"it has more than {DEEPEST} parentheses in each other")
            value = self.sum(depth + 1)
            if not self.rest or self.rest.pop() != ")":
                raise NotStraight("a parenthesis is not closed")
        elif token in VARIABLES:
            value[1 + VARIABLES.index(token)] = 1.0
        elif token[0].isdigit() or token[0] == ".":
            value[0] = float(token)
        else:
            raise NotStraight(f"{token!r} is not known here")
        return sign * value
