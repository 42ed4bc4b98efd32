"""Curves of single muscles looked up in a table: cubics through values and slopes, straight beyond the ends."""

import numpy as np
import warp as wp
from probes import filled

from warpmuscle.kernels.curve.shaped_family import ShapedCurves, looked_up
from warpmuscle.kernels.muscle_structs import CurveRow

START, END, PIECES, FIRST = 0.4, 1.6, 6, 2  # the muscle's part of the table begins at its third row


@wp.kernel(enable_backward=False)
def look(curves: ShapedCurves, place: wp.vec3i, x: wp.array[float], found: wp.array[wp.vec2]):
    i = wp.tid()
    found[i] = looked_up(curves, x[i], place)


def test_a_cubic_is_itself_between_the_knots_and_its_tangent_beyond_them():
    cubic = np.polynomial.Polynomial([0.3, -1.0, 0.7, 0.5])
    knots, step = np.linspace(START, END, PIECES + 1), (END - START) / PIECES
    nodes = np.stack([cubic(knots), step * cubic.deriv()(knots)], axis=1)
    others = [[9.0, 9.0]] * (FIRST + 1)
    table = wp.array(np.float32([*others, [START, END], *nodes]), dtype=wp.vec2, device="cpu")
    curves = filled(ShapedCurves, row=filled(CurveRow, table=FIRST), table=table)
    x = np.concatenate([np.linspace(-0.5, 2.5, 121), knots])
    found = wp.zeros(len(x), dtype=wp.vec2, device="cpu")
    given = wp.array(np.float32(x), dtype=float, device="cpu")
    wp.launch(look, len(x), [curves, wp.vec3i(1, 2, PIECES), given, found], device="cpu")
    inside = np.clip(x, START, END)
    slope = cubic.deriv()(inside)
    np.testing.assert_allclose(found.numpy()[:, 0], cubic(inside) + slope * (x - inside), atol=2e-5)
    np.testing.assert_allclose(found.numpy()[:, 1], slope, atol=2e-4)
