"""Ground contact: the laws of a point, bodies at rest, the friction cone, and stability."""

import numpy as np
import pytest
import warp as wp
from probes import cross_matrix, evaluate, filled, units, vectors

from warpmuscle.core.pose import about, rotate
from warpmuscle.kernels.contact import contact
from warpmuscle.kernels.structs import Model, ModelRef, Scratch, ScratchRef, Skeleton
from warpmuscle.scene import Body, Box, Capsule, Character, Failure, Ground, InitialState, Scene, Shape, Sphere, Terrain
from warpmuscle.scene.terrain.tiles import Flat, Patch
from warpmuscle.simulation.stages import Stages

X, ZERO = (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)
G, MASS, HALF = 9.8, 5.0, 0.1
STIFFNESS, DAMPING, TANGENTIAL = 1e5, 1e3, 1e4
BOX = Box((-HALF, -HALF, -HALF), (HALF, HALF, HALF))
SHAPES = {
    "box": (BOX, HALF),
    "sphere": (Sphere(ZERO, HALF), HALF),
    "capsule": (Capsule((-0.3, 0.0, 0.0), (0.3, 0.0, 0.0), 0.05), 0.05),
}


@wp.func
def pressed(instance: int, body: int, step: int, model: ModelRef, work: ScratchRef) -> contact.ContactSum:
    total = contact.ContactSum()
    if body > 1:
        total.force = wp.vec3(0.0, 5.0, 1.0)
        total.moment = wp.vec3(0.3, 0.0, 0.0)
        total.b = wp.identity(n=3, dtype=float) * 2.0
    return total


stand = contact.contact_stage_of(pressed)


@wp.kernel(enable_backward=False)
def stand_up(count: int, model: Model, work: Scratch):
    its = work
    for body in range(count):
        stand(0, body, 0, model, its)


@pytest.mark.parametrize(("count", "touched"), [(3, 0), (4, 1)])
def test_feet_keep_the_force_of_this_step_alone_and_other_bodies_touch_the_ground(count: int, touched: int):
    """Two feet in the air, of which one has no points, then a foot and a body that is none on the ground."""
    plan = {"foot_slot": [0, 1, 2, -1], "first_point": [0, 0, 1, 2], "end_point": [0, 1, 2, 3]}
    model = filled(Model, skeleton=filled(Skeleton, plan=plan))
    stale, six = np.full((4, 3), 7.0, np.float32), np.full((4, 6), 7.0, np.float32)
    tensor = np.full((4, 3, 3), 7.0, np.float32)
    work = filled(
        Scratch, flags=np.zeros(2, np.int32), contact_force=stale.copy(), contact_b=tensor.copy(), contact_c=six.copy(),
        block_a=six.copy(), block_b=tensor.copy(), block_c=six.copy(), bias_moment=stale.copy(),
        bias_force=stale.copy(),
    )  # fmt: skip
    wp.launch(stand_up, 1, [count, model, work], device="cpu")
    np.testing.assert_allclose(work.contact_force.numpy(), [[0, 0, 0], [0, 0, 0], [0, 5, 1], [7, 7, 7]])
    np.testing.assert_allclose(work.contact_b.numpy()[:3, 0, 0], [0, 0, 2])
    np.testing.assert_allclose(work.contact_c.numpy()[:3], 0.0)
    np.testing.assert_allclose(work.bias_force.numpy()[:3], [[7, 7, 7], [7, 7, 7], [7, 2, 6]])
    np.testing.assert_allclose(work.bias_moment.numpy()[:3, 0], [7, 7, 6.7], rtol=1e-6)
    np.testing.assert_allclose(work.block_b.numpy()[:3, 0, 0], [7, 7, 9])
    assert work.flags.numpy().tolist() == [touched, 0]


def block(shape: Shape, height: float, ground: Ground | None = None, slope: float = 0.0, **start) -> Stages:
    """A single body in a simulation without failure; the ground may slope down along z."""
    ground = ground or Ground(stiffness=STIFFNESS, damping=DAMPING, tangential_damping=TANGENTIAL)
    ground.normal = (0.0, np.cos(slope), np.sin(slope))
    body = Body(MASS, (0.05, 0.05, 0.05), [shape], friction=0.5)
    place = tuple(height * np.array(ground.normal))
    start = InitialState(place, tuple(about(X, slope)), **start)
    failure = Failure(com_height=0.0, heading=0.0)
    scene = Scene("block", Character("block", {"block": body}), initial_state=start, ground=ground, failure=failure)
    return Stages(scene, 1, "cpu")


def position(stages: Stages) -> np.ndarray:
    return stages.forward_kinematics()["position"][0, 0].astype(float)


def velocity(stages: Stages) -> np.ndarray:
    return stages.forward_kinematics()["velocity"][0, 0].astype(float)


def test_normal_force_is_that_of_a_spring_and_damper_a_step_ahead_and_never_pulls():
    depth, speed = np.random.default_rng(0).normal(size=(2, 200)) * [[0.01], [0.3]]
    force = evaluate(contact.normal_force, depth, speed, 1e5, 1e3, 0.0005)
    ahead = 1e5 * (depth - 0.0005 * speed) - 1e3 * speed
    np.testing.assert_allclose(force, np.maximum(ahead, 0.0), atol=1e-3)


def test_friction_is_viscous_up_to_the_coulomb_limit():
    normal, slip = np.random.default_rng(0).uniform([[0.0], [0.0]], [[500.0], [0.1]], (2, 200))
    force = evaluate(contact.friction_damping, normal, slip, 1e4, 0.8) * slip
    np.testing.assert_allclose(force, np.minimum(1e4 * slip, 0.8 * normal), rtol=1e-5, atol=1e-5)


def test_contact_tensor_acts_along_the_normal_and_across():
    n, v = units(100), vectors(100, 1)
    s = evaluate(contact.contact_tensor, n, 7.0, 2.0)
    dense = s[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    along = np.sum(n * v, axis=1, keepdims=True) * n
    np.testing.assert_allclose(np.einsum("nij,nj->ni", dense, v), 7.0 * along + 2.0 * (v - along), atol=1e-5)


def test_angular_block_of_a_contact_is_its_tensor_moved_to_the_joint():
    r, n = vectors(100), units(100, 1)
    k = 2.0 * np.eye(3) + 5.0 * n[:, :, None] * n[:, None, :]
    arm = cross_matrix(r)
    expected = arm @ k @ arm.swapaxes(1, 2)
    got = evaluate(contact.minus_skew_product, arm @ k, r)
    np.testing.assert_allclose(got, expected[:, *np.triu_indices(3)], atol=3e-5)


@pytest.mark.parametrize("shape", SHAPES)
def test_force_on_a_body_at_rest_is_its_weight(shape: str):
    stages = block(*SHAPES[shape])
    stages.run(2.0)
    force, moment = stages.contact_forces()
    np.testing.assert_allclose(force[0, 0], [0.0, MASS * G, 0.0], atol=1e-3 * MASS * G)
    np.testing.assert_allclose(moment[0, 0], 0.0, atol=1e-2)


@pytest.mark.parametrize(("shape", "points"), [("box", 4), ("sphere", 1), ("capsule", 2)])
def test_weight_is_spread_over_all_points_that_touch(shape: str, points: int):
    """Depth at rest: each of the equal springs carries its part."""
    stages = block(*SHAPES[shape])
    stages.run(2.0)
    depth = SHAPES[shape][1] - position(stages)[1]
    assert depth == pytest.approx(MASS * G / (points * STIFFNESS), rel=0.02)


def test_corners_push_where_they_are():
    """A box that leans over has its two lower corners in the ground; their force makes a moment about its centre."""
    tilt, height = 0.3, 0.12
    stages = block(BOX, height)
    q, zero = about(X, tilt)[None], np.zeros((1, 3))
    stages.set_state([[0.0, height, 0.0]], q, zero, zero, np.zeros((1, 0, 4)), np.zeros((1, 0, 3)))
    force, moment = stages.contact_forces()
    down, forward = HALF * (np.cos(tilt) + np.sin(tilt)), HALF * (np.cos(tilt) - np.sin(tilt))
    expected = 2.0 * STIFFNESS * (down - height)
    np.testing.assert_allclose(force[0, 0], [0.0, expected, 0.0], rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(moment[0, 0], [-forward * expected, 0.0, 0.0], rtol=1e-4, atol=1e-2)


def implicit_acceleration(q: np.ndarray, height: float, v: np.ndarray, w: np.ndarray, h: float) -> np.ndarray:
    """Accelerations (6,), linear and angular, of the box on the ground: all corners at once in one 6x6 system."""
    k, d, d_t, mu, up = STIFFNESS, DAMPING, TANGENTIAL, 0.5, np.array([0.0, 1.0, 0.0])
    left, right = np.diag([MASS] * 3 + [0.05] * 3), np.array([0.0, -MASS * G, 0.0, 0.0, 0.0, 0.0])
    for corner in HALF * np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8).T:
        r = rotate(q, corner)
        depth, velocity = -(height + r[1]), v + np.cross(w, r)
        normal = k * depth - (d + h * k) * velocity[1]
        if depth <= 0.0 or normal <= 0.0:
            continue
        slip = velocity * [1.0, 0.0, 1.0]
        across = min(d_t, mu * normal / np.linalg.norm(slip))
        jacobian = np.concatenate([np.eye(3), -cross_matrix(r)], axis=1)  # acceleration of the corner
        stiffness = h * np.diag([across, d + h * k, across])
        left += jacobian.T @ stiffness @ jacobian
        right += jacobian.T @ (normal * up - across * slip)
    return np.linalg.solve(left, right)


def test_accelerations_on_the_ground_solve_the_implicit_equations_of_all_corners():
    rng, count = np.random.default_rng(0), 50
    q, height = units(count, 1, 4), rng.uniform(0.05, 0.15, count)
    v, w = vectors(count, 2, 0.5), vectors(count, 3, 3.0)
    stages, none = Stages(block(BOX, HALF).scene, count, "cpu"), np.zeros((count, 0, 3))
    stages.set_state(height[:, None] * [0.0, 1.0, 0.0], q, v, w, np.zeros((count, 0, 4)), none)
    got = stages.forward_dynamics()["speed_rate"]
    for i in range(count):
        expected = implicit_acceleration(q[i], height[i], v[i], w[i], stages.scene.time_step)
        np.testing.assert_allclose(got[i], expected, atol=2e-4 * np.abs(expected).max())


@pytest.mark.parametrize("stiffness", [0.5, 3.0])
def test_a_patch_makes_the_ground_so_many_times_as_stiff(stiffness: float):
    """At rest the force is the spring's alone, but for what it is eased within a step, the same in both."""
    terrain = Terrain([Flat(patches=[Patch((-1.0, 1.0), (-1.0, 1.0), stiffness=stiffness)])])
    depth = 1e-3
    stages = block(BOX, HALF - depth, Ground(stiffness=STIFFNESS, damping=DAMPING, terrain=terrain))
    zero = np.zeros((1, 3))
    stages.set_state(
        [[0.0, HALF - depth, 0.0]], about(X, 0.0)[None], zero, zero, np.zeros((1, 0, 4)), np.zeros((1, 0, 3))
    )
    force, _ = stages.contact_forces()
    np.testing.assert_allclose(force[0, 0], [0.0, 4.0 * stiffness * STIFFNESS * depth, 0.0], rtol=1e-3, atol=1e-3)


def test_body_without_contact_falls_freely():
    stages = block(BOX, 2.0)
    stages.run(0.5)
    np.testing.assert_allclose(velocity(stages), [0.0, -G * 0.5, 0.0], atol=1e-4)


def test_box_sticks_on_a_slope_below_the_friction_angle():
    stages = block(BOX, HALF, slope=0.9 * np.arctan(0.5))
    stages.run(1.0)
    creep = np.linalg.norm(velocity(stages))
    assert creep < 1e-3  # the weight over the damping of four points
    assert np.linalg.norm(position(stages)) < HALF + creep + 1e-3


@pytest.mark.parametrize("excess", [1.1, 1.3])
def test_box_slides_down_a_steeper_slope_as_coulomb_says(excess: float):
    slope = excess * np.arctan(0.5)
    stages = block(BOX, HALF, slope=slope)
    stages.run(0.5)
    before = velocity(stages)
    stages.run(0.5)
    acceleration = G * (np.sin(slope) - 0.5 * np.cos(slope))
    downhill = np.array([0.0, -np.sin(slope), np.cos(slope)])
    np.testing.assert_allclose((velocity(stages) - before) / 0.5, acceleration * downhill, atol=0.01 * acceleration)


def test_ground_with_less_friction_than_the_body_decides():
    slope = np.arctan(0.5)
    stages = block(BOX, HALF, Ground(friction=0.1), slope)
    stages.run(1.0)
    speed = np.linalg.norm(velocity(stages))
    assert speed == pytest.approx(G * (np.sin(slope) - 0.1 * np.cos(slope)), rel=0.01)


def test_sliding_box_stops_where_friction_has_used_up_its_energy():
    stages = block(BOX, HALF, root_velocity=(0.0, 0.0, 2.0))
    stages.run(1.0)
    assert position(stages)[2] == pytest.approx(2.0**2 / (2.0 * 0.5 * G), rel=0.02)
    assert np.linalg.norm(velocity(stages)) < 1e-3


@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
def test_no_stiffness_is_unstable_in_long_steps(stiffness: float):
    """A dropped box stays on the ground; it trembles by no more than twice what gravity moves it in a step."""
    scene, step = block(BOX, HALF + 0.05, Ground(stiffness=stiffness)).scene, 1.0 / 500.0
    scene.time_step = step
    stages = Stages(scene, 1, "cpu")
    stages.run(2.0)
    for _ in range(20):
        stages.run(step)
        assert abs(velocity(stages)[1]) < 2.0 * G * step
        assert position(stages)[1] == pytest.approx(HALF - MASS * G / (4.0 * stiffness), abs=2.0 * G * step**2)


def test_ground_may_be_higher_or_switched_off():
    high, none = block(BOX, HALF + 0.5, Ground(height=0.5)), block(BOX, HALF, Ground(stiffness=0.0))
    for stages in (high, none):
        stages.run(0.5)
    assert position(high)[1] == pytest.approx(0.5 + HALF, abs=1e-3)
    assert velocity(none)[1] == pytest.approx(-G * 0.5, rel=1e-4)
