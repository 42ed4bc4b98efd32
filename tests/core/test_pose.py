"""Rotations and joint coordinates on the host against rotation matrices and compositions."""

import numpy as np
import pytest

from biped import biped, breadth_first
from random_states import random_states
from warpmuscle.core import pose
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import joint_type

N = 50
X, Y, Z = np.eye(3)


def units(seed: int, size: int) -> np.ndarray:
    v = np.random.default_rng(seed).normal(size=(N, size))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def angles(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-3.1, 3.1, N)


def test_normalized_has_unit_length_and_the_same_direction():
    v = np.random.default_rng(0).normal(size=(N, 4)) * 7.0
    got = pose.normalized(v)
    np.testing.assert_allclose(np.linalg.norm(got, axis=1), 1.0)
    np.testing.assert_allclose(got * np.linalg.norm(v, axis=1, keepdims=True), v)


def test_quarter_turns_take_one_axis_to_the_next():
    for axis, start, end in ((X, Y, Z), (Y, Z, X), (Z, X, Y)):
        np.testing.assert_allclose(pose.rotate(pose.about(axis, np.pi / 2), start), end, atol=1e-15)


def test_turn_about_an_axis_is_the_formula_of_rodrigues():
    axis, angle, v = units(1, 3), angles(2), units(3, 3)
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    expected = c * v + s * np.cross(axis, v) + (1.0 - c) * np.sum(axis * v, axis=1, keepdims=True) * axis
    np.testing.assert_allclose(pose.rotate(pose.about(axis, angle), v), expected, atol=1e-14)


def test_product_is_the_second_rotation_followed_by_the_first():
    p, q, v = units(1, 4), units(2, 4), units(3, 3)
    np.testing.assert_allclose(pose.rotate(pose.multiply(p, q), v), pose.rotate(p, pose.rotate(q, v)), atol=1e-14)


def test_conjugate_undoes_a_rotation():
    q, v = units(1, 4), units(2, 3)
    np.testing.assert_allclose(pose.rotate(pose.conjugate(q), pose.rotate(q, v)), v, atol=1e-14)


@pytest.mark.parametrize("shapes", [((2, 3), (3,)), ((3,), (5, 2, 3)), ((4, 1, 3), (2, 3)), ((0, 3), (3,))])
def test_cross_products_are_those_of_numpy_bit_for_bit(shapes):
    a, b = (np.random.default_rng(0).normal(size=shape) for shape in shapes)
    np.testing.assert_array_equal(pose.cross(a, b), np.cross(a, b))


def test_twist_leaves_a_swing_about_an_axis_across():
    q, axis = units(1, 4), units(2, 3)
    swing = pose.multiply(q, pose.conjugate(pose.about(axis, pose.twist_angle(q, axis))))
    np.testing.assert_allclose(np.sum(swing[:, :3] * axis, axis=1), 0.0, atol=1e-14)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_twist_of_a_turn_is_its_angle(sign: float):
    axis, angle = units(1, 3), angles(2)
    np.testing.assert_allclose(pose.twist_angle(sign * pose.about(axis, angle), axis), angle, atol=1e-14)


def test_orientation_turned_to_a_heading_has_it_and_keeps_its_tilt():
    q = units(1, 4)
    turned = pose.multiply(pose.turned_to_heading(q, 0.7), q)
    np.testing.assert_allclose(pose.twist_angle(turned, Y), 0.7, atol=1e-12)
    np.testing.assert_allclose(pose.rotate(pose.conjugate(turned), Y), pose.rotate(pose.conjugate(q), Y), atol=1e-14)


def test_hinge_coordinates_are_those_that_made_the_pose():
    axis, angle, rate = units(1, 3), angles(2), angles(3)
    got = pose.hinge_coordinates(pose.about(axis, angle), rate[:, None] * axis, axis)
    np.testing.assert_allclose(np.concatenate(got, axis=1), np.stack([angle, rate], axis=1), atol=1e-14)


@pytest.mark.parametrize("cosine", [0.0, 0.3, -0.6])
def test_universal_coordinates_are_those_that_made_the_pose(cosine: float):
    """For axes at right angles and others."""
    a = units(1, 3)
    b = cosine * a + np.sqrt(1.0 - cosine**2) * pose.normalized(np.cross(a, units(2, 3)))
    alpha, beta, rate_a, rate_b = angles(3), angles(4), angles(5), angles(6)
    q = pose.multiply(pose.about(b, beta), pose.about(a, alpha))
    velocity = rate_b[:, None] * b + rate_a[:, None] * pose.rotate(pose.about(b, beta), a)
    coordinates, rates = pose.universal_coordinates(q, velocity, a, b)
    np.testing.assert_allclose(coordinates, np.stack([alpha, beta], axis=1), atol=1e-12)
    np.testing.assert_allclose(rates, np.stack([rate_a, rate_b], axis=1), atol=1e-12)


def test_coordinates_of_the_biped_are_those_of_mujoco(mujoco_oracle):
    """Hinges and universal joints in random poses: the same angles and rates as MuJoCo's."""
    character = biped()
    model, states = (
        mujoco_oracle.compile_model(Scene("pose", character)),
        random_states(character, 3, seed=1),
    )
    for index in range(3):
        qpos, qvel = mujoco_oracle.state_to_qpos(model, character, states, index)
        for place, name in enumerate(breadth_first(character)):
            joint = character.joints[name]
            if joint.type == "ball":
                continue
            labels = [name] if joint.type == "hinge" else [f"{name}_a", f"{name}_b"]
            motion = states.joint_orientation[[index], place], states.joint_angular_velocity[[index], place]
            angle, rate = joint_type(joint).nearest(joint, *motion)
            np.testing.assert_allclose(angle[0], [qpos[model.joint(label).qposadr[0]] for label in labels], atol=1e-9)
            np.testing.assert_allclose(rate[0], [qvel[model.joint(label).dofadr[0]] for label in labels], atol=1e-9)


def test_rotation_vectors_are_undone():
    v = np.random.default_rng(3).normal(size=(N, 3))
    v *= np.random.default_rng(4).uniform(1e-9, 3.1, (N, 1)) / np.linalg.norm(v, axis=1, keepdims=True)
    q = pose.from_rotation_vector(v)
    np.testing.assert_allclose(pose.rotation_vector(q), v, atol=1e-12)
    np.testing.assert_allclose(pose.rotation_vector(-q), v, atol=1e-12)
    np.testing.assert_array_equal(pose.rotation_vector([0.0, 0.0, 0.0, 1.0]), np.zeros(3))


def test_angles_go_on_without_jumps_but_where_recordings_begin():
    random = np.random.default_rng(3)
    true = [np.cumsum(random.uniform(-1.5, 1.5, (count, 2)), axis=0) for count in (30, 1, 40, 2)]
    given = [(one + np.pi) % (2.0 * np.pi) - np.pi for one in true]
    breaks = np.cumsum([len(one) for one in given])[:-1]
    found = np.split(pose.unwrapped(np.concatenate(given), breaks), breaks)
    for one, at, own in zip(found, true, given, strict=True):
        np.testing.assert_array_equal(one, np.unwrap(own, axis=0))
        np.testing.assert_allclose(one - one[0], at - at[0], atol=1e-12)
    assert np.abs(np.diff(np.concatenate(given)[:, 0])).max() > np.pi  # there was something to do
    assert pose.unwrapped(np.zeros((0, 3))).shape == (0, 3)
