"""Where a path touches a cylinder: in a plane or unrolled, by how many surfaces there are and how long the arc is."""

import numpy as np
import warp as wp
from probes import evaluate

from warpmuscle.kernels.path.wrap_cylinder import (
    AMONG_OTHERS,
    EXACT,
    IN_PLANE,
    OVERSHOT,
    SHORT,
    cylinder_touch_of,
    slide,
)
from warpmuscle.kernels.path.wrap_touch import BESIDE

RADIUS, LENGTH = 0.05, 1.0  # m
touch_of = cylinder_touch_of(False)


@wp.kernel(enable_backward=False)
def touched(
    a: wp.array[wp.vec3], b: wp.array[wp.vec3], where: int, kind: wp.array[int], first: wp.array[wp.vec3],
    second: wp.array[wp.vec3], arc: wp.array[float],
):  # fmt: skip
    i = wp.tid()
    touch = touch_of(a[i], b[i], wp.static(RADIUS), wp.static(LENGTH), 0, 0, where)
    kind[i] = touch.kind
    first[i] = touch.first
    second[i] = touch.second
    arc[i] = touch.arc


def heights(a: np.ndarray, b: np.ndarray, where: int) -> tuple[np.ndarray, np.ndarray]:
    """Along the axis, of both places (n, 2), and lengths of arcs (n,), m."""
    count = len(a)
    given = [wp.array(np.float32(v), dtype=wp.vec3, device="cpu") for v in (a, b)]
    kind, arc = wp.zeros(count, dtype=int, device="cpu"), wp.zeros(count, dtype=float, device="cpu")
    places = [wp.zeros(count, dtype=wp.vec3, device="cpu") for _ in range(2)]
    wp.launch(touched, count, [*given, where, kind, *places, arc], device="cpu")
    assert np.all(kind.numpy() >= int(BESIDE))
    return np.stack([place.numpy()[:, 2] for place in places], axis=1), arc.numpy()


def test_an_arc_of_several_surfaces_is_unrolled_from_four_millimetres_on():
    """Of paths far up the axis, where the heights of both places together are no measure of how long the arc is."""
    sunk = np.linspace(2e-4, 8e-3, 40)[:, None]  # m, of the straight line below the top of the cylinder
    a = np.hstack([np.full_like(sunk, -0.07), RADIUS - sunk, np.full_like(sunk, 0.15)])
    b = np.hstack([np.full_like(sunk, 0.3), RADIUS - 0.5 * sunk, np.full_like(sunk, 0.30)])
    (flat, length), (among, _), (exact, _) = (heights(a, b, where) for where in (IN_PLANE, AMONG_OTHERS, EXACT))
    short = length < SHORT
    assert short.sum() > 5
    assert (~short).sum() > 5
    np.testing.assert_array_equal(among, np.where(short[:, None], flat, exact))
    assert np.abs(flat - exact)[short].max() > 1e-6


def test_a_place_slides_towards_where_leg_and_arc_rise_alike():
    """Its share of the whole rise is that of its leg's way along both together, by vectors; times OpenSim's factor."""
    random = np.random.default_rng(1)
    leg, flat, arc, chord = random.uniform(0.01, 0.2, (4, 30))
    ahead, angle = random.choice([-1.0, 1.0], 30), random.uniform(0.0, 1.0, 30)
    along = np.stack([flat, np.zeros(30)], axis=1)
    piece = (ahead * chord)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    share = np.sum(along * (along + piece), axis=1) / np.sum((along + piece) ** 2, axis=1)
    found = evaluate(slide, leg, flat, ahead, arc, chord, np.cos(angle))
    np.testing.assert_allclose(found, OVERSHOT * (share * (leg + arc) - leg), rtol=1e-3, atol=1e-5)
    assert evaluate(slide, 0.1, 0.2, 1.0, 0.05, 0.1, 1.0)[0] == 0.0  # both are as steep
