"""Where OpenSim has a path touch an ellipsoid: the search of the host, on a device, and lengths of OpenSim 4.6."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, vectors

from warpmuscle.kernels.path import wrap_ellipsoid
from warpmuscle.kernels.path.ellipsoid_tangent import tangent_as_opensim
from warpmuscle.kernels.path.wrap_touch import Touch
from warpmuscle.scene.wrapping.ellipsoid import ellipsoid_touch
from warpmuscle.scene.wrapping.ellipsoid_tangent import tangent_of

RADII = np.array([0.9, 0.6, 1.5])


def cases(count: int) -> tuple[np.ndarray, ...]:
    """Ends outside the ellipsoid, places on it, and normals of planes through both."""
    end = vectors(count, 21)
    end *= (1.3 / np.sqrt(np.sum((end / RADII) ** 2, axis=1)) + 0.3)[:, None]
    start = vectors(count, 22)
    start /= np.sqrt(np.sum((start / RADII) ** 2, axis=1))[:, None]
    normal = np.cross(end, start) + 0.2 * vectors(count, 23)
    normal -= (end - start) * (np.sum(normal * (end - start), axis=1) / np.sum((end - start) ** 2, axis=1))[:, None]
    return end, start, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_the_place_is_on_the_ellipsoid_in_the_plane_and_its_tangent_plane_has_the_end():
    end, start, normal = cases(200)
    found = np.array([tangent_of(a, s, RADII, n, s) for a, s, n in zip(end, start, normal, strict=True)], dtype=float)
    on = np.sum((found / RADII) ** 2, axis=1) - 1.0
    off = np.stack([on, np.sum(normal * (found - start), axis=1), np.sum(found * end / RADII**2, axis=1) - 1.0])
    assert np.mean(np.abs(off).max(axis=0) < 3e-4) > 0.97
    got = evaluate(tangent_as_opensim, end, start, RADII, normal, start, end)
    assert np.mean(np.linalg.norm(got - found, axis=1) < 1e-4) > 0.95


def test_an_end_on_the_ellipsoid_is_its_own_place():
    end = np.array([0.9, 0.0, 0.0])
    start, normal = np.array([0.0, 0.6, 0.0]), np.array([0.0, 0.0, 1.0])
    np.testing.assert_array_equal(tangent_of(end, start, RADII, normal, start), end)
    np.testing.assert_allclose(evaluate(tangent_as_opensim, end, start, RADII, normal, start, end)[0], end, atol=1e-7)


SEGMENTS = [  # between two places, m, and how long OpenSim 4.6 makes it round an ellipsoid of 35, 20 and 25 mm, side +x
    ((-0.0772, -0.0446, 0.016), (0.0566, 0.0542, 0.0248), 0.16749322426962493),  # 51 mm longer from the usual tangents
    ((0.0398, -0.0255, 0.0353), (-0.074, 0.0116, -0.0071), 0.19640596879838781),  # 45 mm shorter
    ((0.0497, -0.0161, 0.0509), (-0.0368, -0.0017, 0.0063), 0.15492891887388335),  # 22 mm shorter
]
touch_as_opensim = wrap_ellipsoid.ellipsoid_touch_of(False, True)


@wp.kernel(enable_backward=False)
def touches(a: wp.array[wp.vec3], b: wp.array[wp.vec3], r: wp.vec3, method: int, result: wp.array[Touch]):
    i = wp.tid()
    result[i] = touch_as_opensim(a[i], b[i], r, 0, 1, method)


@pytest.mark.parametrize("on_device", [False, True])
def test_where_opensim_finds_the_other_tangent_or_the_long_way_so_do_we(on_device: bool):
    a, b, radii = np.array([one[0] for one in SEGMENTS]), np.array([one[1] for one in SEGMENTS]), (0.035, 0.02, 0.025)
    if on_device:
        given = [wp.array(np.float32(v), dtype=wp.vec3, device="cpu") for v in (a, b)]
        result = wp.zeros(len(a), dtype=Touch, device="cpu")
        wp.launch(touches, len(a), [*given, wp.vec3(*radii), wrap_ellipsoid.HYBRID], [result], device="cpu")
        found = result.numpy()
        first, second, arc = found["first"], found["second"], found["arc"]
    else:
        both = [
            ellipsoid_touch(*ends, np.array(radii), 0, 1, "hybrid", as_opensim=True) for ends in zip(a, b, strict=True)
        ]
        first, second = (np.array([getattr(one, name) for one in both]) for name in ("first", "second"))
        arc = np.array([one.length for one in both])
    length = np.linalg.norm(first - a, axis=1) + arc + np.linalg.norm(second - b, axis=1)
    np.testing.assert_allclose(length, [one[2] for one in SEGMENTS], rtol=0.0, atol=1e-4 if on_device else 1e-9)
