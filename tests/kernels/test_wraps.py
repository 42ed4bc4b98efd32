"""Segments round surfaces on the device against the same in float64, and against what is known in closed form."""

import math

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.wrap_cylinder import cylinder_touch
from warpmuscle.kernels.wrap_sphere import sphere_touch
from warpmuscle.kernels.wrap_touch import BESIDE, FREE, INSIDE, Touch
from warpmuscle.scene import CylinderSurface, SphereSurface, Surface
from warpmuscle.scene.wrapping.route import half_of, touch

SIDES = ["", "+x", "-x", "+y", "-y", "+z", "-z"]
ZERO = (0.0, 0.0, 0.0)


@wp.kernel
def touches(
    a: wp.array[wp.vec3], b: wp.array[wp.vec3], sphere: int, radius: float, length: float, axis: int, side: int,
    exact: int, result: wp.array[Touch],
):  # fmt: skip
    i = wp.tid()
    if sphere == 1:
        result[i] = sphere_touch(a[i], b[i], radius, axis, side)
    else:
        result[i] = cylinder_touch(a[i], b[i], radius, length, axis, side, exact != 0)


def ends(count: int, seed: int = 0) -> np.ndarray:
    """Ends of segments (2, n, 3), m, some of them inside a radius of 30 mm, as float32 has them."""
    return np.random.default_rng(seed).normal(size=(2, count, 3), scale=0.05).astype(np.float32).astype(float)


def on_device(surface: Surface, a: np.ndarray, b: np.ndarray, exact: bool) -> np.ndarray:
    result = wp.zeros(len(a), dtype=Touch, device="cpu")
    axis, side = half_of(surface)
    given = [wp.array(v.astype(np.float32), dtype=wp.vec3, device="cpu") for v in (a, b)]
    sphere, length = isinstance(surface, SphereSurface), getattr(surface, "length", 0.0)
    inputs = [*given, int(sphere), surface.radius, length, axis, side, int(exact)]
    wp.launch(touches, len(a), inputs, [result], device="cpu")
    return result.numpy()


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(
    ("make", "exact"),
    [
        (lambda side: CylinderSurface("b", ZERO, 0.03, 0.2, side=side), False),
        (lambda side: CylinderSurface("b", ZERO, 0.03, 0.2, side=side), True),
        (lambda side: SphereSurface("b", ZERO, 0.03, side=side), False),
    ],
    ids=["cylinder", "shortest round a cylinder", "sphere"],
)
def test_segments_go_round_as_in_float64(make, exact: bool, side: str):
    surface, (a, b) = make(side), ends(3000)
    got = on_device(surface, a, b, exact)
    expected = [touch(surface, exact, *pair) for pair in zip(a, b, strict=True)]
    same = got["kind"] == [one.kind for one in expected]
    assert np.mean(same) > 0.999  # the others begin to touch just there
    assert len(set(got["kind"])) >= (3 if side else 2)
    touching = np.flatnonzero(same & (got["kind"] >= BESIDE))
    assert len(touching) > 200
    off = np.array([abs(got["arc"][i] - expected[i].length) for i in touching])
    assert np.quantile(off, 0.995) < 2e-6
    places = np.array([[expected[i].first, expected[i].second] for i in touching])
    away = np.abs(np.stack([got["first"], got["second"]], axis=1)[touching] - places).max(axis=(1, 2))
    assert np.quantile(away, 0.99) < 1e-5


def test_a_quarter_of_a_cylinder_is_as_long_as_it_should_be():
    surface = CylinderSurface("b", ZERO, 0.03, 0.2, side="+x")
    a, b = np.array([[0.03, -0.1, 0.02]]), np.array([[-0.1, 0.03, 0.05]])
    (got,) = on_device(surface, a, b, True)
    slope = 0.03 / (0.2 + 0.03 * math.pi / 2.0)
    assert got["kind"] == BESIDE
    assert got["arc"] == pytest.approx(0.03 * math.pi / 2.0 * math.hypot(1.0, slope), abs=1e-7)
    np.testing.assert_allclose(got["first"], [0.03, 0.0, 0.02 + 0.1 * slope], atol=1e-7)
    np.testing.assert_allclose(got["second"], [0.0, 0.03, 0.05 - 0.1 * slope], atol=1e-7)


def test_nothing_touches_beyond_the_ends_of_a_cylinder_or_from_inside():
    surface = CylinderSurface("b", ZERO, 0.03, 0.02)
    far = on_device(surface, np.array([[0.01, -0.1, 0.02]]), np.array([[0.01, 0.1, 0.03]]), False)
    inside = on_device(surface, np.array([[0.01, -0.02, 0.0]]), np.array([[0.01, 0.1, 0.0]]), False)
    assert [far["kind"][0], inside["kind"][0]] == [FREE, INSIDE]


def test_the_shortest_way_round_a_cylinder_is_not_longer_than_opensims():
    surface, (a, b) = CylinderSurface("b", ZERO, 0.03, 0.2), ends(3000)
    lengths = []
    for exact in (False, True):
        got = on_device(surface, a, b, exact)
        legs = np.linalg.norm(got["first"] - a, axis=1) + np.linalg.norm(got["second"] - b, axis=1)
        lengths.append(np.where(got["kind"] >= BESIDE, legs + got["arc"], 0.0))
    touching = lengths[0] > 0.0
    assert np.all(lengths[1] <= lengths[0] + 1e-6)
    assert np.max(lengths[0][touching] - lengths[1][touching]) > 1e-4
