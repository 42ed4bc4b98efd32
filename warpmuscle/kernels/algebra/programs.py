"""Expressions that a scene has as text, as programs of a stack in a table of rows (operation, number)."""

import warp as wp

from warpmuscle.kernels.algebra.operations import BINARY, CONSTANT, CURVE, DEEPEST, MOST_VARIABLES, UNARY, VARIABLE
from warpmuscle.kernels.algebra.piecewise import piecewise
from warpmuscle.kernels.functions import func

Variables = wp.types.vector(length=MOST_VARIABLES, dtype=wp.float32)
Stack = wp.types.vector(length=DEEPEST, dtype=wp.float32)
FIRST_UNARY = min(UNARY.values())
ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER = (BINARY[sign] for sign in "+-*/^")
LEAST, MOST = BINARY["min"], BINARY["max"]
NEGATIVE, SQRT, EXP, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN, SINH, COSH, TANH, ABS, STEP = UNARY.values()


@func
def of_two(operation: int, a: float, b: float) -> float:
    """a sum, a quotient, ... of two numbers."""
    if operation == ADD:
        return a + b
    if operation == SUBTRACT:
        return a - b
    if operation == MULTIPLY:
        return a * b
    if operation == DIVIDE:
        return a / b
    if operation == POWER:
        return wp.pow(a, b)
    if operation == LEAST:
        return wp.min(a, b)
    return wp.max(a, b)


@func
def of_one(operation: int, a: float) -> float:
    """A function of a number; that of a step is 1 from 0 on."""
    if operation == NEGATIVE:
        return -a
    if operation == SQRT:
        return wp.sqrt(a)
    if operation == EXP:
        return wp.exp(a)
    if operation == LOG:
        return wp.log(a)
    if operation == SIN:
        return wp.sin(a)
    if operation == COS:
        return wp.cos(a)
    if operation == TAN:
        return wp.tan(a)
    if operation == ASIN:
        return wp.asin(a)
    if operation == ACOS:
        return wp.acos(a)
    if operation == ATAN:
        return wp.atan(a)
    if operation == SINH:
        return wp.sinh(a)
    if operation == COSH:
        return wp.cosh(a)
    if operation == TANH:
        return wp.tanh(a)
    if operation == ABS:
        return wp.abs(a)
    return wp.where(a >= 0.0, 1.0, 0.0)


@func
def value_of(table: wp.array[wp.vec2], first: int, variables: Variables) -> float:
    """The value of a program.

    Args:
        first: row of its head, the number of its operations, which follow.
    """
    stack = Stack()
    top = wp.int32(-1)
    for row in range(first + 1, first + 1 + int(table[first][0])):
        operation = int(table[row][0])
        number = table[row][1]
        if operation == CONSTANT:
            top += 1
            stack[top] = number
        elif operation == VARIABLE:
            top += 1
            stack[top] = variables[int(number)]
        elif operation == CURVE:
            stack[top] = piecewise(table, int(number), stack[top])
        elif operation < FIRST_UNARY:
            top -= 1
            stack[top] = of_two(operation, stack[top], stack[top + 1])
        else:
            stack[top] = of_one(operation, stack[top])
    return stack[0]
