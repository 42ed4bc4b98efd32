"""Contacts at edges: nothing touches a riser that is not beside it, and what is pressed into one is pushed back."""

import numpy as np
import warp as wp

from warpmuscle.kernels.contact import terrain
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Scene, Sphere, Terrain
from warpmuscle.scene.terrain.tiles import Stairs
from warpmuscle.simulation.rollout import Rollout

RISE, TREAD, RISER, START, COUNT = 0.17, 0.34, 0.02, 0.5, 3
CORNERS = [(-9.0, 0.0)]  # of the ground, (z, y): risers begin before the edges of their stairs
for step in range(COUNT):
    CORNERS += [(START + step * TREAD - RISER, step * RISE), (START + step * TREAD, (step + 1) * RISE)]
GROUND = np.array([*CORNERS, (9.0, COUNT * RISE)])


def over_stairs() -> Model:
    """A model whose ground is stairs without a way down."""
    ground = Ground(terrain=Terrain([Stairs(RISE, TREAD, COUNT, start=START, riser=RISER, returns=False)]))
    ball = Character("ball", {"ball": Body(1.0, (0.01, 0.01, 0.01), [Sphere((0.0, 0.0, 0.0), 0.05)])})
    fails = Failure(com_height=0.0, heading=0.0)
    scene = Scene("ball", ball, initial_state=InitialState((0.0, 1.0, 0.0)), ground=ground, failure=fails)
    return Rollout(scene, 1, "cpu").model


@wp.kernel(enable_backward=False)
def ask(model: Model, points: wp.array[wp.vec3], radius: float, normals: wp.array[wp.vec3], far: wp.array[float]):
    i = wp.tid()
    m = model
    below = terrain.nearest_footing(0, wp.vec3(0.0, 1.0, 0.0), points[i][1], wp.vec3(0.0), points[i], radius, m)
    normals[i] = below.normal
    far[i] = below.height


def planes(points: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Normals of the planes that spheres about these points have to do with, and distances from them, m."""
    n = len(points)
    normals, far = wp.zeros(n, dtype=wp.vec3, device="cpu"), wp.zeros(n, dtype=float, device="cpu")
    given = wp.array(points.astype(np.float32), dtype=wp.vec3, device="cpu")
    wp.launch(ask, n, [over_stairs(), given, radius, normals, far], device="cpu")
    return normals.numpy().astype(float), far.numpy().astype(float)


def from_ground(points: np.ndarray) -> np.ndarray:
    """Distance of points from the line of the ground, m, in float64."""
    start, end, point = GROUND[:-1], GROUND[1:], points[:, None, [2, 1]].astype(float)
    along = end - start
    share = np.clip(np.sum((point - start) * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(point - start - share[..., None] * along, axis=2).min(axis=1)


def height_at(z: np.ndarray) -> np.ndarray:
    return np.interp(z, GROUND[:, 0], GROUND[:, 1])


def drawn(count: int, low: float, high: float, seed: int) -> np.ndarray:
    """Points so far above the ground about the stairs."""
    random = np.random.default_rng(seed)
    z = random.uniform(START - 0.3, START + COUNT * TREAD, count)
    return np.stack([np.zeros(count), height_at(z) + random.uniform(low, high, count), z], axis=1)


def test_a_sphere_above_the_ground_touches_it_only_where_it_is_near():
    radius = 0.05
    points = drawn(4000, 0.0, 0.6, 1)
    _, far = planes(points, radius)
    true = from_ground(points)
    touches = far < radius
    assert touches.sum() > 200
    assert true[touches].max() < np.hypot(radius, RISER)  # half of it may be over a riser, the other half beside
    over_a_riser = np.any(
        np.abs(points[:, 2:] - (START - 0.5 * RISER + TREAD * np.arange(COUNT))) < 0.4 * RISER, axis=1
    )
    high = over_a_riser & (true > 0.1)
    assert high.sum() > 50
    assert not touches[high].any()


def test_a_point_that_is_pressed_into_a_riser_is_pushed_back():
    edge = START + TREAD
    behind = np.random.default_rng(2).uniform(0.002, 0.03, 300)  # m, past the edge, inside the stair
    below = np.random.default_rng(3).uniform(0.05, 0.12, 300)  # m, under the tread
    points = np.stack([np.zeros(300), 2.0 * RISE - below, edge + behind], axis=1)
    normals, far = planes(points, 0.0)
    riser = np.array([0.0, RISER, -RISE]) / np.hypot(RISER, RISE)
    depth = np.sum((points - [0.0, 2.0 * RISE, edge]) * riser, axis=1)  # from the riser's plane, in float64
    sideways = -depth < below
    assert sideways.sum() > 250
    np.testing.assert_allclose(normals[sideways], np.broadcast_to(riser, (sideways.sum(), 3)), atol=1e-4)
    np.testing.assert_allclose(far[sideways], depth[sideways], atol=1e-4)


def test_a_point_that_hardly_sinks_in_has_the_ground_right_below():
    points = drawn(2000, -0.019, 0.0, 4)
    normals, far = planes(points, 0.0)
    flat = normals[:, 1] > 0.999
    assert flat.mean() > 0.9
    np.testing.assert_allclose(far[flat], (points[:, 1] - height_at(points[:, 2]))[flat], atol=1e-5)
