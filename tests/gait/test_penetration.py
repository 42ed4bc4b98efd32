"""How deep bodies are inside each other, against all distances between many points of their axes."""

import dataclasses

import msgspec
import numpy as np
import pytest

from biped import random_recording
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.gait.penetration import nearest_pair, penetration
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene.parameters import start_values, substitute

POINTS = np.linspace(-1.0, 1.0, 401)
SHANK = np.array([0.0, 0.16, 0.0])  # half of its axis, m; its middle is at (0, -0.04, 0), its radius 0.05 m
MIDDLE, RADIUS = np.array([0.0, -0.04, 0.0]), 0.05


@pytest.fixture(scope="module")
def scene():
    scene = load("fwalk")
    return substitute(scene, start_values(scene))


def standing(scene, frames: int) -> Recording:
    """The biped as in its reference pose, its bodies far from each other."""
    names = ("pelvis", *(joint.child for joint in scene.character.joints.values()))
    bodies = list(dict.fromkeys([*names]))
    made = random_recording(frames, joints=len(scene.character.joints))
    arrays = {name: np.array(made[name]) for name in QUANTITIES}
    arrays["body_position"] = np.tile(10.0 * (1.0 + np.arange(len(bodies)))[:, None] * np.ones(3), (frames, 1, 1))
    arrays["body_orientation"] = np.tile([0.0, 0.0, 0.0, 1.0], (frames, len(bodies), 1))
    arrays["time"] = 0.01 * np.arange(frames)
    return Recording.of(arrays, tuple(scene.character.joints), tuple(bodies))


def test_bodies_that_are_apart_are_not_inside_each_other(scene):
    found = penetration(standing(scene, 3), scene)
    assert (found.depth, found.share, found.pair) == (0.0, 0.0, None)


def test_depth_and_share_are_those_of_many_points_along_the_axes(scene):
    frames = 40
    recording = standing(scene, frames)
    rng = np.random.default_rng(3)
    position, orientation = recording.body_position.copy(), recording.body_orientation.copy()
    left, right = (recording.body_names.index(name) for name in ("lLowerleg", "rLowerleg"))
    turned = rng.normal(size=(frames, 2, 4))
    turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
    position[:, left], position[:, right] = 0.0, rng.normal(scale=0.12, size=(frames, 3))
    orientation[:, left], orientation[:, right] = turned[:, 0], turned[:, 1]
    moved = dataclasses.replace(recording, body_position=position, body_orientation=orientation)
    depth = np.zeros(frames)
    for frame in range(frames):
        a, b = (
            position[frame, body] + rotate(orientation[frame, body], MIDDLE + POINTS[:, None] * SHANK)
            for body in (left, right)
        )
        depth[frame] = 2.0 * RADIUS - np.linalg.norm(a[:, None] - b[None], axis=-1).min()
    found = penetration(moved, scene)
    assert found.pair == ("lLowerleg", "rLowerleg")
    assert found.depth == pytest.approx(depth.max(), abs=5e-4)
    assert found.time == pytest.approx(moved.time[np.argmax(depth)])
    assert found.share == pytest.approx(np.mean(depth > 0.001), abs=0.03)
    assert 0.1 < found.share < 0.95


def test_shapes_that_a_joint_joins_do_not_count(scene):
    recording = standing(scene, 2)
    position = recording.body_position.copy()
    knee = [recording.body_names.index(name) for name in ("lUpperleg", "lLowerleg")]
    position[:, knee] = 5.0
    assert penetration(dataclasses.replace(recording, body_position=position), scene).depth == 0.0


def beside_each_other(scene, depths: np.ndarray) -> Recording:
    """The shanks upright beside each other, so deep inside each other, m."""
    recording = standing(scene, len(depths))
    position = recording.body_position.copy()
    left, right = (recording.body_names.index(name) for name in ("lLowerleg", "rLowerleg"))
    position[:, left], position[:, right] = 0.0, np.outer(2.0 * RADIUS - depths, [1.0, 0.0, 0.0])
    return dataclasses.replace(recording, body_position=position)


def test_bodies_deeper_than_a_millimetre_count_as_inside_each_other(scene):
    found = penetration(beside_each_other(scene, np.array([0.0004, 0.0009, 0.0011, 0.0012, 0.002])), scene)
    assert found.share == pytest.approx(0.6)
    assert found.depth == pytest.approx(0.002, abs=1e-6)


def test_bodies_of_a_recording_without_frames_are_at_no_time_inside_each_other(scene):
    assert penetration(beside_each_other(scene, np.zeros(0)), scene) == (0.0, 0.0, None, 0.0)


def test_who_collides_after_the_last_frame_is_nearest_in_it(scene):
    """Forearms 1 cm from each other, though shanks were nearer before; thighs that nothing tests are nearer."""
    recording = standing(scene, 3)
    position = recording.body_position.copy()
    for frame, (shanks, arms) in enumerate([(0.05, 0.30), (0.10, 0.20), (0.20, 0.11)]):
        for kind, apart, at in (("Lowerleg", shanks, 1.0), ("Lowerarm", arms, 2.0), ("Upperleg", 0.07, 3.0)):
            for side, half in (("l", 0.5), ("r", -0.5)):
                position[frame, recording.body_names.index(side + kind)] = [0.0, at, half * apart]
    moved = dataclasses.replace(recording, body_position=position)
    tested = [("lLowerleg", "rLowerleg"), ("lLowerarm", "rLowerarm")]
    failing = msgspec.structs.replace(scene.failure, self_collision=0.001, self_collision_pairs=tested)
    assert nearest_pair(moved, msgspec.structs.replace(scene, failure=failing)) == tested[1]
    assert nearest_pair(moved, scene) is None
