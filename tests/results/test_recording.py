"""Recordings: shapes that fit their names, windows of time."""

import dataclasses

import numpy as np
import pytest

from biped import random_recording
from warpmuscle.kernels.recording.recorded import MUSCLE_PLACES
from warpmuscle.results.quantity import RawFrames
from warpmuscle.results.recorded_quantities import (
    INTEGER_QUANTITIES,
    MUSCLE_QUANTITIES,
    NAMED,
    QUANTITIES,
    UNITS,
    declared,
)
from warpmuscle.results.recording import Recording


def test_every_field_but_the_names_is_a_described_quantity():
    fields = {one.name for one in dataclasses.fields(Recording)} - {*NAMED.values(), *UNITS.values()}
    assert fields == set(QUANTITIES)
    assert set(INTEGER_QUANTITIES) < fields


def test_an_array_that_declares_no_quantity_is_told():
    forgetful = dataclasses.make_dataclass("Forgetful", [("names", "tuple[str, ...]"), ("com", "Floats")])
    with pytest.raises(TypeError, match=r"com of Forgetful declares no quantity: give it a `quantity\(...\)`"):
        declared(forgetful)


def test_a_quantity_made_of_what_nothing_writes_is_told():
    raw = RawFrames(np.zeros(3), {"com": np.zeros((3, 1, 3))}, [], np.zeros((3, 3)), np.zeros((1, 3)))
    assert raw["com"].shape == (3, 1, 3)
    with pytest.raises(TypeError, match="made of 'centre', which nothing writes: there are com"):
        raw["centre"]


def test_quantities_of_muscles_stand_in_the_order_in_which_a_device_writes_them():
    written = np.arange(MUSCLE_PLACES)[None, :, None] * np.ones((3, 1, 2))
    raw = RawFrames(np.zeros(3), {"muscle": written}, [], np.zeros((3, 3)), np.zeros((1, 3)))
    places = [QUANTITIES[name].of(raw)[0, 0] for name in MUSCLE_QUANTITIES]
    assert places == list(range(MUSCLE_PLACES))


def test_a_shape_that_does_not_fit_is_named():
    arrays = {name: random_recording(frames=5)[name] for name in QUANTITIES}
    arrays["joint_torque"] = arrays["joint_torque"][:, :2]
    with pytest.raises(ValueError, match=r"torque has shape \(5, 2, 3\), not \(5, 3, 3\) \(frame, joint, x y z\)"):
        Recording.of(arrays, ("a", "b", "c"), ("r", "a", "b", "c"))


def test_a_recording_ends_at_its_last_frame_and_at_nothing_without_frames():
    recording = random_recording(frames=11)
    assert recording.at([0, 3]).end == recording.time[3] > 0.0
    assert recording.at(slice(0)).end == 0.0


def test_window_keeps_the_frames_within_it():
    recording = random_recording(frames=11)
    recording.time[:] = np.linspace(0.0, 1.0, 11)
    window = recording.window(0.25, 0.8)
    np.testing.assert_allclose(window.time, [0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    assert np.array_equal(window.joint_target, recording.joint_target[3:9])
    assert (window.frames, recording.window(0.95).frames) == (6, 1)


def test_position_of_a_body_by_name():
    recording = random_recording()
    assert np.array_equal(recording.position_of("part2"), recording.body_position[:, 2])
    with pytest.raises(ValueError, match="tail"):
        recording.position_of("tail")
