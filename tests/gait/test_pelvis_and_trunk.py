"""Tilt, obliquity and rotation against turns that are put together of them, and which bodies they are of."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from warpmuscle.formats import load
from warpmuscle.gait.pelvis_and_trunk import _of_side, _turns, segments


@pytest.mark.parametrize("course", [0.0, 0.6, -2.9])
def test_turns_are_about_the_vertical_then_the_way_then_across(course: float):
    random = np.random.default_rng(3)
    tilt, obliquity, rotation = random.uniform(-0.7, 0.7, (3, 50))
    orientation = Rotation.from_euler("YZX", np.stack([rotation + course, obliquity, tilt], axis=1)).as_quat()
    got = _turns(orientation, course)
    np.testing.assert_allclose(got, np.degrees(np.stack([tilt, obliquity, rotation], axis=1)), atol=1e-9)


def test_a_bow_is_a_positive_tilt_and_a_left_side_that_is_up_a_positive_obliquity():
    bowed = Rotation.from_rotvec([[0.3, 0.0, 0.0]]).as_quat()  # the way up goes forwards, to z
    assert Rotation.from_quat(bowed).apply([0.0, 1.0, 0.0])[0, 2] > 0.0
    np.testing.assert_allclose(_turns(bowed, 0.0), [[np.degrees(0.3), 0.0, 0.0]], atol=1e-9)
    up = Rotation.from_rotvec([[0.0, 0.0, 0.2]]).as_quat()
    assert Rotation.from_quat(up).apply([1.0, 0.0, 0.0])[0, 1] > 0.0  # x is the left
    np.testing.assert_allclose(_turns(up, 0.0), [[0.0, np.degrees(0.2), 0.0]], atol=1e-9)


@pytest.mark.parametrize(
    ("backwards", "side", "sign"), [(False, "left", -1.0), (False, "right", 1.0), (True, "left", -1.0)]
)
def test_turns_of_a_stride_are_against_its_way_from_end_to_end(backwards: bool, side: str, sign: float):
    """The centre of mass sways on its way, which is 0.3 rad to the left; the body looks 0.2 rad further, or back."""
    time, way, looks = np.linspace(0.0, 1.0, 41), 0.3, 0.5 + np.pi * backwards
    along = 1.4 * time[:, None] * [np.sin(way), 0.0, np.cos(way)]
    aside = 0.04 * np.sin(2.0 * np.pi * time)[:, None] * [np.cos(way), 0.0, -np.sin(way)]
    orientation = Rotation.from_rotvec(np.tile([0.0, looks, 0.0], (41, 1))).as_quat()
    recording: Any = SimpleNamespace(time=time, com=along + aside, root_orientation=orientation)
    turns = _of_side(recording, orientation, [(0.0, 1.0)], side)
    assert turns.shape == (1, 101, 3)
    turned = (turns[..., 2] + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(turned, sign * np.degrees(0.2), atol=1e-6)
    np.testing.assert_allclose(turns[..., :2], 0.0, atol=1e-6)


def test_the_trunk_is_the_heaviest_body_above_the_pelvis_if_it_is_heavy():
    scene = load("fwalk")
    assert segments(scene) == {"Pelvis": "pelvis", "Trunk": "torso"}
    total = sum(body.mass for name, body in scene.character.bodies.items() if name != "torso")
    for part, found in ((0.12, ["Pelvis", "Trunk"]), (0.08, ["Pelvis"])):
        scene.character.bodies["torso"].mass = total * part / (1.0 - part)
        assert list(segments(scene)) == found
