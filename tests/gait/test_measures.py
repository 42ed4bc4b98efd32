"""Gait measures against the original program's gait table and against walks made up to order."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from biped import biped, load_recording, random_recording
from warpmuscle.core.errors import ArgumentError, Error
from warpmuscle.formats import load
from warpmuscle.gait.measures import feet_of, measure
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording


def walk(speed: float, width: float, step_time: float, duration: float, heading: float = 0.0) -> Recording:
    """Two feet that take turns, placed under a centre of mass at constant speed; the heading turns evenly in time."""
    time = np.arange(round(duration * 100) + 1) / 100.0
    steps = np.floor(time / step_time + 1e-9).astype(int)
    landing = speed * step_time * steps
    zero = np.zeros_like(time)
    half = heading * time / duration / 2.0
    feet = []
    for side, sign in ((0, 1.0), (1, -1.0)):
        last = np.where(steps % 2 == side, landing, landing - speed * step_time)
        feet.append(np.stack([zero + sign * width / 2.0, zero, last], axis=1))
    arrays = {name: array[: len(time)] for name, array in _arrays(len(time)).items()} | {
        "time": time,
        "stance": steps % 2,
        "foot_force_left": footfalls(steps % 2 == 0),
        "foot_force_right": footfalls(steps % 2 == 1),
        "com_velocity": np.stack([zero, zero, zero + speed], axis=1),
        "root_orientation": np.stack([zero, np.sin(half), zero, np.cos(half)], axis=1),
        "body_position": np.stack([feet[0] * 0.0, *feet], axis=1),
    }
    return Recording.of(arrays, ("l", "r"), ("root", "left", "right"))


def footfalls(loaded: np.ndarray) -> np.ndarray:
    """Forces (F, 3), N, on a foot that carries the body or does not."""
    return np.outer(loaded, [0.0, 700.0, 0.0])


def _arrays(frames: int) -> dict[str, np.ndarray]:
    recording = random_recording(frames, joints=2)
    return {name: recording[name] for name in QUANTITIES}


# speed, step length, step width, cadence of the table that comes with the recordings
TABLE = {
    "bipV2_fWalk": (0.954, 0.544, 0.110, 105.3),
    "bipV2_bWalk": (-0.605, -0.281, 0.108, 129.2),
    "bipV2_iWalk": (0.012, 0.006, 0.109, 120.0),
    "bipV2_fJog": (1.494, 0.591, 0.135, 149.8),
}


@pytest.mark.parametrize("name", TABLE)
def test_recorded_gaits_have_the_measures_of_the_original_table(name: str, reference_data: Path):
    recording = load_recording(reference_data / f"simbicon/reference/{name}.npz", biped())
    gait = measure(recording, "lFoot", "rFoot", start=5.0, by="stance")
    speed, length, width, cadence = TABLE[name]
    assert gait.speed_forward == pytest.approx(speed, abs=1e-3)
    assert gait.step_length == pytest.approx(length, abs=1e-3)
    assert gait.step_width == pytest.approx(width, abs=8e-3)  # the table sampled the moment of stance 20 times finer
    assert gait.cadence == pytest.approx(cadence, abs=0.15)
    assert abs(gait.heading_drift) < 0.05


@pytest.mark.parametrize("speed", [1.2, -0.7, 0.0])
def test_made_up_walk_gives_back_what_it_was_made_of(speed: float):
    gait = measure(walk(speed, width=0.2, step_time=0.5, duration=12.0), "left", "right")
    assert gait.speed_forward == pytest.approx(speed)
    assert gait.speed_horizontal == pytest.approx(abs(speed))
    assert gait.step_length == pytest.approx(0.5 * speed)
    assert gait.step_width == pytest.approx(0.2)
    assert gait.cadence == pytest.approx(120.0)
    assert (gait.start, gait.end, gait.steps) == (5.0, 12.0, 14)


def test_steps_are_counted_where_feet_touch_down_and_not_where_the_controller_changes_its_stance():
    recording = walk(1.0, width=0.2, step_time=0.5, duration=12.0)
    early = dataclasses.replace(recording, stance=np.roll(recording.stance, -8))  # 80 ms before the foot lands
    assert measure(early, "left", "right") == measure(recording, "left", "right")
    slow = dataclasses.replace(recording, stance=recording.stance * 0)
    assert measure(slow, "left", "right") == measure(recording, "left", "right")
    assert measure(slow, "left", "right", by="stance").cadence is None


def test_heading_drift_counts_whole_turns_of_the_window():
    gait = measure(walk(1.0, 0.2, 0.5, duration=10.0, heading=6.0 * np.pi), "left", "right", start=5.0)
    assert gait.heading_drift == pytest.approx(3.0 * np.pi)


def test_steps_are_seen_in_the_frame_of_the_character():
    straight = walk(1.0, width=0.2, step_time=0.5, duration=10.0)
    turn = np.array([0.0, np.sin(0.4), 0.0, np.cos(0.4)])  # heading 0.8 rad
    cos, sin = np.cos(0.8), np.sin(0.8)
    matrix = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    turned = dataclasses.replace(
        straight,
        root_orientation=np.tile(turn, (straight.frames, 1)),
        body_position=straight.body_position @ matrix.T,
        com_velocity=straight.com_velocity @ matrix.T,
    )
    gait = measure(turned, "left", "right")
    assert gait.step_length == pytest.approx(0.5)
    assert gait.step_width == pytest.approx(0.2)
    assert gait.speed_forward == pytest.approx(cos)
    assert gait.speed_horizontal == pytest.approx(1.0)


@pytest.mark.parametrize("way", [0.0, 0.8, -2.5])
@pytest.mark.parametrize("width", [0.08, 0.0, -0.05])
def test_width_is_that_of_the_placements_however_the_pelvis_turns(width: float, way: float):
    straight = walk(1.2, width=width, step_time=0.5, duration=12.0)
    sway = 0.3 * np.sin(2.0 * np.pi * straight.time + 0.4) + 0.2 + way  # rad, once a stride, off to the left
    cos, sin = np.cos(way), np.sin(way)
    matrix = np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
    zero = np.zeros_like(sway)
    turned = dataclasses.replace(
        straight,
        root_orientation=np.stack([zero, np.sin(0.5 * sway), zero, np.cos(0.5 * sway)], axis=1),
        body_position=straight.body_position @ matrix.T,
    )
    gait = measure(turned, "left", "right")
    assert gait.step_width == pytest.approx(width, abs=1e-6)
    assert gait.step_length == pytest.approx(0.6, abs=1e-6)


def test_the_third_landing_is_the_first_that_has_a_line_and_a_width():
    of_three, of_two = (measure(walk(1.0, 0.2, 0.5, duration), "left", "right", start=0.0) for duration in (1.6, 1.1))
    assert (of_three.steps, of_two.steps) == (2, 1)
    assert of_three.step_width == pytest.approx(0.2)
    assert of_two.step_width is None
    assert of_two.step_length == pytest.approx(0.5)


def test_each_step_has_the_line_of_the_stride_that_it_ends():
    """On a winding way, against the places of the feet as they come down."""
    straight = walk(1.0, width=0.2, step_time=0.5, duration=10.0)
    steps = np.floor(2.0 * straight.time + 1e-9).astype(int)
    aside = 0.1 * np.sin(1.3 * np.arange(-1, 21))  # m, of the feet where they come down, one after the other
    places = straight.body_position.copy()
    for side in (0, 1):
        places[:, 1 + side, 0] += aside[np.where(steps % 2 == side, steps, steps - 1) + 1]
    gait = measure(dataclasses.replace(straight, body_position=places), "left", "right", start=2.6)
    down = np.array([places[50 * k, 1 + k % 2] for k in range(21)])
    lengths, widths = [], []
    for k in range(6, 21):
        stride = (down[k] - down[k - 2]) / np.linalg.norm(down[k] - down[k - 2])
        step = down[k] - down[k - 1]
        lengths.append(step @ stride)
        outwards = 1.0 if (k - 1) % 2 == 0 else -1.0
        widths.append(-outwards * (step @ np.cross([0.0, 1.0, 0.0], stride)))
    assert gait.steps == 15
    assert np.ptp(widths) > 0.05
    assert gait.step_width == pytest.approx(np.mean(widths), abs=1e-6)
    assert gait.step_length == pytest.approx(np.mean(lengths), abs=1e-6)


@pytest.mark.parametrize(("stride", "width"), [(0.11, 0.2), (0.09, 0.2 * np.cos(0.5))])
def test_a_stride_of_a_tenth_of_a_metre_has_a_direction_and_for_a_shorter_one_the_heading_counts(stride, width):
    straight = walk(stride, width=0.2, step_time=0.5, duration=12.0)
    turn = np.array([0.0, np.sin(0.25), 0.0, np.cos(0.25)])  # the pelvis is turned by 0.5 rad from the way
    turned = dataclasses.replace(straight, root_orientation=np.tile(turn, (straight.frames, 1)))
    assert measure(turned, "left", "right").step_width == pytest.approx(width, abs=1e-3)


def test_width_on_the_spot_and_backwards_is_of_the_side_that_the_character_faces():
    for speed in (0.0, -0.8):
        assert measure(walk(speed, 0.15, 0.5, 12.0), "left", "right").step_width == pytest.approx(0.15)
        assert measure(walk(speed, -0.05, 0.5, 12.0), "left", "right").step_width == pytest.approx(-0.05)


@pytest.mark.parametrize("start", [5.0, 3.1])  # beyond the end; too late for three steps
def test_short_recording_is_measured_from_its_first_quarter(start: float):
    gait = measure(walk(1.0, 0.2, 0.5, duration=4.0), "left", "right", start)
    assert (gait.start, gait.steps) == (1.0, 6)
    assert gait.cadence == pytest.approx(120.0)


def test_without_steps_there_is_a_speed_but_no_step():
    gait = measure(walk(1.0, 0.2, step_time=9.0, duration=2.0), "left", "right")
    assert gait.speed_forward == pytest.approx(1.0)
    assert (gait.steps, gait.step_length, gait.step_width, gait.cadence) == (0, None, None, None)


def test_one_frame_is_enough_and_none_is_an_error():
    recording = walk(1.0, 0.2, 0.5, duration=2.0)
    assert measure(recording.window(2.0), "left", "right").speed_forward == pytest.approx(1.0)
    with pytest.raises(ValueError, match="without frames"):
        measure(recording.window(3.0), "left", "right")


def test_a_scene_names_the_feet_and_bipeds_have_usual_names():
    scene = load("walk56_person")
    recording = walk(1.0, 0.2, 0.5, 12.0)
    named = dataclasses.replace(recording, body_names=("root", *feet_of(scene)))
    wanted = measure(recording, "left", "right")
    assert measure(named, scene) == measure(named) == wanted
    with pytest.raises(Error, match="has no legs to walk on"):
        measure(named, load("throw"))
    with pytest.raises(ArgumentError, match="no body is called 'lFoot'"):
        measure(recording)


def test_a_leap_with_both_feet_at_once_has_no_cadence():
    leap = walk(1.0, 0.1, 0.5, 2.0)
    air = np.abs(leap.time - 1.2) < 0.3
    leap = dataclasses.replace(leap, foot_force_left=footfalls(~air), foot_force_right=footfalls(~air))
    gait = measure(leap, "left", "right")
    assert gait.cadence is None
    assert gait.speed_forward == pytest.approx(1.0)
