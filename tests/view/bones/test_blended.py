"""Surfaces of parts that flow into one another are closed, face outwards, and are where the parts are."""

import numpy as np
import pytest

from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.view.bones.blended import MOST, blended, egg, fan, rod
from warpmuscle.view.hulls import Mesh

BALL, RADIUS = [0.1, -0.2, 0.3], 0.05


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh[0][mesh[2][:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def is_closed(mesh: Mesh) -> bool:
    """Whether each edge of a triangle is that of one other, the other way round."""
    edges = np.concatenate([mesh[2][:, [k, (k + 1) % 3]] for k in range(3)])
    ways, counts = np.unique(edges, axis=0, return_counts=True)
    back = {tuple(edge) for edge in ways[:, ::-1]}
    return bool((counts == 1).all()) and {tuple(edge) for edge in ways} == back


def test_a_ball_is_round_closed_and_faces_outwards():
    mesh = blended([egg(BALL, (RADIUS,) * 3)], 0.006, 0.002)
    away = mesh[0] - BALL
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), RADIUS, atol=2e-4)
    np.testing.assert_allclose(np.sum(mesh[1] * away, axis=1), RADIUS, atol=3e-4)
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.01)


def test_a_rod_is_a_cone_with_round_ends():
    mesh = blended([rod([[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]], [0.03, 0.02])], 0.005, 0.002)
    assert [mesh[0][:, 1].min(), mesh[0][:, 1].max()] == pytest.approx([-0.03, 0.22], abs=1e-3)
    half = mesh[0][np.abs(mesh[0][:, 1] - 0.1) < 0.01]
    np.testing.assert_allclose(np.hypot(half[:, 0], half[:, 2]), 0.025, atol=1.2e-3)
    assert is_closed(mesh)


def test_parts_flow_together_where_they_are_near_and_stay_apart_elsewhere():
    def pair(apart: float) -> Mesh:
        return blended([egg([side * apart, 0.0, 0.0], (0.02,) * 3) for side in (1.0, -1.0)], 0.004, 0.004)

    near, far = pair(0.019), pair(0.05)
    waist = near[0][np.abs(near[0][:, 0]) < 0.002]
    assert np.hypot(waist[:, 1], waist[:, 2]).min() > np.sqrt(0.02**2 - 0.019**2)
    assert np.abs(far[0][:, 0]).min() > 0.02
    assert volume(far) == pytest.approx(2.0 * 4.0 / 3.0 * np.pi * 0.02**3, rel=0.03)


def test_a_hollow_is_cut_out():
    ball, hole = egg([0.0, 0.0, 0.0], (RADIUS,) * 3), egg([RADIUS, 0.0, 0.0], (0.02,) * 3)
    mesh = blended([ball], 0.005, 0.002, [hole])
    assert is_closed(mesh)
    assert np.linalg.norm(mesh[0] - [RADIUS, 0.0, 0.0], axis=1).min() > 0.017


def test_a_fan_is_a_plate_without_holes():
    line = np.linspace([0.0, 0.0, 0.0], [0.1, 0.0, 0.0], 12)
    plate = blended(fan(line, line + np.array([0.0, 0.08, 0.0]), 0.006, 0.006), 0.006, 0.0025)
    assert is_closed(plate)
    faces, corners = len(plate[2]), len(plate[0])
    assert corners - faces / 2 == 2  # by Euler's formula a surface without handles


def test_turned_cells_give_the_same_bone_and_many_cells_become_larger():
    turn = from_rotation_vector(np.array([0.3, -0.5, 0.8]))
    axes = rotate(turn, np.eye(3)).T
    ends = np.array([[0.0, 0.0, 0.0], axes[:, 1] * 0.3])
    parts = [rod(ends, 0.015), egg(ends[1], (0.03, 0.02, 0.015), axes)]
    plain, turned = blended(parts, 0.005, 0.002), blended(parts, 0.005, 0.002, axes=axes)
    assert volume(turned) == pytest.approx(volume(plain), rel=0.02)
    assert is_closed(turned)
    large = blended([egg([0.0, 0.0, 0.0], (5.0,) * 3)], 0.01, 0.002)
    assert len(large[0]) < MOST
    assert volume(large) == pytest.approx(4.0 / 3.0 * np.pi * 125.0, rel=0.02)
