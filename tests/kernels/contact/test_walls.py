"""Spheres of a body beside walls: against the nearest points of a profile in float64, and thrown at a riser."""

import msgspec
import numpy as np
import pytest
import warp as wp
from test_terrain import BALL, G, block, ground

from warpmuscle.kernels.contact.walls import sphere_plane, ways_of
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Terrain
from warpmuscle.scene.terrain.tiles import Profile
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

CORNERS = [(0.0, 0.0), (0.02, 0.17), (0.4, 0.17), (0.42, -0.1), (0.8, -0.1), (0.84, 0.06), (1.2, 0.06)]
LINE = np.array([(-9.0, 0.0), *CORNERS, (9.0, 0.06)])


@wp.kernel(enable_backward=False)
def ask(model: Model, points: wp.array[wp.vec3], radius: float, planes: wp.array2d[wp.vec4]):
    i = wp.tid()
    m = model
    up, height, arm, point = wp.vec3(0.0, 1.0, 0.0), points[i][1], wp.vec3(0.0), points[i]
    beneath = ways_of(0, up, height, arm, point, radius, 0.0, m)
    for way in range(beneath.ways):
        plane = sphere_plane(0, way, beneath, up, height, arm, point, radius, 0.0, m)
        planes[i, way] = wp.vec4(plane.normal[0], plane.normal[1], plane.normal[2], plane.height)


def asked(terrain: Terrain, points: np.ndarray, radius: float) -> np.ndarray:
    """Normals of the five planes of spheres about these points, and distances from them, m: (n, 5, 4)."""
    model = Rollout(block(ground(terrain)), 1, "cpu").model
    planes = wp.full((len(points), 5), wp.vec4(9.0), dtype=wp.vec4, device="cpu")
    given = wp.array(points.astype(np.float32), dtype=wp.vec3, device="cpu")
    wp.launch(ask, len(points), [model, given, radius, planes], device="cpu")
    return planes.numpy().astype(float)


def over_a_wall(z: float) -> list[int]:
    """Number of the wall that a place is over, under which the ground at its foot goes on."""
    rising = np.abs(np.diff(LINE[:, 1])) > np.diff(LINE[:, 0])
    return [k for k in np.flatnonzero(rising) if LINE[k, 0] < z < LINE[k + 1, 0]]


def nearest_places(point: np.ndarray, radius: float) -> list[tuple[float, np.ndarray]]:
    """Distances, m, of all places of the line that are nearer to a point (z, y) than what is about them, and ways."""
    start, along = LINE[:-1], np.diff(LINE, axis=0)
    share = np.sum((point - start) * along, axis=1) / np.sum(along**2, axis=1)
    feet = (start + share[:, None] * along)[(share > 0.0) & (share < 1.0)]
    low = [LINE[k : k + 2, 1].min() for k in over_a_wall(point[0])]
    feet = np.concatenate([feet, [[point[0], y] for y in low]]) if low else feet
    edges = LINE[1:-1][(share[:-1] >= 1.0) & (share[1:] <= 0.0)]
    ways = point - np.concatenate([feet, edges])
    return [(float(far), way / far) for way in ways if (far := np.linalg.norm(way)) < 0.99 * radius]


@pytest.mark.parametrize(("yaw", "radius"), [(0.0, 0.03), (0.7, 0.1)])
def test_a_sphere_touches_all_places_of_the_ground_that_are_nearest(yaw: float, radius: float):
    random = np.random.default_rng(1)
    z = random.uniform(-0.2, 1.1, 1500)
    y = np.interp(z, *LINE.T) + random.uniform(0.001, radius, 1500)
    x = random.uniform(-1.0, 1.0, 1500)
    turned = np.stack([x * np.cos(yaw) + z * np.sin(yaw), y, z * np.cos(yaw) - x * np.sin(yaw)], axis=1)
    planes = asked(Terrain([Profile(CORNERS)], yaw=yaw), turned, radius)
    assert not np.any(planes[:, 3:, 3] < radius)  # no walls along x
    to_z = planes[..., 0] * np.sin(yaw) + planes[..., 2] * np.cos(yaw)
    beside = 0
    for k in range(len(z)):
        touched = sorted((planes[k, way, 3], to_z[k, way], planes[k, way, 1]) for way in range(5))
        touched = [one for one in touched if one[0] < 0.99 * radius]
        places = sorted(nearest_places(np.array([z[k], y[k]]), radius), key=lambda one: one[0])
        beside += any(abs(way[0]) > 0.9 for _, way in places)
        assert len(touched) == len(places), (z[k], y[k])
        for (far, *out), (true, way) in zip(touched, places, strict=True):
            assert far == pytest.approx(true, abs=1e-5)
            assert np.linalg.norm(far * np.array(out) - true * way) < 1e-5  # m, between places of touch
    assert beside > 50


def thrown(yaw: float, **start) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, s, and places along the way and up, m, of a ball that meets a riser 30 cm high at 0, without friction."""
    step = Terrain([Profile([(0.0, 0.0), (0.002, 0.3)], spacing=0.002)], z=0.4, yaw=yaw, clearing=0.0)
    forward = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
    hard = ground(step, damping=0.0, stiffness=2e5, tangential_damping=0.0)
    place = np.array([0.0, start["height"], 0.4]) - start["before"] * forward
    scene = block(hard, tuple(place), BALL, friction=0.0, duration=0.5, root_velocity=tuple(start["speed"] * forward))
    rollout = Rollout(msgspec.structs.replace(scene, time_step=5e-5), 1, "cpu", record=[0])
    rollout.run()
    path = rollout.recording()
    return path.time, (path.coordinate[:, :3] - (0.0, 0.0, 0.4)) @ forward, path.coordinate[:, 1]


@pytest.mark.parametrize("yaw", [0.0, 2.0])
def test_a_ball_thrown_at_a_riser_comes_back_with_its_energy(yaw: float):
    speed, radius = 1.5, 0.1
    time, along, height = thrown(yaw, height=0.25, before=0.2, speed=speed)
    assert along.max() == pytest.approx(-radius, abs=0.008)  # its spring gives way by 7.5 mm
    met = time[along.argmax()]
    assert met == pytest.approx((0.2 - radius) / speed, abs=0.02)
    late = (time > met + 0.02) & (time < met + 0.12)
    assert np.polyfit(time[late], along[late], 1)[0] == pytest.approx(-speed, rel=0.03)
    fallen = time < 0.15
    np.testing.assert_allclose(height[fallen], 0.25 - 0.5 * G * time[fallen] ** 2, atol=0.004)


def test_a_ball_in_a_corner_rests_on_the_tread_and_at_the_riser():
    _, along, height = thrown(0.0, height=0.1, before=0.099, speed=0.0)
    assert along[-1] < -0.099
    np.testing.assert_allclose(height, 0.1, atol=0.001)
