"""Tendons from where muscles end to the bones that are drawn there."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view.bones.attachments import DETOUR, FARTHEST, attachments, nearest
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull


def figure(name: str):
    scene = load(name)
    scene = substitute(scene, start_values(scene))
    names = list(scene.character.bodies)
    look = figure_of(scene.character, scene.feet or (), names)
    return scene, names, look


@pytest.mark.parametrize("name", ["walk56_person", "gait2392_walk"])
def test_each_tendon_joins_the_end_of_a_muscle_to_a_bone_of_its_body(name):
    scene, names, look = figure(name)
    muscles = scene.character.muscles
    ends = {(end.body, tuple(end.place())) for muscle in muscles.values() for end in (muscle.path[0], muscle.path[-1])}
    tendons = attachments(scene, muscles, names, look)
    assert len(tendons) > 0.4 * len(ends)
    for tendon in tendons:
        assert (names[tendon.body], tuple(tendon.start)) in ends
        bones = [
            piece for piece in look if isinstance(piece, Hull) and (piece.body, piece.layer) == (tendon.body, "bone")
        ]
        low = np.min([bone.corners.min(axis=0) for bone in bones], axis=0)
        high = np.max([bone.corners.max(axis=0) for bone in bones], axis=0)
        assert ((low - 1e-9 <= tendon.end) & (tendon.end <= high + 1e-9)).all()
        assert np.linalg.norm(tendon.end - tendon.start) < 2.0 * FARTHEST


def test_no_tendon_of_the_trunk_of_an_arm_runs_to_the_jaw():
    scene, names, look = figure("arm18")
    tendons = [one for one in attachments(scene, scene.character.muscles, names, look) if names[one.body] == "trunk"]
    assert tendons
    for tendon in tendons:
        bones = [
            piece for piece in look if isinstance(piece, Hull) and (piece.body, piece.layer) == (tendon.body, "bone")
        ]
        corners = np.concatenate([bone.corners for bone in bones])
        nearest_corner = np.linalg.norm(corners - tendon.start, axis=1).min()
        assert np.linalg.norm(tendon.end - tendon.start) <= DETOUR * nearest_corner + 1e-9
        assert tendon.end[1] < 0.36  # m, where the jaw begins


def test_what_touches_a_bone_or_has_none_gets_no_tendon():
    scene, names, look = figure("walk56_person")
    assert attachments(scene, scene.character.muscles, names, []) == []
    assert attachments(scene, [], names, look) == []


def test_the_nearest_point_of_edges_lies_on_one():
    edges = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0, 5.0, 0.0], [0.0, 6.0, 0.0]]])
    np.testing.assert_allclose(nearest(np.array([0.25, 1.0, 0.0]), edges), [0.25, 0.0, 0.0])
    np.testing.assert_allclose(nearest(np.array([-3.0, 5.5, 1.0]), edges), [0.0, 5.5, 0.0])
    np.testing.assert_allclose(nearest(np.array([2.0, 1.0, 0.0]), edges), [1.0, 0.0, 0.0])
