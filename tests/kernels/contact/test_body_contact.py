"""Bodies that push each other: the equations in float64, and collisions against the conservation laws."""

import msgspec
import numpy as np
import pytest
from probes import evaluate, matrix, units, vectors
from test_collision import expected_distance

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.gait.penetration import penetration
from warpmuscle.kernels.contact.body_contact import given_way, mobility
from warpmuscle.kernels.contact.collision import fractions_along
from warpmuscle.model.collisions import segment_distance
from warpmuscle.scene import (
    Body,
    BodyContact,
    Capsule,
    Character,
    Failure,
    Ground,
    InitialState,
    Joint,
    JointState,
    Scene,
    Sphere,
)
from warpmuscle.scene.body_contact.pairs import biped_pairs
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

N = 500
MASS, INERTIA, LENGTH, RADIUS = 2.0, (0.04, 0.01, 0.05), 0.3, 0.05  # of a leg
ROOT_MASS, ROOT_INERTIA = 5.0, (0.1, 0.2, 0.3)
APART = 0.25  # m, of the hips


def test_mobility_is_what_a_unit_force_does_to_a_free_body_s_point():
    turns, arms, ways = units(N, 1, 4), vectors(N, 2, 0.2), units(N, 3)
    moments = np.abs(vectors(N, 4, 0.05)) + 0.01
    masses = np.abs(vectors(N, 5)[:, 0]) + 0.1
    rotation = matrix(turns)
    found = evaluate(mobility, ways, arms, rotation, moments, masses)
    inertia = np.einsum("nij,nj,nkj->nik", rotation, moments, rotation)
    turning = np.linalg.solve(inertia, np.cross(arms, ways)[..., None])[..., 0]
    expected = np.sum(ways * (ways / masses[:, None] + np.cross(turning, arms)), axis=1)
    np.testing.assert_allclose(found, expected, rtol=2e-4)


def test_a_force_that_gives_way_is_that_of_the_end_of_the_step():
    stiffness, damping, h, mobile, depth, speed = 5.0e4, 300.0, 0.002, 0.8, 0.004, -0.5
    gives = h * (damping + h * stiffness)
    start = stiffness * depth - (damping + h * stiffness) * speed
    force = float(evaluate(given_way, start, gives, mobile)[0])
    end_speed = speed + h * mobile * force
    assert force == pytest.approx(stiffness * (depth - h * end_speed) - damping * end_speed, rel=1e-5)


def test_where_segments_are_nearest_is_as_far_as_the_nearest_of_all_candidates():
    middle, half_a, half_b = vectors(N, 6, 0.3), vectors(N, 7, 0.2), vectors(N, 8, 0.2)
    on = evaluate(fractions_along, middle, half_a, half_b)
    gap = middle + half_b * (2.0 * on[:, 1:] - 1.0) - half_a * (2.0 * on[:, :1] - 1.0)
    expected = expected_distance(middle, half_a, half_b)
    np.testing.assert_allclose(np.linalg.norm(gap, axis=1), expected, atol=2e-6)
    np.testing.assert_allclose(segment_distance(middle, half_a, half_b), expected, atol=1e-9)
    flat = np.zeros_like(half_a)
    np.testing.assert_allclose(segment_distance(middle, flat, flat), np.linalg.norm(middle, axis=1))


def legs(speed: float = 3.0, step: float = 0.001, **contact) -> Scene:
    """A body that floats without gravity, with two legs on ball joints that swing into each other, one faster."""
    shape = Capsule((0.0, LENGTH, 0.0), (0.0, -LENGTH, 0.0), RADIUS)
    bodies = {"root": Body(ROOT_MASS, ROOT_INERTIA)}
    joints, state = {}, {}
    for name, side in (("l", 1.0), ("r", -1.0)):
        bodies[f"{name}Leg"] = Body(MASS, INERTIA, [shape])
        place = (0.5 * side * APART, 0.0, 0.0)
        joints[f"{name}Hip"] = Joint("ball", "root", f"{name}Leg", place, (0.0, LENGTH, 0.0))
        spin = (0.1 * (side + 0.4), 0.3 * side, -side * speed * (1.0 if side > 0 else 0.6))
        state[f"{name}Hip"] = JointState(angular_velocity=spin)
    return Scene(
        name="legs",
        character=Character("root", bodies, joints),
        initial_state=InitialState(joints=state),
        ground=Ground(stiffness=0.0),
        failure=Failure(com_height=0.0, heading=0.0),
        body_contact=BodyContact(pairs=[("lLeg", "rLeg")], **contact),
        gravity=0.0,
        duration=0.2,
        time_step=step,
    )


class Motion:
    """Momenta and kinetic energy over a recorded motion of the legs, float64."""

    def __init__(self, scene: Scene) -> None:
        rollout = Rollout(scene, record=[0], record_rate=1.0 / scene.time_step, device="cpu")
        rollout.run()
        self.recording = rec = rollout.recording(0)
        self.depth = penetration(rec, rollout.numeric)
        mass = np.array([ROOT_MASS, MASS, MASS])
        position, orientation = rec.body_position.astype(float), rec.body_orientation.astype(float)
        spin = [rec.root_angular_velocity.astype(float)]
        velocity = [rec.root_velocity.astype(float)]
        for j, (joint, side) in enumerate((("lHip", 1.0), ("rHip", -1.0))):
            assert rec.joint_names[j] == joint
            place = rotate(orientation[:, 0], np.array([0.5 * side * APART, 0.0, 0.0]))
            turning = spin[0] + rotate(orientation[:, 0], rec.joint_angular_velocity[:, j].astype(float))
            arm = rotate(orientation[:, j + 1], np.array([0.0, -LENGTH, 0.0]))
            spin.append(turning)
            velocity.append(velocity[0] + np.cross(spin[0], place) + np.cross(turning, arm))
        velocity, spin = np.stack(velocity, axis=1), np.stack(spin, axis=1)
        inertia = np.array([ROOT_INERTIA, INERTIA, INERTIA])
        axes = np.stack([rotate(orientation, np.eye(3)[k]) for k in range(3)], axis=-1)  # (F, B, 3, 3) columns
        local = np.einsum("fbji,fbj->fbi", axes, spin)
        turned = np.einsum("fbij,fbj->fbi", axes, inertia * local)
        self.linear = np.sum(mass[:, None] * velocity, axis=1)
        self.angular = np.sum(turned + mass[:, None] * np.cross(position, velocity), axis=1)
        self.energy = 0.5 * np.sum(mass * np.sum(velocity**2, axis=2) + np.sum(inertia * local**2, axis=2), axis=1)


@pytest.fixture(scope="module")
def collision() -> Motion:
    return Motion(legs())


def test_bits_do_not_depend_on_the_launches_that_steps_come_in():
    ends = []
    for launches in ((200,), (*range(1, 8), 10, 12, 199, 200)):
        rollout = Rollout(legs(), device="cpu")
        for step in launches:
            rollout.advance(step)
        ends.append(rollout.state.coordinates.numpy())
    np.testing.assert_array_equal(*ends)


def test_legs_that_swing_into_each_other_stop_there(collision):
    free = Motion(legs(stiffness=0.0))
    assert free.depth.depth > 0.08  # through one another
    assert free.depth.pair == ("lLeg", "rLeg")
    assert 0.0 < collision.depth.depth < 0.01
    assert collision.depth.share > 0.0


def test_a_collision_keeps_linear_and_angular_momentum(collision):
    scale = MASS * 3.0 * LENGTH
    assert np.abs(collision.linear - collision.linear[0]).max() < 5e-3 * scale  # else some 1
    assert np.abs(collision.angular - collision.angular[0]).max() < 5e-3 * scale  # symplectic Euler turns bodies


def test_a_collision_gives_no_energy(collision):
    before = collision.energy[0]
    assert collision.energy.max() < 1.01 * before
    assert collision.energy[-1] < 0.9 * before


@pytest.mark.parametrize(("stiffness", "step"), [(1.0e7, 0.002), (1.0e5, 0.0005), (5.0e4, 0.002)])
def test_no_stiffness_is_unstable(stiffness, step):
    motion = Motion(legs(stiffness=stiffness, step=step))
    assert motion.energy.max() < 1.05 * motion.energy[0]
    assert motion.depth.depth < 0.02


def test_friction_takes_what_slides_and_none_of_it_without_friction(collision):
    smooth = Motion(legs(friction=0.0))
    along = [np.abs(motion.recording.joint_angular_velocity[-1, :, 0]).sum() for motion in (smooth, collision)]
    assert along[1] < 0.98 * along[0]


def test_a_biped_s_legs_feet_arms_and_trunk_touch_each_other():
    scene = load("walk56")
    pairs = {frozenset(pair) for pair in biped_pairs(scene.character, scene.feet)}
    for a, b in (
        ("lUpperleg", "rUpperleg"), ("lLowerleg", "rLowerleg"), ("lFoot", "rFoot"), ("lFoot", "rLowerleg"),
        ("lLowerarm", "lUpperleg"), ("rLowerarm", "pelvis"), ("rLowerarm", "torso"),
    ):  # fmt: skip
        assert frozenset((a, b)) in pairs
    assert frozenset(("lUpperarm", "torso")) not in pairs  # a joint joins them
    assert not any("head" in pair for pair in pairs)


@pytest.mark.parametrize(
    ("contact", "key", "why"),
    [
        (BodyContact(pairs=[("lFoot", "rHand")]), "body_contact.pairs.0.1", "rHand"),
        (BodyContact(pairs=[("lFoot", "lFoot")]), "body_contact.pairs.0", "twice"),
        (BodyContact(pairs=[("lFoot", "rFoot"), ("rFoot", "lFoot")]), "body_contact.pairs.1", "there twice"),
        (BodyContact(pairs=[("lFoot", "lLowerleg")]), "body_contact.pairs.0", "joint joins"),
        (BodyContact(stiffness=-1.0), "body_contact.stiffness", "negative"),
        (BodyContact(friction=Free(0.5, -1.0, 1.0)), "body_contact.friction", "negative"),
    ],
)
def test_what_cannot_touch_is_said_with_its_key(contact, key, why):
    scene = msgspec.structs.replace(load("fwalk"), body_contact=contact)
    with pytest.raises(SceneError, match=why) as error:
        check_scene(scene)
    assert error.value.key == key


def test_a_character_without_feet_has_to_name_its_pairs():
    scene = legs()
    scene.body_contact = BodyContact()
    with pytest.raises(SceneError, match="name `pairs`"):
        Rollout(scene, device="cpu")


def test_stiffness_and_sizes_may_differ_between_instances():
    scene = legs()
    scene.body_contact.stiffness = Free(5.0e4, 0.0, 1.0e5)
    scene.character.bodies["lLeg"].shapes = [Sphere((0.0, -LENGTH, 0.0), RADIUS)]
    rollout = Rollout(scene, instances=2, record=[0, 1], device="cpu")
    rollout.set_parameters(np.array([[0.0], [5.0e4]]))
    rollout.run()
    soft, hard = (penetration(rollout.recording(k), rollout.numeric).depth for k in range(2))
    assert soft > 0.05 > 0.02 > hard
