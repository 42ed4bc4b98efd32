"""Parameters of pairs of shapes that push each other: one number for all, or one for each instance."""

import numpy as np
import pytest

from warpmuscle.model.body_contact import ShapePair, contact_parameters
from warpmuscle.scene import Body, BodyContact, Capsule, Character, Scene, Sphere

INERTIA = (0.1, 0.1, 0.1)


def parameters(radius: object, stiffness: object = 2.0e4) -> dict:
    """Of a ball beside a capsule along y; numbers, or one for each instance."""
    bodies = {
        "ball": Body(1.0, INERTIA, [Sphere((0.1, 0.2, 0.3), radius)]),
        "rod": Body(1.0, INERTIA, [Sphere((0.0, 0.0, 0.0), 0.5), Capsule((0.0, 0.2, 0.1), (0.0, -0.4, 0.1), 0.04)]),
    }
    contact = BodyContact(stiffness=stiffness, damping=30.0, tangential_damping=90.0, friction=0.7)
    scene = Scene("pair", Character("ball", bodies, {}), body_contact=contact, time_step=0.0005)
    return dict(contact_parameters(scene, ShapePair("ball", 0, "rod", 1)))


def test_shapes_are_capsules_of_their_bodies():
    found = parameters(0.05)
    expected = {
        "first_x": 0.1, "first_y": 0.2, "first_z": 0.3, "first_half_x": 0.0, "first_half_y": 0.0, "first_half_z": 0.0,
        "first_radius": 0.05, "second_x": 0.0, "second_y": -0.1, "second_z": 0.1, "second_half_x": 0.0,
        "second_half_z": 0.0, "second_radius": 0.04, "stiffness": 2.0e4, "damping": 30.0, "tangential_damping": 90.0,
        "friction": 0.7,
    }  # fmt: skip
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert all(isinstance(value, float) for name, value in found.items() if name.startswith(("first", "second")))
    assert abs(found["second_half_y"]) == pytest.approx(0.3)
    assert found["reach"] == pytest.approx(0.3 + 0.05 + 0.04 + found["margin"])


def test_each_instance_has_its_own_numbers():
    radius = np.array([0.05, 0.07])
    found = parameters(radius)
    np.testing.assert_allclose(found["first_radius"], radius)
    np.testing.assert_allclose(found["reach"], 0.3 + radius + 0.04 + found["margin"])
    assert found["second_radius"] == pytest.approx(0.04)
