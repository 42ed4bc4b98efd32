"""Wraps whose paths end inside of their surface for good are taken out, and no others."""

import numpy as np
import pytest

from warpmuscle.core.pose import rotate
from warpmuscle.formats.osim.wraps.idle import drop_idle_wraps, is_inside
from warpmuscle.scene import (
    Body,
    Character,
    CylinderSurface,
    EllipsoidSurface,
    Joint,
    Muscle,
    PointMotion,
    SphereSurface,
    TorusSurface,
    ViaPoint,
    Wrap,
)

ZERO = (0.0, 0.0, 0.0)
TURN = (0.3, -0.5, 0.8)
SPHERE = SphereSurface("arm", (0.01, 0.02, 0.0), 0.03)
INSIDE, OUTSIDE = (0.02, 0.03, 0.01), (0.05, 0.0, 0.0)


def character(*points: ViaPoint, surface=SPHERE, wrap: Wrap | None = None) -> Character:
    body = Body(1.0, (0.1, 0.1, 0.1))
    joint = Joint("hinge", "trunk", "arm", ZERO, ZERO, axes=[(1.0, 0.0, 0.0)])
    muscle = Muscle(f_max=1.0, l_opt=0.1, l_slack=0.1, path=list(points), wraps=[wrap or Wrap("head")])
    bodies = {"trunk": body, "arm": body}
    return Character("trunk", bodies, {"shoulder": joint}, muscles={"one": muscle}, surfaces={"head": surface})


AWAY = ViaPoint("trunk", (0.2, 0.2, 0.0))


@pytest.mark.parametrize(
    ("points", "idle"),
    [
        ((AWAY, ViaPoint("arm", INSIDE)), True),
        ((AWAY, ViaPoint("arm", OUTSIDE)), False),
        ((AWAY, ViaPoint("trunk", INSIDE)), False),  # on another body, so that it comes out
        ((AWAY, AWAY, ViaPoint("arm", INSIDE)), False),  # the first segment has no end inside
        ((AWAY, ViaPoint("arm", INSIDE), AWAY), True),
        ((AWAY, ViaPoint("arm", INSIDE, motion=[PointMotion((1.0, 0.0, 0.0), joint="shoulder", slope=1.0)])), False),
    ],
)
def test_a_wrap_is_idle_where_each_segment_has_an_end_fixed_inside(points: tuple[ViaPoint, ...], idle: bool):
    made = character(*points)
    assert drop_idle_wraps(made) == ({"one": ["head"]} if idle else {})
    assert bool(made.muscles["one"].wraps) != idle


def test_only_the_segments_that_a_wrap_is_for_count():
    points = AWAY, AWAY, ViaPoint("arm", INSIDE)
    assert drop_idle_wraps(character(*points, wrap=Wrap("head", 2, 3)))
    assert not drop_idle_wraps(character(*points, wrap=Wrap("head", 1, 2)))


@pytest.mark.parametrize(
    ("surface", "inside", "outside"),
    [
        (SphereSurface("arm", ZERO, 0.03), (0.02, 0.02, 0.0), (0.02, 0.02, 0.02)),
        (CylinderSurface("arm", ZERO, 0.03, 0.1), (0.02, 0.02, 5.0), (0.0, 0.031, 0.0)),
        (EllipsoidSurface("arm", ZERO, (0.1, 0.02, 0.03)), (0.09, 0.0, 0.0), (0.0, 0.021, 0.0)),
    ],
)
def test_places_are_inside_by_their_surfaces_own_axes(surface, inside: tuple, outside: tuple):
    assert is_inside(np.array(inside), surface)
    assert not is_inside(np.array(outside), surface)
    surface.orientation = TURN
    angle = np.linalg.norm(TURN)
    turn = np.array([*(np.sin(0.5 * angle) * np.array(TURN) / angle), np.cos(0.5 * angle)])
    for place, idle in ((inside, True), (outside, False)):
        turned = tuple(map(float, rotate(turn, np.array(place))))
        assert bool(drop_idle_wraps(character(AWAY, ViaPoint("arm", turned), surface=surface))) == idle


def test_nothing_is_inside_a_ring():
    assert not is_inside(np.zeros(3), TorusSurface("arm", ZERO, 0.01, 0.05))
