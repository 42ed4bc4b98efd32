"""Meshes of a film are closed, turned outwards and as large as what they stand for."""

from collections import Counter

import numpy as np
import pytest

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import about
from warpmuscle.video.bellies import Bellies
from warpmuscle.video.colours import ACTIVATIONS, TENDON, lit, skin_alpha
from warpmuscle.video.triangles import arrow, mesh_of, triangles_of
from warpmuscle.view.hulls import Mesh
from warpmuscle.view.pieces import Block, Ellipsoid, Limb

TURN = about(np.array([0.6, 0.0, 0.8]), 0.7)
START, END = np.array([0.1, 0.2, -0.1]), np.array([0.4, 0.1, 0.3])
LENGTH = float(np.linalg.norm(END - START))


def volume(mesh: Mesh) -> float:
    """Of a closed mesh whose faces are counter-clockwise from outside, m^3; the divergence theorem."""
    corners, _, faces = mesh
    a, b, c = (corners[faces[:, k]] for k in range(3))
    return float(np.sum(np.einsum("ij,ij->i", a, np.cross(b, c))) / 6.0)


@pytest.mark.parametrize(
    ("piece", "expected"),
    [
        (Block(0, "left", "object", START, np.array([0.1, 0.2, 0.3])), 8.0 * 0.1 * 0.2 * 0.3),
        (Ellipsoid(0, "left", "bone", START, TURN, np.array([0.1, 0.2, 0.3])), 4.0 / 3.0 * np.pi * 0.006),
        (Limb(0, "left", "bone", START, START, (0.2, 0.2)), 4.0 / 3.0 * np.pi * 0.008),
        (Limb(0, "left", "device", START, END, (0.1, 0.1), flat=True), np.pi * 0.01 * LENGTH),
        (Limb(0, "left", "flesh", START, END, (0.1, 0.1)), np.pi * 0.01 * LENGTH + 4.0 / 3.0 * np.pi * 0.001),
    ],
)
def test_a_piece_has_its_volume_and_normals_that_point_outwards(piece, expected: float):
    corners, normals, faces = mesh_of(piece)
    assert volume((corners, normals, faces)) == pytest.approx(expected, rel=0.12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    outwards = np.cross(b - a, c - a)
    large = np.linalg.norm(outwards, axis=1) > 1e-9
    assert (np.einsum("ij,ij->i", outwards, normals[faces[:, 0]])[large] > -1e-9).all()


def test_an_arrow_reaches_its_tip_and_a_short_one_is_all_head():
    long, short = arrow(START, END), arrow(START, START + 0.1 * (END - START))
    along = (END - START) / LENGTH
    for (corners, _, _), length in ((long, LENGTH), (short, 0.1 * LENGTH)):
        reach = (corners - START) @ along
        assert (reach.min(), reach.max()) == (pytest.approx(0.0, abs=1e-9), pytest.approx(length))
    assert len(long[0]) > len(short[0])


def test_bodies_carry_their_triangles_and_hidden_layers_have_none():
    pieces = [Limb(1, "left", "bone", START, END, (0.1, 0.1)), Limb(0, "left", "surface", START, END, (0.1, 0.1)),
              Block(0, "right", "flesh", START, np.full(3, 0.1))]  # fmt: skip
    figure = triangles_of(pieces)
    assert Counter(figure.glass.tolist()) == {1: 12, 0: len(mesh_of(pieces[0])[2])}
    assert set(figure.body[figure.faces[figure.glass == 0]].ravel()) == {1}
    corners, normals = figure.placed(
        np.array([[0.0, 0.0, 0.0], [0.0, 5.0, 0.0]]), np.array([TURN, [0.0, 0.0, 0.0, 1.0]])
    )
    np.testing.assert_allclose(corners[figure.body == 1], mesh_of(pieces[0])[0] + [0.0, 5.0, 0.0])
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert len(triangles_of([]).faces) == 0


def muscles(points: Floats, start: list[int]) -> tuple[Bellies, Floats]:
    count = len(start) - 1
    return Bellies(np.array(start), np.full(count, 0.8), np.full(count, 0.03), np.full(count, 0.5), 0.004), points


def test_a_belly_is_thickest_in_its_middle_and_ends_as_a_tendon():
    bellies, points = muscles(np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0]]), [0, 2])
    corners, _, tints, _ = bellies.drawn(points, np.array([1.0]))
    radius, height = np.hypot(corners[:, 0], corners[:, 2]), corners[:, 1]
    near_middle = np.abs(height - 0.25) < 0.02
    np.testing.assert_allclose(radius[near_middle], 0.03, rtol=0.02)
    np.testing.assert_allclose(radius[(height < 0.05) | (height > 0.45)], 0.004)
    np.testing.assert_allclose(tints[near_middle], np.tile(ACTIVATIONS[-1], (near_middle.sum(), 1)))
    np.testing.assert_allclose(tints[height < 0.05], np.tile(TENDON, ((height < 0.05).sum(), 1)))


def test_a_stretched_belly_keeps_its_volume_and_paths_stay_apart():
    path = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0], [3.0, 0.1, 0.0], [3.0, 0.1, 0.5]])
    bellies, points = muscles(path, [0, 2, 5, 5])  # the last one acts without a path
    corners, normals, _, faces = bellies.drawn(points, np.array([0.0, 0.5, 1.0]))
    first = corners[:, 0] < 1.0
    assert np.hypot(corners[first, 0], corners[first, 2]).max() == pytest.approx(0.03 / np.sqrt(2.0), rel=0.02)
    assert np.isfinite(normals).all()
    assert all(first[faces].all(axis=1) | ~first[faces].any(axis=1))  # no triangle joins two muscles


def test_light_from_above_is_brighter_than_from_below_and_edges_of_skin_hide_most():
    up, tint = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]), np.full((2, 3), 0.5)
    towards = np.tile([0.0, 0.0, 1.0], (2, 1))
    bright = lit(up, towards, tint)[:, 0]
    assert bright[0] > 1.5 * bright[1] > 0.0
    facing = skin_alpha(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), towards)
    np.testing.assert_allclose(facing, [0.2 * 0.25, 0.2 * 1.85])
