"""Bodies and joints of creatures, against integrals over points, and in the pose that they are drawn in."""

import numpy as np
import pytest

from small_creature import small_creature
from warpmuscle.core.pose import rotate
from warpmuscle.creatures.description import Segment
from warpmuscle.creatures.skeleton import body, middle, moments, skeleton, turn_from_up, volume

LENGTH, RADIUS = 0.5, 0.08


def inside(segment: Segment, points: np.ndarray) -> np.ndarray:
    """Which points (n, 3), from the middle of a segment along z, are inside it."""
    half = 0.5 * LENGTH
    if segment.box:
        return np.all(np.abs(points) <= [RADIUS, RADIUS, half + RADIUS], axis=1)
    beyond = np.maximum(np.abs(points[:, 2]) - half, 0.0)
    return points[:, 0] ** 2 + points[:, 1] ** 2 + beyond**2 <= RADIUS**2


@pytest.mark.parametrize("box", [False, True])
def test_volume_and_moments_are_integrals_over_the_shape(box: bool):
    segment = Segment(start=(0, 0, 0), end=(0, 0, LENGTH), radius=RADIUS, box=box)
    sides = [np.linspace(-end, end, n) for end, n in ((RADIUS, 81), (RADIUS, 81), (0.5 * LENGTH + RADIUS, 165))]
    cells = [0.5 * (side[1:] + side[:-1]) for side in sides]
    points = np.stack(np.meshgrid(*cells, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[inside(segment, points)]
    cell = np.prod([side[1] - side[0] for side in sides])
    assert len(points) * cell == pytest.approx(volume(segment), rel=0.01)
    square = np.mean(points**2, axis=0)
    expected = 3.0 * (square.sum() - square)
    across, along, other = moments(segment, 3.0)
    got = (across, along, other) if box else (across, other, along)  # a capsule's second moment is along itself
    np.testing.assert_allclose(got, expected, rtol=0.02)


def test_a_capsule_s_axis_of_inertia_is_its_own():
    direction = np.array([0.1, -0.6, 0.4])
    turned = rotate(np.array(turn_from_up(direction)), np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(turned, direction / np.linalg.norm(direction), atol=1e-8)
    np.testing.assert_allclose(rotate(np.array(turn_from_up(np.array([0.0, -1.0, 0.0]))), [0.0, 1.0, 0.0]), [0, -1, 0])


def test_both_ends_of_every_joint_are_one_place_in_the_standing_pose():
    creature = small_creature()
    root, bodies, joints = skeleton(creature)
    centre = {"trunk": middle(creature.segments["trunk"])}
    for side, sign in (("l", 1.0), ("r", -1.0)):
        for name in ("Leg", "Foot"):
            centre[f"{side}{name}"] = middle(creature.segments[name]) * [sign, 1.0, 1.0]
    assert root == "trunk"
    assert set(bodies) == set(centre)
    assert set(joints) == {"lHip", "rHip", "lAnkle", "rAnkle"}
    for joint in joints.values():
        ends = [centre[joint.parent] + joint.position_in_parent, centre[joint.child] + joint.position_in_child]
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-8)
        assert joint.axes == [(1.0, 0.0, 0.0)]
    np.testing.assert_allclose(centre["rLeg"] + joints["rHip"].position_in_child, [-0.1, 0.9, 0.0], atol=1e-8)


def test_mass_follows_from_the_volume_unless_it_is_given():
    creature = small_creature()
    _, bodies, _ = skeleton(creature)
    assert bodies["trunk"].mass == 30
    assert bodies["lLeg"].mass == pytest.approx(1000 * np.pi * 0.05**2 * (0.8 + 4 / 3 * 0.05), rel=1e-6)
    light = Segment(start=(0, 1, 0), end=(0, 1.5, 0), radius=0.1, density=500)
    assert body(creature, light, False).mass == pytest.approx(500 * volume(light), rel=1e-6)
