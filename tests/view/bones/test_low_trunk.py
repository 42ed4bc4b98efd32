"""Trunks that lie or lean ahead of two hips: where ribs are, which bodies have them, and which ones get a head."""

import numpy as np
import pytest

from closed_meshes import check
from warpmuscle.creatures.build import creature_scene, read_creature
from warpmuscle.examples import EXAMPLES
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.topology import topology
from warpmuscle.view.bones.low_trunk import low_trunk
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull

HIPS = [np.array([0.08, -0.1, -0.1]), np.array([-0.08, -0.1, -0.1])]
END, RADIUS = np.array([0.0, 0.2, 0.2]), 0.12


def test_ribs_lie_in_the_trunk_below_its_spine():
    found = low_trunk(HIPS, None, END, RADIUS, 1.0)
    assert found is not None
    assert found.headless
    corners, normals, faces = found.ribs(1.0)
    check(corners, normals, faces)
    axis = END - 0.5 * (HIPS[0] + HIPS[1])
    along = axis / np.linalg.norm(axis)
    off = (corners - END) - ((corners - END) @ along)[:, None] * along
    assert np.linalg.norm(off, axis=1).max() < 1.05 * RADIUS
    assert np.abs(np.linalg.norm(normals, axis=1) - 1.0).max() < 1e-5
    assert ((corners - found.front) @ found.down).min() > -0.5 * RADIUS
    np.testing.assert_allclose(corners[:, 0].min(), -corners[:, 0].max(), atol=1e-3)


def test_a_neck_ends_the_trunk_and_carries_its_own_head():
    found = low_trunk(HIPS, np.array([0.0, 0.0, 0.4]), END, RADIUS, 1.0)
    assert found is not None
    assert not found.headless
    np.testing.assert_array_equal(found.front, [0.0, 0.0, 0.4])


@pytest.mark.parametrize("end", [(0.0, 0.5, 0.0), (0.3, 0.0, 0.2), (0.0, -0.05, 0.0)], ids=["up", "aside", "short"])
def test_other_trunks_have_none(end):
    assert low_trunk(HIPS, None, np.array(end), RADIUS, 1.0) is None


@pytest.mark.parametrize("name", ["kangaroo", "ostrich", "pony", "walker"])
def test_every_creature_has_a_spine_and_one_head(tmp_path, name):
    file = tmp_path / f"{name}.toml"
    file.write_text(dict(EXAMPLES["creatures"].make())[file.name])
    scene = creature_scene(read_creature(file))
    character = substitute(scene, start_values(scene)).character
    names = topology(character).bodies
    pieces = figure_of(character, character.feet or (), names)
    assert sum(piece.layer == "hollow" for piece in pieces) == 1
    hulls = [one for one in pieces if isinstance(one, Hull) and one.body == names.index("trunk")]
    assert sum(one.layer == "bone" for one in hulls) >= 2  # the pelvis, and ribs
