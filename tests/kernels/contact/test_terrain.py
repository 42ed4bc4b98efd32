"""Ground that is not flat: the kernels' surface against float64, and bodies on it against closed forms."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, units, vectors

from warpmuscle.core.pose import about
from warpmuscle.kernels.contact import terrain
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Body, Box, Character, Failure, Ground, InitialState, Scene, Sphere, Terrain
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Flat, Patch, Rough, Slope, Stairs, Stones, Waves
from warpmuscle.simulation.rollout import Rollout

X, G = (1.0, 0.0, 0.0), 9.8
SLOPE = 0.15
BOX, BALL = Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)), Sphere((0.0, 0.0, 0.0), 0.1)
TILES = [Flat(), Slope(SLOPE), Stairs(), Rough(seed=1), Stones(height=0.05), Waves(0.1, 1.0, across=1.3)]


def block(ground: Ground, place=(0.0, 0.15, 0.0), shape=BOX, friction=0.5, duration=1.0, **start) -> Scene:
    """A single body in a simulation without failure."""
    body = Body(5.0, (0.05, 0.05, 0.05), [shape], friction=friction)
    failure = Failure(com_height=0.0, heading=0.0)
    character = Character("block", {"block": body})
    initial = InitialState(place, **start)
    return Scene(
        "block", character, initial_state=initial, ground=ground, failure=failure, duration=duration, time_step=0.0005
    )


def ground(terrain: Terrain | None = None, **values) -> Ground:
    return Ground(**({"stiffness": 1e5, "damping": 1e3, "tangential_damping": 1e4, "terrain": terrain} | values))


def motion(scene: Scene, instances: int = 1, of: int = 0) -> np.ndarray:
    rollout = Rollout(scene, instances, "cpu", record=[of])
    rollout.run()
    return rollout.recording(of).coordinate


@wp.kernel(enable_backward=False)
def ask(model: Model, points: wp.array[wp.vec3], above: wp.array[float], rise: wp.array[wp.vec3]):
    i = wp.tid()
    m = model
    above[i] = terrain.above_terrain(i, points[i], m)
    rise[i] = terrain.rise_at(i, points[i][0], points[i][2], m)


@pytest.mark.parametrize("number", range(len(TILES)))
def test_height_and_slope_are_those_of_the_tile_where_it_lies(number: int):
    tile = Terrain(TILES, tile=float(number), scale=0.7, x=0.4, z=-0.3, yaw=0.6)
    plane = ground(tile, normal=(0.1, 1.0, -0.2), height=0.3)
    rollout = Rollout(block(plane), 1, "cpu")
    points = np.random.default_rng(number).uniform(-3.0, 3.0, (500, 3)).astype(np.float32)
    given = wp.array(points, dtype=wp.vec3, device="cpu")
    above, rise = wp.zeros(500, dtype=float, device="cpu"), wp.zeros(500, dtype=wp.vec3, device="cpu")
    wp.launch(ask, 500, [rollout.model, given, above, rise], device="cpu")
    truth = surface(plane)
    x, y, z = points.astype(float).T
    expected = np.stack(truth.lie.rise(x, z), axis=1)
    steep = 1e-3 * np.abs(expected).max() + 1e-6  # beside an edge, single precision may be on its other side
    wrong = np.abs(rise.numpy() - expected).max(axis=1) > steep
    assert wrong.mean() < 0.01
    height = (y - truth.height_at(x, z)) * truth.plane.normal[1]
    np.testing.assert_allclose(above.numpy()[~wrong], height[~wrong], atol=1e-3 * 0.7)
    np.testing.assert_allclose(np.median(np.abs(above.numpy() - height)), 0.0, atol=2e-6)


def test_bilinear_heights_and_derivatives_are_those_of_the_polynomial():
    a, b, c, d, s, t = np.random.default_rng(0).normal(size=(6, 200))
    got = evaluate(terrain.bilinear, a, b, c, d, s, t)
    np.testing.assert_allclose(got[:, 0], a + s * (b - a) + t * (c - a) + s * t * (d - c - b + a), atol=3e-6)
    np.testing.assert_allclose(got[:, 1], (b - a) + t * (d - c - b + a), atol=3e-6)
    np.testing.assert_allclose(got[:, 2], (c - a) + s * (d - c - b + a), atol=3e-6)


def test_a_place_beyond_a_period_is_one_within_it():
    cells = np.random.default_rng(0).uniform(-50.0, 50.0, 300)
    np.testing.assert_allclose(evaluate(terrain.wrapped, cells, 7.0), np.mod(cells, 7.0), atol=1e-5)
    np.testing.assert_allclose(evaluate(terrain.wrapped, cells, 0.0), cells, rtol=1e-6)


@wp.func
def footing_numbers(normal: wp.vec3, height: float, arm: wp.vec3, rise: wp.vec3) -> wp.vec4:
    f = terrain.footing(normal, height, arm, rise)
    return wp.vec4(f.normal[0], f.normal[1], f.normal[2], f.height)


def test_the_plane_below_a_point_touches_the_surface_there():
    normal, arm = units(300), vectors(300, 1, 0.2)
    normal[:, 1] = np.abs(normal[:, 1]) + 0.5
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    rise, joint = vectors(300, 2, 0.3), vectors(300, 3)
    height = np.sum(normal * joint, axis=1) - 0.2
    got = evaluate(footing_numbers, normal, height, arm, rise)
    point = joint + arm
    level = (0.2 - normal[:, 0] * point[:, 0] - normal[:, 2] * point[:, 2]) / normal[:, 1] + rise[:, 0]
    steep = np.stack(
        [normal[:, 0] / normal[:, 1] - rise[:, 1], np.ones(300), normal[:, 2] / normal[:, 1] - rise[:, 2]], 1
    )
    n = steep / np.linalg.norm(steep, axis=1, keepdims=True)
    below = np.stack([point[:, 0], level, point[:, 2]], axis=1)
    np.testing.assert_allclose(got[:, :3], n, atol=2e-6)
    np.testing.assert_allclose(got[:, 3], np.sum(n * (joint - below), axis=1), atol=1e-5)


@pytest.mark.parametrize("law", ["spring", "soft_constraint", "hunt_crossley", "smooth_hunt_crossley"])
def test_a_flat_tile_gives_the_bytes_of_the_plane(law: str):
    shape = BOX if law in ("spring", "soft_constraint") else BALL
    plane = (0.1, 1.0, -0.15)  # also where the plane is inclined
    start = {"root_velocity": (0.3, 0.0, 1.0), "root_orientation": tuple(about(X, 0.3))}
    scenes = [
        block(ground(which, law=law, normal=plane), (0.3, 0.25, 0.1), shape, duration=0.4, **start)
        for which in (None, Terrain([Flat()], x=0.3, yaw=0.7), Terrain([Rough()], scale=0.0))
    ]
    flat, tile, level = map(motion, scenes)
    assert flat[-1, 1] < 0.2  # has come down
    assert tile.tobytes() == flat.tobytes() == level.tobytes()


@pytest.mark.parametrize("yaw", [0.0, 1.1])
def test_a_slope_tile_is_what_an_inclined_plane_is(yaw: float):
    """To 1e-5 of what a body has moved: an inclined plane is what tilted gravity is to a level one."""
    rise = np.tan(SLOPE)
    normal = (-rise * np.sin(yaw), 1.0, -rise * np.cos(yaw))
    start = {"root_velocity": (0.5, 0.0, 1.0)}
    lie = Terrain([Slope(SLOPE)], x=0.2, z=-0.1, yaw=yaw, clearing=0.0)
    below = surface(ground(lie)).height_at(0.0, 0.0)
    tile = motion(block(ground(lie), (0.0, 0.15, 0.0), friction=0.1, **start))
    through = (normal[0] * 0.2 - normal[2] * 0.1) / np.linalg.norm(normal)
    plane = motion(block(ground(normal=normal, height=through), (0.0, 0.15 + float(below), 0.0), friction=0.1, **start))
    moved = np.linalg.norm(plane[-1, :3] - plane[0, :3])
    assert moved > 0.2
    np.testing.assert_allclose(tile, plane, atol=1e-5 * moved, rtol=0.0)


def test_a_box_slides_down_a_slope_as_coulomb_says():
    """g (sin a - mu cos a) along the slope, from when it has come to rest on it."""
    friction = 0.1
    tilt = tuple(about(X, -SLOPE))
    place = (0.0, 0.1 / np.cos(SLOPE) - 1e-4, 0.0)
    tile = Terrain([Slope(SLOPE)], clearing=0.0)
    rollout = Rollout(block(ground(tile), place, friction=friction, root_orientation=tilt), 1, "cpu", record=[0])
    rollout.run()
    path = rollout.recording()
    late = path.time > 0.25
    along = path.coordinate[late, :3] @ np.array([0.0, np.sin(SLOPE), np.cos(SLOPE)])
    acceleration = 2.0 * np.polyfit(path.time[late], along, 2)[0]
    assert acceleration == pytest.approx(-G * (np.sin(SLOPE) - friction * np.cos(SLOPE)), rel=0.003)


def test_a_ball_without_friction_goes_as_high_as_it_came_from():
    """In a valley 0.2 m deep, without damping: what it loses is the bounce at its start, a fall of 1 cm."""
    valley = Waves(0.2, length=4.0, points=400)
    hard = ground(Terrain([valley], clearing=0.0), damping=0.0, stiffness=1e6)
    path = motion(block(hard, (0.0, 0.11, -2.0), BALL, friction=0.0, duration=3.0))
    turn = path[:, 2].argmax()
    assert path[turn, 2] == pytest.approx(0.0, abs=0.02)
    assert path[turn, 1] == pytest.approx(0.1, abs=0.01)
    assert path[:, 1].min() == pytest.approx(-0.1, abs=0.01)


def test_a_slippery_patch_has_less_friction_and_a_soft_one_is_deeper():
    start = {"root_velocity": (0.0, 0.0, 1.5)}
    ice = Patch((-1.0, 1.0), (0.2, 5.0), friction=0.02)
    paths = [
        motion(block(ground(Terrain([Flat(patches=patches)])), (0.0, 0.0999, 0.0), duration=1.0, **start))
        for patches in ([Patch((5.0, 6.0), (5.0, 6.0))], [ice])
    ]
    stops = 1.5**2 / (2.0 * 0.5 * G)
    assert paths[0][-1, 2] == pytest.approx(stops, abs=0.01)
    assert paths[1][-1, 2] > 2.0 * stops
    soft = Terrain([Flat(patches=[Patch((-1.0, 1.0), (-1.0, 1.0), stiffness=0.05)])])
    depths = 0.1 - motion(block(ground(soft), (0.0, 0.0999, 0.0), duration=1.0))[-1, 1]
    assert depths == pytest.approx(5.0 * G / (4.0 * 0.05 * 1e5), rel=0.05)


def test_instances_on_ground_of_their_own_do_not_see_each_other():
    """Tile, place, turn and scale by instance give the bytes of scenes that say the same alone."""
    number = [
        {"tile": float(k % 6), "x": 0.1 * k, "z": -0.2 * k, "yaw": 0.3 * k, "scale": 1.0 - 0.1 * k} for k in range(8)
    ]
    several = {name: np.array([one[name] for one in number]) for name in number[0]}
    start = {"root_velocity": (0.2, 0.0, 1.0)}
    scene = block(ground(Terrain(TILES)), duration=0.3, **start)
    rollout = Rollout(scene, 8, "cpu", record=list(range(8)))
    rollout.change(block(ground(Terrain(TILES, **several)), duration=0.3, **start))
    rollout.reset()
    rollout.run()
    for k, one in enumerate(number):
        alone = motion(block(ground(Terrain(TILES, **one)), duration=0.3, **start))
        assert rollout.recording(k).coordinate.tobytes() == alone.tobytes()


def test_a_start_is_raised_by_the_highest_ground_about_the_root():
    scene = block(ground(Terrain([Stairs(0.2, start=0.1, count=1)], clearing=0.25)))
    assert Rollout(scene, 1, "cpu").state.coordinates.numpy()[0, 1] == pytest.approx(0.35)
    far = block(ground(Terrain([Stairs(0.2, start=0.5, count=1)], clearing=0.25)))
    assert Rollout(far, 1, "cpu").state.coordinates.numpy()[0, 1] == pytest.approx(0.15)


@wp.kernel(enable_backward=False)
def ask_anywhere(model: Model, points: wp.array[wp.vec3], above: wp.array[float]):
    i = wp.tid()
    m = model
    above[i] = terrain.above_surface(i, points[i], m)


@pytest.mark.parametrize("lie", [None, Terrain(TILES, tile=3.0, yaw=0.2)])
def test_functions_of_users_learn_how_high_a_point_is_above_any_ground(lie: Terrain | None):
    which = ground(lie, normal=(0.1, 1.0, 0.2), height=0.1)
    points = np.random.default_rng(2).uniform(-2.0, 2.0, (50, 3)).astype(np.float32)
    above = wp.zeros(50, dtype=float, device="cpu")
    model = Rollout(block(which), 1, "cpu").model
    wp.launch(ask_anywhere, 50, [model, wp.array(points, dtype=wp.vec3, device="cpu"), above], device="cpu")
    x, y, z = points.astype(float).T
    found = surface(which)
    np.testing.assert_allclose(above.numpy(), (y - found.height_at(x, z)) * found.plane.normal[1], atol=1e-5)


def test_places_that_are_no_numbers_are_asked_for_without_harm():
    rollout = Rollout(block(ground(Terrain(TILES, tile=3.0))), 1, "cpu")
    points = np.array([[np.nan, 0, 0], [np.inf, 0, -np.inf], [1e30, 0, -1e30]], dtype=np.float32)
    above, rise = wp.zeros(3, dtype=float, device="cpu"), wp.zeros(3, dtype=wp.vec3, device="cpu")
    wp.launch(ask, 3, [rollout.model, wp.array(points, dtype=wp.vec3, device="cpu"), above, rise], device="cpu")
    assert above.shape == (3,)
