"""Muscles as they are drawn: as long as the kernels' paths, conditional points included."""

import itertools

import msgspec
import numpy as np
import pytest

from small_scene import muscle_scene
from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.track import Track, track_of


def shown(scene: Scene, duration: float) -> tuple[Recording, Track]:
    scene = msgspec.structs.replace(scene, duration=duration)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    recording = rollout.recording()
    return recording, track_of(recording, substitute(scene, start_values(scene)))


def drawn_lengths(track: Track) -> np.ndarray:
    """Lengths (F, M) of the polylines."""
    points, start = track.muscle_points(), track.doll.muscles.start
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1)
    return np.stack([steps[:, a : b - 1].sum(axis=1) for a, b in itertools.pairwise(start)], axis=1)


def test_lines_of_a_walk_are_as_long_as_its_muscle_paths():
    recording, track = shown(load("walk56"), 0.2)
    assert len(track.doll.muscles.names) == 56
    np.testing.assert_allclose(drawn_lengths(track), recording.muscle_path_length, atol=2e-5)


def test_conditional_point_counts_where_the_kernels_let_it_count():
    scene = muscle_scene()
    recording, track = shown(scene, 0.1)
    weight = track.point_weight[:, 0]
    assert weight[0] == pytest.approx(1.0)  # the toe begins at 0, within -1..0.5
    np.testing.assert_allclose(drawn_lengths(track)[0], recording.muscle_path_length[0], atol=2e-5)
    bent = msgspec.structs.replace(scene.character.muscles["TFL"].path[1].condition, low=0.2)
    scene.character.muscles["TFL"].path[1].condition = bent
    recording, track = shown(scene, 0.1)
    assert track.point_weight[0, 0] == 0.0
    np.testing.assert_allclose(drawn_lengths(track)[0], recording.muscle_path_length[0], atol=2e-5)
