"""A film has the colours of the browser's picture, and its figure is the same one."""

import json
import re
from importlib.resources import files

import numpy as np
import pytest

from small_result import walk_result, walk_scene
from warpmuscle.video import Look, colours, make_film
from warpmuscle.view.page import look_of
from warpmuscle.view.pieces import Hull
from warpmuscle.view.track import track_of


def listed(file: str, name: str) -> object:
    """A constant of a script of the page, which is a list of numbers."""
    text = (files("warpmuscle.view") / "assets" / file).read_text(encoding="utf-8")
    return json.loads(re.search(rf"\b{name} = (\[.*?\])[,;]\s*(?:[A-Z]|//|\n)", text)[1])


@pytest.mark.parametrize(
    ("file", "name", "own"),
    [
        ("shaders.js", "HORIZON", colours.HORIZON),
        ("shaders.js", "ZENITH", colours.ZENITH),
        ("renderer.js", "TENDON", colours.TENDON),
        ("biped.js", "BONE_TINT", colours._LAYERS["bone"]),
        ("biped.js", "OBJECT_TINT", colours._LAYERS["object"]),
        ("biped.js", "DEVICE_TINT", colours._LAYERS["device"]),
        ("biped.js", "FORCE_TINT", colours.FORCES),
    ],
)
def test_colours_are_those_of_the_page(file: str, name: str, own: object):
    np.testing.assert_array_equal(listed(file, name), own)


def test_activations_have_the_colours_of_the_page():
    text = (files("warpmuscle.view") / "assets" / "renderer.js").read_text(encoding="utf-8")
    stops = json.loads(re.search(r"const ACTIVATIONS = (\[.*\]);", text)[1])[0]
    np.testing.assert_array_equal(stops, colours.ACTIVATIONS)
    np.testing.assert_allclose(colours.activation_colours(np.array([0.0, 0.125, 1.0])), [
        stops[0], np.mean(stops[:2], axis=0), stops[4]])  # fmt: skip


def test_the_bones_of_a_film_are_the_meshes_of_the_page():
    motion, scene = walk_result().replays[0].window(1.0, 2.0), walk_scene()
    film = make_film(motion, scene, Look(width=160, height=120, rate=10.0))
    hulls = [piece for piece in look_of(track_of(motion, scene).doll, scene, False, None) if isinstance(piece, Hull)]
    bones = np.concatenate([piece.corners for piece in hulls if piece.layer == "bone"])
    ours = np.all(film.figure.tints == colours._LAYERS["bone"], axis=1)
    assert len(bones) > 1000
    assert {tuple(one) for one in np.round(bones, 9)} <= {tuple(one) for one in np.round(film.figure.corners[ours], 9)}
