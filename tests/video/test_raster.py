"""Pixels of triangles: those whose middles lie within, of the nearest one, with the shares of its corners there."""

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.video.raster import seen_triangles

WIDTH, HEIGHT = 24, 18


def rays(triangles: Floats, width: int, height: int) -> tuple[Floats, Floats]:
    """Nearness (height, width), 1/m, of the nearest of triangles (T, 3, 3), and its number, pixel by pixel.

    A triangle is three rows of x and y, px, and depth, m.
    """
    near, number = np.zeros((height, width)), np.full((height, width), -1)
    for k, triangle in enumerate(triangles):
        system = np.column_stack([triangle[:, :2], np.ones(3)])
        if np.linalg.det(system) >= 0.0:
            continue
        for y in range(height):
            for x in range(width):
                share = np.linalg.solve(system.T, [x + 0.5, y + 0.5, 1.0])
                own = share @ (1.0 / triangle[:, 2])  # one over the depth is linear in the picture
                if share.min() >= 0.0 and own > near[y, x]:
                    near[y, x], number[y, x] = own, k
    return near, number


def test_pixels_are_those_of_the_nearest_triangle_that_faces_the_eye():
    numbers = np.random.default_rng(4)
    corners = numbers.uniform([-6.0, -6.0, 1.0], [WIDTH + 6.0, HEIGHT + 6.0, 5.0], (14, 3, 3))
    flat, depth = corners[..., :2].reshape(-1, 2), corners[..., 2].ravel()
    seen = seen_triangles(flat, depth, np.arange(42).reshape(14, 3), WIDTH, HEIGHT)
    near, number = rays(corners, WIDTH, HEIGHT)
    np.testing.assert_array_equal(seen.pixel, np.flatnonzero(number.ravel() >= 0))
    np.testing.assert_array_equal(seen.face, number.ravel()[seen.pixel])
    np.testing.assert_allclose(seen.nearness, near.ravel()[seen.pixel], rtol=1e-6)


def test_shares_lead_back_to_the_point_in_space():
    corners = np.array([[2.0, 3.0, 1.0], [5.0, 15.0, 4.0], [21.0, 6.0, 2.0]])  # px, px, m
    seen = seen_triangles(corners[:, :2], corners[:, 2], np.array([[0, 1, 2]]), WIDTH, HEIGHT)
    assert len(seen.pixel) > 60
    space = corners * np.column_stack([corners[:, 2]] * 2 + [np.ones(3)])  # x z, y z, z
    point = seen.share @ space
    np.testing.assert_allclose(point[:, 0] / point[:, 2], seen.pixel % WIDTH + 0.5, atol=1e-9)
    np.testing.assert_allclose(point[:, 1] / point[:, 2], seen.pixel // WIDTH + 0.5, atol=1e-9)
    np.testing.assert_allclose(1.0 / point[:, 2], seen.nearness, rtol=1e-9)


def test_a_closed_body_covers_each_pixel_of_its_outline_once_and_nothing_beyond():
    angle = 2.0 * np.pi * np.arange(40) / 40
    rim = np.column_stack([12.0 - 7.0 * np.cos(angle), 9.0 + 7.0 * np.sin(angle)])
    fan = np.array([[0, k, k + 1] for k in range(1, 39)])[:, ::-1]
    front = seen_triangles(rim, np.ones(40), fan, WIDTH, HEIGHT)
    back = seen_triangles(rim, np.ones(40), fan[:, ::-1], WIDTH, HEIGHT)
    one = front if len(front.pixel) else back
    assert min(len(front.pixel), len(back.pixel)) == 0  # of one side only
    away = np.hypot(one.pixel % WIDTH + 0.5 - 12.0, one.pixel // WIDTH + 0.5 - 9.0)
    assert away.max() < 7.0
    assert abs(len(one.pixel) - np.pi * 49.0) < 6.0
