"""Tiles are the surfaces that a scene describes: heights and slopes in closed form."""

import math

import msgspec
import numpy as np
import pytest

from warpmuscle.scene.terrain.packing import packed
from warpmuscle.scene.terrain.shapes import grid_of
from warpmuscle.scene.terrain.tiles import Flat, Gaps, HeightField, Profile, Rough, Slope, Stairs, Steps, Stones, Waves

RNG = np.random.default_rng(0)
X, Z = RNG.uniform(-4.0, 4.0, 3000), RNG.uniform(-2.0, 9.0, 3000)


def heights(tile, x=X, z=Z):
    return grid_of(tile).height_and_slope(x, z)[0]


def test_flat_ground_is_nowhere_high_or_inclined():
    for part in grid_of(Flat()).height_and_slope(X, Z):
        assert not part.any()


def test_a_slope_rises_everywhere_unless_it_has_a_start_and_a_length():
    rise = math.tan(0.2)
    np.testing.assert_allclose(heights(Slope(0.2)), rise * Z, atol=1e-12)
    np.testing.assert_allclose(heights(Slope(0.2, start=1.0)), rise * np.maximum(Z - 1.0, 0.0), atol=1e-12)
    ramp = heights(Slope(0.2, start=1.0, length=3.0))
    np.testing.assert_allclose(ramp, rise * np.clip(Z - 1.0, 0.0, 3.0), atol=1e-12)
    _, along_x, along_z = grid_of(Slope(0.2, start=1.0, length=3.0)).height_and_slope(X, Z)
    np.testing.assert_allclose(along_z, np.where((Z > 1.0) & (Z < 4.0), rise, 0.0), atol=1e-12)
    assert not along_x.any()


def riser_width(tread: float, riser: float) -> float:
    return tread / math.ceil(tread / riser - 1e-9)


@pytest.mark.parametrize("rise", [0.17, -0.12])
def test_stairs_have_their_edges_where_treads_say_and_risers_before_them(rise: float):
    tile = Stairs(rise, tread=0.29, count=4, start=1.3, landing=0.87)
    width = riser_width(0.29, 0.02)
    assert width <= 0.02
    expected = np.zeros_like(Z)
    for k in range(4):
        edge = 1.3 + 0.29 * k
        expected += rise * np.clip((Z - edge + width) / width, 0.0, 1.0)
        down = 1.3 + 0.29 * 3 + round(0.87 / width) * width + 0.29 * k
        expected -= rise * np.clip((Z - down) / width, 0.0, 1.0)
    np.testing.assert_allclose(heights(tile), expected, atol=1e-9)


def test_stairs_that_do_not_return_end_on_a_landing():
    assert heights(Stairs(0.2, count=3, returns=False), 0.0, 100.0) == pytest.approx(0.6)


def test_steps_are_level_at_random_heights_that_a_seed_decides():
    tile = Steps(height=0.1, length=0.5, count=8, start=1.0, seed=3)
    width = riser_width(0.5, 0.02)
    drawn = np.random.default_rng(3).uniform(-0.1, 0.1, 8)
    for k, height in enumerate(drawn):
        inside = 1.0 + 0.5 * k + np.linspace(0.0, 0.5 - width, 20)
        np.testing.assert_allclose(heights(tile, 0.0 * inside, inside), height, atol=1e-12)
    assert not heights(tile, X, np.minimum(Z, 1.0 - width)).any()
    assert (heights(Steps(seed=4)) != heights(Steps(seed=5))).any()


def test_stones_are_as_large_as_they_say_with_trenches_around():
    tile = Stones(size=(0.3, 0.42), gap=0.12, depth=0.4, count=(3, 4), start=1.0, riser=0.03)
    cell, wide, long = 0.03, 0.3, 0.42
    middle = 0.5 * (3 * wide + 2 * 0.12)
    first_x, first_z = -middle, 1.0 + 0.12
    for i in range(3):
        for j in range(4):
            x0, z0 = first_x + i * (wide + 0.12), first_z + j * (long + 0.12)
            on_x, on_z = np.meshgrid(np.linspace(x0, x0 + wide, 9), np.linspace(z0, z0 + long, 9))
            np.testing.assert_allclose(heights(tile, on_x, on_z), 0.0, atol=1e-9)
            beside = np.linspace(x0 + wide + cell, x0 + wide + 0.12 - cell, 5)
            np.testing.assert_allclose(heights(tile, beside, np.full(5, z0 + 0.1)), -0.4, atol=1e-9)
    assert not heights(tile, X, np.minimum(Z, 1.0)).any()
    assert not heights(tile, X, np.full_like(X, 1.0 + 4 * (long + 0.12) + 0.12)).any()


def test_gaps_are_as_wide_as_they_say():
    tile = Gaps(width=0.24, depth=0.5, spacing=1.2, count=2, start=1.5, riser=0.04)
    expected = np.zeros_like(Z)
    for start in (1.5, 2.7):
        into = np.minimum(Z - start, start + 0.24 - Z) / 0.04
        expected -= 0.5 * np.clip(into, 0.0, 1.0)
    np.testing.assert_allclose(heights(tile), expected, atol=1e-9)


def test_waves_are_sines_within_what_straight_lines_between_points_leave():
    along = heights(Waves(0.1, length=1.5, points=96))
    np.testing.assert_allclose(along, 0.1 * np.sin(2 * np.pi * Z / 1.5), atol=0.1 * (np.pi / 96) ** 2 / 2 * 1.01)
    both = heights(Waves(0.1, length=1.5, across=0.9, points=200))
    expected = 0.1 * np.sin(2 * np.pi * Z / 1.5) * np.cos(2 * np.pi * X / 0.9)
    np.testing.assert_allclose(both, expected, atol=2e-4)


def test_bumps_pass_through_random_heights_and_come_again():
    tile = Rough(height=0.05, spacing=0.25, count=(8, 12), seed=7)
    drawn = np.random.default_rng(7).uniform(-0.05, 0.05, (12, 8))
    columns, rows = np.meshgrid(np.arange(8), np.arange(12))
    at = (columns - 4) * 0.25, (rows - 6) * 0.25
    np.testing.assert_allclose(heights(tile, *at), drawn, atol=1e-9)
    np.testing.assert_allclose(heights(tile, X + 2.0, Z - 3.0), heights(tile), atol=1e-9)
    assert np.abs(heights(tile)).max() <= 0.05


def test_a_profile_goes_through_its_corners_in_straight_lines():
    corners = [(0.0, 0.1), (1.0, 0.5), (1.5, -0.2), (4.0, 0.0)]
    expected = np.interp(Z, *zip(*corners, strict=True))
    np.testing.assert_allclose(heights(Profile(corners, spacing=0.05)), expected, atol=1e-9)


def bilinear(x: float, z: float, table: np.ndarray, spacing: float) -> float:
    """Height by weights of the four corners around a place, from the middle of a table."""
    rows, columns = table.shape
    u = np.clip(x / spacing + 0.5 * (columns - 1), 0, columns - 1)
    w = np.clip(z / spacing + 0.5 * (rows - 1), 0, rows - 1)
    total = 0.0
    for j in range(rows):
        for i in range(columns):
            total += max(0.0, 1.0 - abs(u - i)) * max(0.0, 1.0 - abs(w - j)) * table[j, i]
    return total


def test_height_fields_are_bilinear_continuous_and_level_beyond_their_edges():
    table = RNG.normal(size=(5, 7)).astype(np.float32).astype(float)
    points, text = packed(table)
    tile = HeightField(size=(3.0, 2.0), points=points, packed=text)
    expected = [bilinear(x, z, table, 0.5) for x, z in zip(X[:300], Z[:300], strict=True)]
    np.testing.assert_allclose(heights(tile, X[:300], Z[:300]), expected, atol=1e-9)


@pytest.mark.parametrize(
    "tile",
    [Slope(0.1, start=1.0), Stairs(), Stones(height=0.05), Waves(across=1.0), Rough(), Profile([(0, 0), (2, 1)])],
)
def test_slopes_are_the_derivatives_of_heights(tile):
    grid, h = grid_of(tile), 1e-6
    _, along_x, along_z = grid.height_and_slope(X, Z)
    by_x = (grid.height_and_slope(X + h, Z)[0] - grid.height_and_slope(X - h, Z)[0]) / (2.0 * h)
    by_z = (grid.height_and_slope(X, Z + h)[0] - grid.height_and_slope(X, Z - h)[0]) / (2.0 * h)
    within = (np.abs(by_x - along_x) < 1e-5) & (np.abs(by_z - along_z) < 1e-5)
    assert within.mean() > 0.998  # but where an edge is between


def test_the_top_is_the_highest_point_and_that_of_a_slope_without_an_end_has_no_bound():
    assert grid_of(Stairs(0.2, count=3)).top == pytest.approx(0.6)
    assert grid_of(Slope(0.1)).top == np.inf


def test_no_slope_is_greater_than_the_steepest():
    for tile in (Slope(0.3), Rough(0.2), Waves(0.1, across=0.7), Stairs(0.2)):
        grid = grid_of(tile)
        _, along_x, along_z = grid.height_and_slope(X, Z)
        assert np.hypot(along_x, along_z).max() <= grid.steepest + 1e-12
    assert grid_of(Slope(0.3)).steepest == pytest.approx(math.tan(0.3))


@pytest.mark.parametrize("tile", [Steps(height=-0.0), Stones(height=-0.0), Rough(height=-0.0)])
def test_a_height_of_minus_nothing_is_none(tile: Steps | Stones | Rough):
    level = msgspec.structs.replace(tile, height=0.0)
    np.testing.assert_array_equal(grid_of(tile).heights, grid_of(level).heights)
