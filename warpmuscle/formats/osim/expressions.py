"""Expressions of bushings' forces as straight functions of angles and shifts, and of one variable; none is run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.limits import GREATEST_NUMBER
from warpmuscle.scene.expressions.parse import BadExpression, evaluate, parse

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
        raise NotStraight(f"{sign!r} is not a sum, product or quotient")
    if np.any(first[1:]) and np.any(second[1:]):
        raise NotStraight("it multiplies variables with each other")
    return np.asarray(first * second[0] if not np.any(second[1:]) else second * first[0])


GREATEST_POWER = 12  # of a variable in an expression that is taken as a polynomial


def of_one(text: str, variable: str) -> list[float] | Callable[[Floats], Floats]:
    """An expression of one variable: coefficients of a polynomial, constant first, if it is one, or its values.

    Raises:
        BadExpression: it is no expression of this variable, or has a factor beyond limits.
    """
    program = parse(text, [variable])
    stack: list[np.polynomial.Polynomial] = []
    for operation in program:
        if operation.kind in ("constant", "variable"):
            stack.append(np.polynomial.Polynomial([operation.number] if operation.kind == "constant" else [0.0, 1.0]))
            continue
        if operation.kind == "negative":
            stack.append(-stack.pop())
            continue
        with np.errstate(all="ignore"):
            made = _polynomial(operation.kind, *stack[-2:]) if operation.kind in ("+", "-", "*", "/", "^") else None
        if made is None or made.degree() > GREATEST_POWER:
            return lambda q: np.asarray(evaluate(program, {variable: q}, {})) + np.zeros_like(q)
        stack[-2:] = [made]
    if not np.all(np.abs(stack[0].coef) <= GREATEST_NUMBER):
        raise BadExpression(f"a factor is beyond {GREATEST_NUMBER:g}")
    return [float(c) for c in stack[0].coef]


def _polynomial(
    sign: str, first: np.polynomial.Polynomial, second: np.polynomial.Polynomial
) -> np.polynomial.Polynomial | None:
    """The sum, difference, product, quotient or power of two polynomials, if it is one."""
    if sign == "+":
        return first + second
    if sign == "-":
        return first - second
    if sign == "*":
        return first * second
    number = float(second.coef[0])
    if second.degree() > 0 or (sign == "/" and number == 0.0):
        return None
    if sign == "/":
        return first / number
    whole = number == int(number) and 0.0 <= number <= GREATEST_POWER
    return first ** int(number) if whole else None
