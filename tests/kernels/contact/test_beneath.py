"""Bounds of the ground about bodies against the ground itself, and bodies that they spare questions."""

import numpy as np
import pytest
from test_terrain import BALL, BOX, G, block, ground, motion

from warpmuscle.kernels.contact.beneath import SPANS
from warpmuscle.model.terrain.bounds import bounds_of
from warpmuscle.scene import Terrain
from warpmuscle.scene.terrain.packing import packed
from warpmuscle.scene.terrain.surface import grid_at, is_bounded
from warpmuscle.scene.terrain.tiles import AnyTile, Flat, HeightField, Profile, Rough, Slope, Stairs, Stones, Waves

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

HILL = np.add.outer(np.linspace(0.0, 0.6, 7) ** 2, np.linspace(0.3, -0.1, 9))


def field(heights: np.ndarray, size=(4.0, 3.0), **values) -> HeightField:
    points, text = packed(heights)
    return HeightField(size=size, points=points, packed=text, **values)


@pytest.mark.parametrize("tile", [Stairs(), Stones(height=0.05, count=(2, 3)), field(HILL)])
def test_bounds_hold_and_are_no_wider_than_a_cell_and_the_grid_make_them(tile: AnyTile):
    grid = grid_at(tile)
    spans, (first_x, first_z, per_metre) = bounds_of(grid)
    random = np.random.default_rng(3)
    rows, columns = spans.shape[1:3]
    far = 0.11 + np.array([grid.x.spacing, grid.z.spacing])  # beyond the distance: a coarse cell, and one of the grid
    for reach, span in zip(SPANS, spans, strict=True):
        for _ in range(40):
            x = first_x + random.uniform(-1.0, columns / per_metre + 1.0)
            z = first_z + random.uniform(-1.0, rows / per_metre + 1.0)
            i = int(np.clip(np.floor((x - first_x) * per_metre), 0, columns - 1))
            j = int(np.clip(np.floor((z - first_z) * per_metre), 0, rows - 1))
            about = np.linspace(-1.0, 1.0, 101)
            near = grid.height_and_slope(x + reach * about, (z + reach * about)[:, None])[0]
            wide = grid.height_and_slope(x + (reach + far[0]) * about, (z + (reach + far[1]) * about)[:, None])[0]
            low, high = span[j, i]
            assert wide.min() - 0.03 <= low <= near.min() + 1e-9
            assert near.max() - 1e-9 <= high <= wide.max() + 0.03


def test_only_ground_that_is_tall_somewhere_has_bounds():
    assert all(map(is_bounded, [Stairs(), field(HILL)]))
    others = [Flat(), Slope(0.1), Rough(height=1.0), Waves(0.5, 1.0), field(0.1 * HILL), field(HILL, edge="repeat")]
    assert not any(map(is_bounded, others))


def test_a_body_over_ground_below_its_plane_falls_down_to_that():
    """No part of it touches the plane over which the ground lies."""
    deep = field(np.full((2, 2), -0.2))
    fall = motion(block(ground(Terrain([deep], clearing=0.0)), (0.0, 0.35, 0.0), BOX, duration=0.21))
    time = 0.01 * np.arange(len(fall))
    np.testing.assert_allclose(fall[:, 1], 0.15 - 0.5 * G * time**2, atol=2e-3)  # its corners get to -0.146 at 0.2 s


def test_a_ball_on_level_ground_far_from_a_wall_moves_as_on_the_plane():
    far = Profile([(2.0, 0.0), (2.002, 0.3)], spacing=0.002)
    start = {"shape": BALL, "place": (0.0, 0.12, 0.0), "duration": 0.3, "root_velocity": (0.2, 0.0, 1.0)}
    plane = motion(block(ground(damping=0.0), **start))
    beside = motion(block(ground(Terrain([far], yaw=0.3), damping=0.0), **start))
    assert plane[-1, 2] > 0.15
    np.testing.assert_allclose(beside, plane, atol=1e-6)
