"""Capsules that stand for bodies in water, and the water that moves with them, against closed forms and tables."""

import numpy as np
import pytest

from warpmuscle.scene.water.capsules import added_mass, by_mass, capsule_volume, length_by_inertia, radius_of


def test_a_cylinder_is_found_again_by_its_volume_and_inertia():
    radius, length = np.array([0.05, 0.1, 0.02]), np.array([0.4, 0.5, 0.3])
    volume = np.pi * radius**2 * length
    np.testing.assert_allclose(length_by_inertia(volume, (3.0 * radius**2 + length**2) / 12.0), length, rtol=1e-9)
    assert length_by_inertia(np.array([1.0]), np.array([0.01]))[0] == 0.0


def test_capsules_have_the_volume_that_they_were_asked_for():
    volume, length = np.array([0.004, 0.02, 0.004]), np.array([0.5, 0.4, 0.0])
    radius = radius_of(volume, length)
    half = np.maximum(0.5 * length, radius)
    np.testing.assert_allclose(capsule_volume(half, radius), volume, rtol=1e-9)
    assert radius[2] == pytest.approx(np.cbrt(3.0 * 0.004 / (4.0 * np.pi)))


def test_a_body_lies_along_its_axis_of_least_inertia():
    found = by_mass(np.array([7.0]), np.array([[0.12, 0.01, 0.13]]), np.array([1000.0]))
    assert found.half[0, 1] > 0.15
    assert not found.half[0, [0, 2]].any()
    assert found.volume[0] == pytest.approx(0.007)


@pytest.mark.parametrize(
    ("ratio", "along", "across"),
    [(1.001, 0.5, 0.5), (2.0, 0.209, 0.702), (5.01, 0.059, 0.895), (9.97, 0.021, 0.960)],
)
def test_added_mass_is_that_of_spheroids_in_lambs_table(ratio: float, along: float, across: float):
    """Lamb 1932, art. 115, table for ratios of the axes."""
    np.testing.assert_allclose(added_mass(np.array([ratio]), np.array([1.0])), [[along], [across]], atol=3e-3)
