"""Actuators whose activation follows their control, and functions of time with many knots, as expressions."""

import re
from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.formats import load
from warpmuscle.formats.osim.actions.activations import activation_text
from warpmuscle.formats.osim.actions.texts import function_text
from warpmuscle.formats.osim.functions import Function
from warpmuscle.scene.expressions.part import ExpressionCurve

TAU, START = 0.02, 0.5  # s, and the activation at first
TIMES = np.linspace(0.0, 1.5, 3001)
CONTROLS = {
    "none": Function((0.0,)),
    "level": Function((0.4,)),
    "line": Function((0.2, 3.0)),
    "cubic": Function((0.2, 3.0, -1.0, 0.5)),
    "knots": Function(x=(-1.0, 0.0, 0.1, 0.3, 1.0, 1.2), y=(0.0, 0.0, 1.0, 0.2, 0.2, 0.0), ends="linear"),
}


def values(text: str, curves: dict[str, ExpressionCurve]) -> np.ndarray:
    """An expression of t at the times."""
    functions = {
        name: lambda t, c=curve: Function(x=tuple(c.x), y=tuple(c.y), ends=c.ends).values(t)  # type: ignore[misc]
        for name, curve in curves.items()
    }
    return np.asarray(eval(text.replace("^", "**"), {"exp": np.exp, "t": TIMES, **functions}) + 0.0 * TIMES)


def followed(control: Function) -> np.ndarray:
    """The activation at the times, by the classical Runge-Kutta method with small steps."""
    a, found, step = START, [START], TIMES[1]

    def rate(t: float, a: float) -> float:
        return (control.at(t) - a) / TAU

    for t in TIMES[:-1]:
        k1 = rate(t, a)
        k2, k3 = rate(t + 0.5 * step, a + 0.5 * step * k1), 0.0
        k3 = rate(t + 0.5 * step, a + 0.5 * step * k2)
        a += step * (k1 + 2.0 * k2 + 2.0 * k3 + rate(t + step, a + step * k3)) / 6.0
        found.append(a)
    return np.array(found)


@pytest.mark.parametrize("name", CONTROLS)
def test_an_activation_follows_its_control(name: str):
    curves: dict[str, ExpressionCurve] = {}
    text = activation_text(CONTROLS[name], TAU, START, "a", curves)
    np.testing.assert_allclose(values(text, curves), followed(CONTROLS[name]), atol=1e-3 if curves else 1e-8)
    assert all(len(curve.x) <= 1000 for curve in curves.values())


def test_an_actuator_without_a_control_relaxes_from_the_start_that_the_model_gives(tmp_path: Path):
    """OpenSim's defaults are 0.01 s and 0.5."""
    for more, expected in (("", (0.5, -100.0)), ("<default_activation>0.2</default_activation>", (0.2, -100.0))):
        force = (
            '<ActivationCoordinateActuator name="motor"><coordinate>q</coordinate><optimal_force>7</optimal_force>'
            f"{more}</ActivationCoordinateActuator>"
        )
        made = load(small.written(tmp_path, small.pendulum(forces=force)), ignored=[]).forces["motor"]
        assert made.parameters == {"scale": 7.0}
        found = re.fullmatch(r"0\.0 \+ (.*)\*exp\((.*)\*t\)", made.expressions["effort"])
        assert found is not None
        np.testing.assert_allclose([float(number) for number in found.groups()], expected)


def test_a_quick_sine_over_time_has_no_more_knots_than_a_curve_may_have(tmp_path: Path):
    """Those before the start are left out but for some, whose part in the spline then is small."""
    sine = '<Sine name="s"><amplitude>2</amplitude><omega>15</omega><phase>0.3</phase><offset>1</offset></Sine>'
    flat = '<Constant name="c"><value>0</value></Constant>'
    force = (
        '<PrescribedForce name="push"><socket_frame>/bodyset/rod</socket_frame><FunctionSet name="forceFunctions">'
        f"<objects>{sine}{flat}{flat}</objects></FunctionSet></PrescribedForce>"
    )
    made = load(small.written(tmp_path, small.pendulum(forces=force)), ignored=[]).forces["push"]
    (curve,) = made.curves.values()
    assert len(curve.x) <= 1000
    spline = Function(x=tuple(map(float, curve.x)), y=tuple(map(float, curve.y)), ends=curve.ends)
    np.testing.assert_allclose(spline.values(TIMES), 1.0 + 2.0 * np.sin(15.0 * TIMES + 0.3), atol=2e-5)


def test_a_curve_of_something_else_than_time_keeps_all_of_its_knots():
    curves: dict[str, ExpressionCurve] = {}
    knots = tuple(map(float, range(-30, 5)))
    function_text(Function(x=knots, y=tuple(k * k for k in knots)), "q", "c", curves)
    assert len(curves["c"].x) == len(knots)
