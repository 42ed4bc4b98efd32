"""Paths over surfaces in a row, in closed form."""

import math
from functools import partial

import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.scene import CylinderSurface, SphereSurface, Wrap
from warpmuscle.scene.validation.muscles import initial_path_lengths
from warpmuscle.scene.wrapping.mujoco import mujoco_touch
from warpmuscle.scene.wrapping.path import Placed, path_length
from warpmuscle.scene.wrapping.rows import laid

RADIUS = 0.1


def cylinder(center: tuple[float, float, float], side: tuple[float, float, float], name: str) -> Placed:
    touch = partial(mujoco_touch, radius=RADIUS, side=np.array(side), round_sphere=False)
    start = np.array(center) + 0.5 * np.array(side)
    return Placed(touch, np.eye(3), np.array(center), name, 0, 1, start)


@pytest.mark.parametrize("rise", [0.0, 0.4])
def test_over_one_and_under_another_parallel_cylinder_the_path_is_straight_when_unrolled(rise: float):
    """It is alike when turned by half a turn: twice a tangent, an arc and half of the tangent of both."""
    points = [np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, rise])]
    row = [cylinder((-0.3, -0.05, 0.0), (0.0, 0.2, 0.0), "low"), cylinder((0.3, 0.05, 0.0), (0.0, -0.2, 0.0), "high")]
    far, near = math.hypot(0.7, 0.05), math.hypot(0.3, 0.05)
    angle = math.atan2(0.05, -0.7) - math.atan2(0.05, 0.3) - math.acos(RADIUS / far) - math.acos(RADIUS / near)
    flat = 2.0 * (math.sqrt(far**2 - RADIUS**2) + RADIUS * angle + math.sqrt(near**2 - RADIUS**2))
    stops = laid(points, row)
    assert [stop.wrap for stop in stops] == [-1, 0, 0, 1, 1, -1]
    assert path_length(stops) == pytest.approx(math.hypot(flat, rise), abs=1e-9)


def test_a_path_that_passes_a_cylinder_on_its_side_does_not_touch_it():
    points = [np.array([-1.0, 0.3, 0.0]), np.array([1.0, 0.3, 0.0])]
    stops = laid(points, [cylinder((0.0, 0.0, 0.0), (0.0, 0.2, 0.0), "low")])
    assert [stop.wrap for stop in stops] == [-1, -1]
    below = [point * [1.0, -1.0, 1.0] for point in points]  # it has to be led over the cylinder
    assert [stop.wrap for stop in laid(below, [cylinder((0.0, 0.0, 0.0), (0.0, 0.2, 0.0), "low")])] == [-1, 0, 0, -1]


@pytest.mark.parametrize("kind", [CylinderSurface, SphereSurface])
def test_a_side_point_in_the_middle_leads_a_path_inside(kind: type[CylinderSurface | SphereSurface]):
    """As one a little beside it does: a segment of 0.08 m, 0.04 m beside the middle, comes within 0.02 m of it."""
    lengths = []
    for aside in (0.0, 1.0e-6):
        scene = arm()
        scene.character.wrapping = "mujoco"
        sizes = (0.02, 0.1, (0.0, 0.5 * math.pi, 0.0)) if kind is CylinderSurface else (0.02,)  # about x
        scene.character.surfaces = {"ring": kind("base", (0.0, 0.16, 0.0), *sizes, side_point=(0.0, aside, 0.0))}
        scene.character.muscles["flexor"].wraps = [Wrap("ring", 1, 2)]
        lengths.append(initial_path_lengths(scene)["flexor"])
    assert lengths == pytest.approx([0.3 - 0.08 + 2.0 * math.hypot(0.04, 0.02)] * 2, abs=1e-5)
