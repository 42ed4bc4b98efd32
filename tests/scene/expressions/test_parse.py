"""Expressions mean what mathematics means by them, in NumPy, and what is none is refused with a reason."""

import math

import numpy as np
import pytest

from warpmuscle.scene.expressions.parse import FUNCTIONS, LONGEST, NESTED, BadExpression, evaluate, parse

X, Y = 0.7, -1.3


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2", 2.0), ("-x", -X), ("1 - 2 - 3", -4.0), ("8/4/2", 1.0), ("2^3^2", 512.0), ("-2^2", -4.0), ("2^-1", 0.5),
        ("(x + y)*x - -y", (X + Y) * X + Y), ("3*x^2*exp(-x)", 3 * X**2 * math.exp(-X)), ("min(x, y)", Y),
        ("max(x, 2*y)", X), ("sqrt(x)/abs(y)", math.sqrt(X) / 1.3), ("step(y) + step(x)", 1.0),
        ("square(x) + cube(y) + recip(x)", X**2 + Y**3 + 1 / X), ("bend(2*x)", 3 * 2 * X), (".5e1*x", 5 * X),
        ("atan(tan(x)) - log(exp(y))", X - Y), ("cosh(x)^2 - sinh(x)^2 + tanh(0)", 1.0),
    ],
)  # fmt: skip
def test_values_are_those_of_mathematics(text: str, value: float):
    program = parse(text, ("x", "y"), ("bend",))
    found = evaluate(program, {"x": X, "y": Y}, {"bend": lambda a: 3 * a})
    assert found == pytest.approx(value, rel=1e-12)
    many = evaluate(program, {"x": np.full(3, X), "y": Y}, {"bend": lambda a: 3 * a})
    np.testing.assert_allclose(many, value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"), ("x +", "ends too early"), ("(x", "not closed"), ("x y", "'y' is not understood there"),
        ("z", "'z' is not known; it may be of x, y"), ("x.real", "'.real' is not understood"),
        ("sin x", "is a function"),
        ("min(x)", "takes two numbers"), ("__import__('os')", "not understood"), ("x; y", "';' is not understood"),
        ("1e400", "beyond"), ("x" * (LONGEST + 1), "characters"), ("(" * (NESTED + 5) + "x", "in each other"),
        ("x^" * (NESTED + 5) + "x", "in each other"), ("1+(" * 17 + "x" + ")" * 17, "wait for each other"),
        ("é", "not understood"), ("negative(x)", "not known"),
    ],
)  # fmt: skip
def test_what_is_no_expression_is_refused(text: str, message: str):
    with pytest.raises(BadExpression, match=message.replace("(", r"\(")):
        parse(text, ("x", "y"))


def test_every_function_has_a_value():
    for name in FUNCTIONS:
        text = f"{name}(0.5, 0.2)" if name in ("min", "max") else f"{name}(0.5)"
        assert math.isfinite(float(evaluate(parse(text, ()), {}, {})))
