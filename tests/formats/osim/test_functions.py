"""Functions of OpenSim's files have OpenSim's values, also put into each other."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from warpmuscle.core.errors import SceneError
from warpmuscle.formats.osim.elements import Element, parse
from warpmuscle.formats.osim.functions import Function, composed, read_function
from warpmuscle.formats.osim.functions.composed import MOST_KNOTS
from warpmuscle.scene import Displacement
from warpmuscle.scene.joints.displacement import rates

X, Y = "-1 -0.5 0 0.4 0.9 1.5 2 2.4", "0 0.2 0.1 -0.3 0.5 0.6 0.1 0"
AT = np.array([-0.8, 0.2, 0.7, 1.2, 2.2])


def element(tag: str, text: str = "", *children: Element) -> Element:
    return Element(tag, Path("a.osim"), 7, "", text, list(children))


def knots(tag: str, *more: Element) -> Element:
    return element(tag, "", *more, element("x", X), element("y", Y))


@pytest.mark.parametrize(
    ("half_order", "expected"),  # of OpenSim 4.6's GCVSpline of these knots, of degree 3 and 5
    [
        ("2", [0.08750247, -0.16367396, 0.11415674, 0.73385782, 0.01863665]),
        ("3", [0.04944867, -0.16980469, 0.08554882, 0.78642812, 0.00660811]),
    ],
)
def test_a_spline_through_its_knots_has_opensims_values(half_order: str, expected: list[float]):
    function = read_function(knots("GCVSpline", element("half_order", half_order)))
    np.testing.assert_allclose(function.values(AT), expected, atol=2e-8)


def test_one_that_smooths_or_of_another_class_is_refused():
    with pytest.raises(SceneError, match=r"a\.osim:7: <error_variance>: smooths"):
        read_function(knots("GCVSpline", element("error_variance", "0.1")))
    with pytest.raises(SceneError, match=r"a\.osim:7: <SignalGenerator>: functions of this class are not"):
        read_function(element("SignalGenerator"))


def test_lines_polynomials_and_broken_lines():
    polynomial = read_function(element("PolynomialFunction", "", element("coefficients", "3 2 1")))
    np.testing.assert_allclose(polynomial.values(AT), 3.0 * AT**2 + 2.0 * AT + 1.0)
    assert read_function(element("LinearFunction", "", element("coefficients", "3 2"))).line == (2.0, 3.0)
    assert read_function(element("Constant", "", element("value", "3"))).line == (3.0, 0.0)
    broken = read_function(knots("PiecewiseLinearFunction"))
    np.testing.assert_allclose(broken.values(np.array([-2.0, 0.2, 3.0])), [-0.4, -0.1, -0.15])
    scaled = element("MultiplierFunction", "", element("function", "", knots("SimmSpline")), element("scale", "-2"))
    np.testing.assert_allclose(read_function(scaled).values(AT), -2.0 * read_function(knots("SimmSpline")).values(AT))


def test_functions_of_lines_are_exact_and_others_nearly():
    spline = read_function(knots("SimmSpline"))
    line, falling = Function((0.3, 2.0)), Function((0.3, -0.5))
    square = Function((0.1, 0.0, 0.4))
    for outer, inner in ((spline, line), (spline, falling), (line, spline), (square, falling), (line, square)):
        function, error = composed(outer, inner, -1.0, 1.0)
        assert error == 0.0
        np.testing.assert_allclose(function.values(AT), outer.values(inner.values(AT)), atol=1e-14)
    function, error = composed(spline, square, -1.0, 1.0)
    inside = np.linspace(-0.95, 0.95, 50)
    difference = np.max(np.abs(function.values(inside) - spline.values(square.values(inside))))
    assert difference < 3.0 * error + 1e-9
    assert error < 1e-6


@pytest.mark.parametrize(
    ("text", "function"),
    [
        ("<Sine><amplitude>2</amplitude><omega>3</omega><phase>0.4</phase><offset>0.1</offset></Sine>",
            lambda x: 0.1 + 2.0 * np.sin(3.0 * x + 0.4)),
        ("<Sine><amplitude>2</amplitude><omega>0</omega><phase>0.5</phase></Sine>",
            lambda x: 2.0 * np.sin(0.5) + 0.0 * x),
        ("<StepFunction><transition_start_time>1</transition_start_time><transition_end_time>3</transition_end_time>"
            "<start_value>2</start_value><end_value>6</end_value></StepFunction>",
            lambda x: 2.0 + 4.0 * np.polyval([6.0, -15.0, 10.0, 0.0, 0.0, 0.0], np.clip(0.5 * (x - 1.0), 0.0, 1.0))),
        ("<PiecewiseConstantFunction><x>0 1 2</x><y>1 2 5</y></PiecewiseConstantFunction>",
            lambda x: np.where(x < 1.0, 1.0, np.where(x < 2.0, 2.0, 5.0))),
    ],
)  # fmt: skip
def test_waves_steps_and_stairs_are_sampled_closely(tmp_path, text, function):
    file = tmp_path / "one.osim"
    file.write_text(text)
    x = np.random.default_rng(1).uniform(-4.0, 6.0, 400)
    np.testing.assert_allclose(read_function(parse(file)).values(x), function(x), atol=2e-4)


def test_sines_are_close_to_themselves_within_turns(tmp_path):
    file = tmp_path / "f.xml"
    for omega in (0.5, 3.0, 15.0):
        file.write_text(f"<Sine><amplitude>2</amplitude><omega>{omega}</omega><phase>0.3</phase></Sine>")
        function, q = read_function(parse(file)), np.linspace(-9.8, 9.8, 4001)
        np.testing.assert_allclose(function.values(q), 2.0 * np.sin(omega * q + 0.3), rtol=0.0, atol=1e-6)
        slopes = function.slopes(q) / (2.0 * omega)
        np.testing.assert_allclose(slopes, np.cos(omega * q + 0.3), rtol=0.0, atol=3e-5)


def test_splines_of_fifth_degree_have_their_slopes(tmp_path):
    """As SciPy's natural spline of degree 5 through knots that change fast."""
    rng, x = np.random.default_rng(1), np.linspace(-2.0, 2.0, 12)
    y = rng.uniform(-0.5, 0.5, 12)
    file = tmp_path / "f.xml"
    file.write_text(f"<GCVSpline><x>{' '.join(map(str, x))}</x><y>{' '.join(map(str, y))}</y></GCVSpline>")
    natural = [(3, 0.0), (4, 0.0)]
    spline = make_interp_spline(x, y, k=5, bc_type=(natural, natural))
    function, q = read_function(parse(file)), np.linspace(-2.0, 2.0, 4001)
    np.testing.assert_allclose(function.values(q), spline(q), rtol=0.0, atol=3e-9)
    np.testing.assert_allclose(function.slopes(q), spline(q, 1), rtol=0.0, atol=1e-6 * np.abs(spline(q, 1)).max())


def test_knots_that_were_chosen_here_may_be_fewer_and_others_stay():
    steep = read_function(knots("GCVSpline", element("half_order", "3")))
    few = steep.sparse(300)
    assert len(few.x) <= 300 < len(steep.x)
    assert (few.x[0], few.x[-1]) == (steep.x[0], steep.x[-1])
    np.testing.assert_allclose(few.values(AT), steep.values(AT), atol=1e-5)
    assert steep.sparse(len(steep.x)) is steep
    read = read_function(knots("SimmSpline"))
    assert read.sparse(3) is read


def test_a_quick_sine_is_refused(tmp_path):
    file = tmp_path / "one.osim"
    file.write_text("<Sine><amplitude>1</amplitude><omega>16</omega></Sine>")
    with pytest.raises(SceneError, match="an omega of 16 is too quick: 25 turns are within 10 rad or s at most"):
        read_function(parse(file))


def test_a_step_that_goes_back_is_refused(tmp_path):
    file = tmp_path / "one.osim"
    file.write_text("<StepFunction><transition_start_time>1</transition_start_time><transition_end_time>1"
        "</transition_end_time></StepFunction>")  # fmt: skip
    with pytest.raises(SceneError, match="must end after 1, not at 1"):
        read_function(parse(file))


def of_one(dimension: str, order: str, coefficients: str) -> Element:
    parts = {"dimension": dimension, "order": order, "coefficients": coefficients}
    return element("MultivariatePolynomialFunction", "", *(element(tag, text) for tag, text in parts.items()))


def test_a_polynomial_of_several_may_be_of_one_with_its_constant_first():
    function = read_function(of_one("1", "2", "0.1 0.2 0.3"))
    np.testing.assert_allclose(function.values(AT), 0.1 + 0.2 * AT + 0.3 * AT**2, atol=1e-15)
    for dimension, order, message in (("2", "1", "is of 2 coordinates"), ("1", "1.5", "whole number"), ("1", "3", "4")):
        with pytest.raises(SceneError, match=message):
            read_function(of_one(dimension, order, "0.1 0.2 0.3"))


def test_what_steps_and_lines_do_not_say_is_opensims():
    step = read_function(element("StepFunction"))  # of OpenSim 4.6: from 0 to 1 between 0.99 and 1.01
    np.testing.assert_allclose(step.values(np.array([0.9, 0.99, 1.0, 1.01, 1.2])), [0, 0, 0.5, 1, 1], atol=1e-12)
    assert read_function(element("LinearFunction")).line == (0.0, 1.0)


def test_a_spline_of_a_spline_has_its_values_beyond_the_range_too():
    inner = Function(x=(-1.0, 0.0, 0.7, 1.5), y=(-0.8, 0.1, 0.6, 1.9))
    outer = Function(x=(-1.0, -0.2, 0.3, 1.2), y=(0.01, 0.03, -0.02, 0.04))
    made, error = composed(outer, inner, -0.9, 1.3)
    at = np.linspace(-1.9, 2.3, 1000)
    assert error < 1e-5
    np.testing.assert_allclose(made.values(at), outer.values(inner.values(at)), atol=1e-5)


def test_a_spline_of_a_spline_bends_as_it_does_where_it_turns_sharply():
    inner = Function(x=(-2.0, -1.0, 0.0, 0.1, 0.2, 1.0, 2.0), y=(-1.9, -1.0, 0.0, 0.12, 0.19, 0.9, 2.2))
    outer = Function(x=(-2.0, -0.5, 0.0, 0.1, 0.22, 0.9, 2.5), y=(0.0, 0.1, 0.12, 0.11, 0.12, 0.0, -0.1))
    made, _ = composed(outer, inner, -1.5, 1.5)
    at = np.linspace(-1.5, 1.5, 2003)
    value, slope, bend = (rates(smooth(inner), at)[k] for k in range(3))
    _, outer_slope, outer_bend = (rates(smooth(outer), value)[k] for k in range(3))
    expected = outer_bend * slope**2 + outer_slope * bend  # the chain rule
    found = rates(smooth(made), at)[2]
    assert np.max(np.abs(found - expected)) < 3e-3 * np.max(np.abs(expected))
    assert len(made.x) <= MOST_KNOTS


def smooth(function: Function) -> Displacement:
    return Displacement((1.0, 0.0, 0.0), x=list(function.x), y=list(function.y), ends=function.ends)


def expression(text: str, variables: str = "x") -> Element:
    return element("ExpressionBasedFunction", "", element("expression", text), element("variables", variables))


def test_an_expression_is_the_polynomial_that_it_is_or_a_spline():
    whole = read_function(expression("0.5 - (q - 1)^2*q/4", "q"))
    np.testing.assert_allclose(whole.coefficients, [0.5, -0.25, 0.5, -0.25], atol=1e-15)
    for text, value, slope in (
        ("0.2*x^2 + sin(2*x)", 0.2 * AT**2 + np.sin(2.0 * AT), 0.4 * AT + 2.0 * np.cos(2.0 * AT)),
        ("exp(-x)/(1 + x^2)", np.exp(-AT) / (1.0 + AT**2), None),
        ("0.3", 0.3 + 0.0 * AT, 0.0 * AT),
    ):
        found = read_function(expression(text))
        np.testing.assert_allclose(found.values(AT), value, rtol=1e-7, atol=1e-9)
        if slope is not None and found.x:
            np.testing.assert_allclose(found.slopes(AT), slope, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "variables", "message"),
    [
        ("x + y", "x y", "is of 2 variables, where one is known"), ("x", "", "is of 0 variables"),
        ("", "x", "has no expression"), ("__import__('os')", "x", "<expression>"), ("x +", "x", "<expression>"),
        ("y", "x", "<expression>"), ("sqrt(x)", "x", "has no number at -"), ("x/0", "x", "has no number at"),
        ("(" * 90 + "x" + ")" * 90, "x", "<expression>"), ("x/1e-320", "x", "a factor is beyond"),
        ("1e12*1e12*x", "x", "a factor is beyond"),
    ],
)  # fmt: skip
def test_expressions_that_are_none_are_refused_in_one_line(text: str, variables: str, message: str):
    with pytest.raises(SceneError, match=message) as error:
        read_function(expression(text, variables))
    assert "\n" not in str(error.value)
