"""The ground of a scene as a plane."""

import numpy as np

from warpmuscle.scene import Ground
from warpmuscle.scene.ground import plane


def test_the_normal_becomes_a_unit_and_the_height_is_measured_along_it():
    normal, height = plane(Ground(normal=(0.0, 4.0, 3.0), height=0.5))
    np.testing.assert_allclose(normal, [0.0, 0.8, 0.6])
    assert height == 0.5


def test_places_at_its_height_lie_in_the_plane():
    ground = plane(Ground(normal=(0.1, 2.0, -0.3), height=0.5))
    x, z = np.array([0.0, 1.0, -2.0]), np.array([0.0, 3.0, 4.0])
    places = np.stack([x, ground.height_at(x, z), z], axis=1)
    np.testing.assert_allclose(places @ ground.normal, 0.5)
