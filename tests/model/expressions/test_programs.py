"""Programs of expressions have the values of NumPy in a kernel, whatever operations and curves they are of."""

import msgspec
import numpy as np
import pytest
import warp as wp

from small_scene import muscle_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.kernels.algebra.programs import Variables, value_of
from warpmuscle.model.expressions.programs import expression_tables
from warpmuscle.scene import Displacement, Force, Scene
from warpmuscle.scene.expressions.parse import NUMPY, evaluate, parse
from warpmuscle.scene.expressions.part import ExpressionCurve
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.validation.scene import check_scene

HINGE = "lToe"
CURVE = ExpressionCurve([-1.0, 0.0, 0.5, 2.0], [3.0, -1.0, 0.5, 0.7])
TEXTS = (
    "q^2 - 3*qdot/t", "-q*abs(qdot) + sqrt(t)", "exp(-q) - log(t + 2)", "sin(q)*cos(qdot) - tan(0.3*t)",
    "asin(0.4*q) + acos(0.3*qdot) - atan(t)", "sinh(q) - cosh(qdot) + tanh(t)", "min(q, qdot) + max(t, q)*step(q)",
    "bend(q + 0.1)*2 - bend(bend(qdot))", "1 - (2 - (3 - (4 - (5 - q*(6 - qdot*(7 - t))))))", "recip(t)^1.5 - cube(q)",
)  # fmt: skip


@wp.kernel(enable_backward=False)
def values(table: wp.array[wp.vec2], first: wp.array[int], points: wp.array[Variables], result: wp.array2d[float]):
    i, k = wp.tid()
    result[i, k] = value_of(table, first[i], points[k])


def scene_with(**forces: Force) -> Scene:
    scene = muscle_scene()
    return msgspec.structs.replace(scene, forces=forces)


def spring(text: str, joint: str, **curves: ExpressionCurve) -> Force:
    return Force("coordinate_expression", joint, parameters={"scale": 1.0}, expressions={"effort": text}, curves=curves)


def test_kernels_have_the_values_of_numpy():
    forces = {f"force_{k}": spring(text, HINGE, bend=CURVE) for k, text in enumerate(TEXTS)}
    rows, starts = expression_tables(scene_with(**forces))
    rng = np.random.default_rng(3)
    points = np.zeros((40, 8), dtype=np.float32)
    points[:, 0], points[:, 1] = rng.uniform(-1.0, 1.0, (2, 40))
    points[:, 2] = rng.uniform(0.1, 2.0, 40)
    first = wp.array([int(starts[name]["effort"]) for name in forces], dtype=int, device="cpu")
    result = wp.zeros((len(TEXTS), 40), dtype=float, device="cpu")
    table = wp.array(rows, dtype=wp.vec2, device="cpu")
    inputs = [table, first, wp.array(points, dtype=Variables, device="cpu")]
    wp.launch(values, result.shape, inputs, [result], device="cpu")
    function = Displacement((1.0, 0.0, 0.0), x=CURVE.x, y=[*CURVE.y], ends=CURVE.ends)
    given = dict(zip(("q", "qdot", "t"), points.T.astype(float), strict=False))
    for text, found in zip(TEXTS, result.numpy(), strict=True):
        program = parse(text, ("q", "qdot", "t"), ("bend",))
        expected = evaluate(program, given, {"bend": lambda a: rates(function, np.asarray(a))[0]})
        np.testing.assert_allclose(found, expected, rtol=2e-6, atol=2e-6 * np.abs(expected).max(), err_msg=text)


def test_texts_of_this_test_use_every_operation():
    made = {one.kind for text in TEXTS for one in parse(text, ("q", "qdot", "t"), ("bend",))}
    assert made >= NUMPY.keys()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"expressions": {"effort": "q +"}}, r"forces.a.expressions.effort: 'q \+': it ends too early"),
        ({"expressions": {"efort": "q"}}, "no expression is called 'efort'.* 'effort'"),
        ({"curves": {"q": CURVE}}, "none of a variable"),
        ({"curves": {"b": ExpressionCurve([0.0], [1.0])}}, "needs two knots"),
        ({"curves": {"b": ExpressionCurve([1.0, 0.0], [1.0, 2.0])}}, "knots must increase"),
        ({"parameters": {}}, "no value of 'scale'"),
        ({"parameters": {"scale": 1.0, "effort": 3.0}}, "no parameter is called 'effort'"),
        ({"type": "coordinate_spring", "parameters": {"rest": 0.0, "stiffness": 1.0, "damping": 0.0}}, "takes none"),
    ],
)
def test_what_is_wrong_is_told(change: dict, message: str):
    force = msgspec.structs.replace(spring("q", HINGE), **change)
    with pytest.raises(SceneError, match=message):
        check_scene(scene_with(a=force))


def test_files_keep_expressions_and_curves():
    scene = scene_with(a=spring("-bend(q)", HINGE, bend=CURVE))
    assert loads(dumps(scene)).forces == scene.forces
