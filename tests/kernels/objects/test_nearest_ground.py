"""Balls beside walls, over edges and on bumps, against the nearest point of the ground in float64."""

import numpy as np
import pytest
import warp as wp

from objects_alone import together
from warpmuscle.kernels.objects.nearest_ground import nearest_ground
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Ground, Terrain
from warpmuscle.scene.terrain.tiles import Profile, Slope
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

CORNERS = [(0.0, 0.0), (0.02, 0.17), (0.6, 0.17), (0.62, -0.1), (0.9, -0.1), (1.1, 0.1), (1.3, 0.0)]
LINE = np.array([(-9.0, 0.0), *CORNERS, (9.0, 0.0)])
RADIUS = 0.1


@wp.kernel(enable_backward=False)
def ask(model: Model, points: wp.array[wp.vec3], radius: float, normals: wp.array[wp.vec3], far: wp.array[float]):
    i = wp.tid()
    m = model
    plane = nearest_ground(0, wp.vec3(0.0, 1.0, 0.0), points[i][1], wp.vec3(0.0), points[i], radius, m)
    normals[i] = plane.normal
    far[i] = plane.height


def asked(terrain: Terrain, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals of the planes that balls about these points touch first, and distances from them, m."""
    model = Rollout(together({}, ground=Ground(terrain=terrain)), 1, "cpu").model
    normals = wp.zeros(len(points), dtype=wp.vec3, device="cpu")
    far = wp.zeros(len(points), dtype=float, device="cpu")
    given = wp.array(points.astype(np.float32), dtype=wp.vec3, device="cpu")
    wp.launch(ask, len(points), [model, given, RADIUS, normals, far], device="cpu")
    return normals.numpy().astype(float), far.numpy().astype(float)


def from_line(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of points (N, 3) from the line of the ground, m, and unit vectors (N, 2), y and z, from it to them."""
    start, end, point = LINE[:-1], LINE[1:], points[:, None, [2, 1]]
    along = end - start
    share = np.clip(np.sum((point - start) * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    ways = point - start - share[..., None] * along
    lengths = np.linalg.norm(ways, axis=2)
    first = lengths.argmin(axis=1)
    rows = np.arange(len(points))
    return lengths[rows, first], (ways[rows, first] / lengths[rows, first, None])[:, ::-1]


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_a_ball_touches_the_ground_that_is_nearest(yaw):
    random = np.random.default_rng(1)
    z = random.uniform(-0.3, 1.6, 4000)
    high = np.interp(z, *LINE.T) + random.uniform(0.001, 0.3, 4000)
    points = np.stack([random.uniform(-1.0, 1.0, 4000), high, z], axis=1)
    true, ways = from_line(points)
    turned = points.copy()
    turned[:, 0] = points[:, 0] * np.cos(yaw) + points[:, 2] * np.sin(yaw)
    turned[:, 2] = points[:, 2] * np.cos(yaw) - points[:, 0] * np.sin(yaw)
    normals, far = asked(Terrain([Profile(CORNERS)], yaw=yaw), turned)
    touches = true < RADIUS
    assert touches.sum() > 1000
    off = np.abs(far - true)[touches]
    assert np.quantile(off, 0.99) < 0.01 * RADIUS
    assert off.max() < 0.05 * RADIUS
    assert far[true > 1.05 * RADIUS].min() > RADIUS
    to_z = normals[:, 0] * np.sin(yaw) + normals[:, 2] * np.cos(yaw)
    turned_by = np.arccos(np.clip(normals[:, 1] * ways[:, 0] + to_z * ways[:, 1], -1.0, 1.0))
    far_from_ground = touches & (true > 0.5 * RADIUS)
    assert np.quantile(turned_by[far_from_ground], 0.95) < 0.1


def test_a_slope_is_the_plane_that_it_was():
    points = np.array([[0.3, 0.5, 1.0], [0.0, 0.05, 0.2]])
    normals, far = asked(Terrain([Slope(0.3)]), points)
    up = np.array([0.0, np.cos(0.3), -np.sin(0.3)])
    np.testing.assert_allclose(normals, [up, up], atol=1e-6)
    np.testing.assert_allclose(far, points @ up, atol=1e-6)
