"""Expressions of the forces of bushings as straight functions of angles and shifts; nothing of them is run."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.scene.expressions.parse import BadExpression, parse

VARIABLES = ("theta_x", "theta_y", "theta_z", "delta_x", "delta_y", "delta_z")


class NotStraight(ValueError):
    """An expression is no straight function of the variables, or not understood."""


def straight(text: str) -> Floats:
    """Constant and factors (7,) of `VARIABLES` in an expression of sums, products and quotients.

    Raises:
        NotStraight: it is none, or with functions or powers.
    """
    try:
        program = parse(text, VARIABLES)
    except BadExpression as error:
        raise NotStraight(str(error)) from error
    stack: list[Floats] = []
    with np.errstate(over="ignore", invalid="ignore"):
        for operation in program:
            if operation.kind == "constant":
                stack.append(np.eye(1 + len(VARIABLES))[0] * operation.number)
            elif operation.kind == "variable":
                stack.append(np.eye(1 + len(VARIABLES))[1 + VARIABLES.index(operation.name)])
            elif operation.kind == "negative":
                stack.append(-stack.pop())
            else:
                second = stack.pop()
                stack.append(_joined(operation.kind, stack.pop() if stack else second, second))
    (value,) = stack
    if not np.all(np.abs(value) <= GREATEST_NUMBER):
        raise NotStraight(f"a factor is beyond {GREATEST_NUMBER:g}")
    return value


def _joined(sign: str, first: Floats, second: Floats) -> Floats:
    """The sum, difference, product or quotient of two straight functions, if it is one."""
    if sign in "+-":
        return first + second if sign == "+" else first - second
    if sign == "/":
        if np.any(second[1:]) or second[0] == 0.0:
            raise NotStraight("it divides by a variable or by 0")
        return np.asarray(first / second[0])
    if sign != "*":
        raise NotStraight(f"{sign!r} is no sum, product or quotient")
    if np.any(first[1:]) and np.any(second[1:]):
        raise NotStraight("it multiplies variables with each other")
    return np.asarray(first * second[0] if not np.any(second[1:]) else second * first[0])
