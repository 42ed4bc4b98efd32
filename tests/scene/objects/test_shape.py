"""Inertia of objects against points drawn within them."""

import numpy as np
import pytest

from warpmuscle.scene import BallObject, BoxObject, CapsuleObject
from warpmuscle.scene.objects.shape import inertia, rounded

SOLIDS = [BallObject(radius=0.3, mass=2.0), BoxObject(size=(0.2, 0.5, 0.9), mass=3.0),
          CapsuleObject(radius=0.1, length=0.7, mass=1.5)]  # fmt: skip


@pytest.mark.parametrize("solid", SOLIDS, ids=lambda solid: type(solid).__name__)
def test_moments_of_inertia_are_those_of_points_drawn_within(solid):
    half, radius = rounded(solid)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (400_000, 3)) * (half[0] + radius[0])
    within = np.linalg.norm(points - np.clip(points, -half[0], half[0]), axis=1) <= radius[0]
    inside = points[within]
    square = np.mean(inside**2, axis=0)
    np.testing.assert_allclose(inertia(solid)[0], solid.mass * (square.sum() - square), rtol=0.01)


def test_values_of_instances_give_a_row_each():
    many = CapsuleObject(radius=np.array([0.1, 0.2]), length=0.5, mass=np.array([1.0, 3.0]))
    one = CapsuleObject(radius=0.2, length=0.5, mass=3.0)
    np.testing.assert_allclose(inertia(many)[1], inertia(one)[0])
    assert rounded(many).radius.tolist() == [0.1, 0.2]
