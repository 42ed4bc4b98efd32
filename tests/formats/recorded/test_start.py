"""Simulations start in frames of recorded motions; files of other bodies, and none, are refused in a line."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest

import small_leg
import warpmuscle as wm
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.recordings.motion import recorded_motions
from warpmuscle.inverse.recordings.result import motions_result
from warpmuscle.model.build import start_of
from warpmuscle.results.partial_motion import reduced
from warpmuscle.results.recording import Recording
from warpmuscle.results.result import write
from warpmuscle.scene import InitialState, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.studies.inverse_dynamics import inverse_dynamics


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> tuple[Path, Scene, Recording]:
    """A folder with a model's scene, leg.toml, and two recorded motions of it, walk.h5; the second motion."""
    folder = tmp_path_factory.mktemp("recorded")
    body = BodyModel(small_leg.small_leg(folder), "cpu")
    motions = [small_leg.motion(12), small_leg.motion(40, seed=1)]
    trials = prepare(body, motions, None, None, None)
    states = trials.states
    effort = inverse_dynamics(body.scene, states.coordinates, states.speeds, states.rates)
    found = recorded_motions(body, trials, effort)
    write(folder / "walk.h5", motions_result(body, body.scene, dict(zip(("a", "b"), found, strict=True))))
    toml.write(body.scene, folder / "leg.toml")
    return folder, body.scene, found[1]


def scene_at(folder: Path, text: str) -> Scene:
    """A scene that is based on the model's, with these lines of its initial state."""
    (folder / "from_walk.toml").write_text(f'name = "from_walk"\nbase = "leg.toml"\n[initial_state]\n{text}\n')
    return wm.load(folder / "from_walk.toml")


def test_a_simulation_starts_where_and_as_fast_as_the_recorded_frame(recorded):
    folder, _, motion = recorded
    scene = scene_at(folder, 'file = "walk.h5"\nreplay = 1\ntime = 0.203')
    start = start_of(scene, topology(scene.character))
    assert start.coordinates[0] == pytest.approx(motion.coordinate[20], abs=1e-9)
    assert start.speeds[0] == pytest.approx(motion.speed[20], abs=1e-9)
    assert np.abs(start.speeds[0]).max() > 0.5


def test_what_was_read_is_part_of_the_scene_which_needs_the_file_no_more(recorded, tmp_path):
    folder, _, motion = recorded
    scene = scene_at(folder, 'file = "walk.h5"\nreplay = 1')
    assert scene.initial_state.file == ""
    toml.write(scene, tmp_path / "alone.toml")
    again = wm.load(tmp_path / "alone.toml")
    start = start_of(again, topology(again.character))
    assert start.coordinates[0] == pytest.approx(motion.coordinate[0], abs=1e-9)


def test_set_reads_a_recorded_start_too(recorded):
    folder, _, motion = recorded
    scene = wm.load(folder / "leg.toml", set={
        "initial_state.file": str(folder / "walk.h5"), "initial_state.replay": 1, "initial_state.time": 0.39,
    })  # fmt: skip
    assert start_of(scene, topology(scene.character)).coordinates[0] == pytest.approx(motion.coordinate[39], abs=1e-9)


def test_joints_that_the_motion_lacks_start_as_the_scene_has_them(recorded):
    folder, scene, motion = recorded
    last = motion.joint_names[-1]
    fields = ("joint_orientation", "joint_angular_velocity", "joint_torque", "joint_torque_desired", "joint_target")
    arrays = {name: motion[name][:, :-1] for name in fields} | {"joint_angle": np.zeros((motion.frames, 0))}
    short = dataclasses.replace(motion, joint_names=motion.joint_names[:-1], joint_angle_names=(), **arrays)
    write(folder / "short.h5", motions_result(BodyModel(scene, "cpu"), scene, {"short": short}))
    scene_at(folder, f'file = "short.h5"\njoints.{last}.orientation = [0.15, 0.0, 0.0, 0.9887]')
    found = wm.load(folder / "from_walk.toml")
    start = start_of(found, topology(found.character)).coordinates[0]
    assert start[:-1] == pytest.approx(motion.coordinate[0, :-1], abs=1e-9)
    assert abs(start[-1]) == pytest.approx(0.3011, abs=1e-3)
    assert abs(motion.coordinate[0, -1] - start[-1]) > 0.01


def test_a_heading_of_the_scene_turns_the_recorded_start(recorded):
    folder, scene, motion = recorded
    names = topology(scene.character)
    plain = start_of(scene_at(folder, 'file = "walk.h5"\nreplay = 1'), names)
    turned = start_of(scene_at(folder, 'file = "walk.h5"\nreplay = 1\nheading = 1.2'), names)
    assert turned.coordinates[0, 7:] == pytest.approx(motion.coordinate[0, 7:], abs=1e-9)
    assert np.abs(turned.coordinates[0, 3:7] - plain.coordinates[0, 3:7]).max() > 0.1


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ('file = "none.h5"', r"from_walk.toml:4: initial_state.file: .*none.h5: .*no such file"),
        ('file = "leg.toml"', r"initial_state.file: .*leg.toml: "),
        ('file = "walk.h5"\nreplay = 2', r"initial_state.file: .*walk.h5 has 2 motions, none with number 2"),
        ('file = "walk.h5"\nreplay = -1', r"initial_state.replay: must be 0 at least, is -1"),
        ('file = "walk.h5"\ntime = 0.2', r"initial_state.time: .*walk.h5: the motion lasts from 0 to 0.11 s"),
        ('file = "walk.h5"\ntime = nan', r"initial_state.time"),
        ('file = "a\\u0000b"', r"initial_state.file: no file can be called"),
        ("time = 0.2", r"initial_state.time: is used only with initial_state.file"),
        ("replay = 1", r"initial_state.replay: is used only with initial_state.file"),
        ('file = "lean.h5"', r"initial_state.file: .*lean.h5: the motion has no joint_angular_velocity"),
    ],
)
def test_what_cannot_be_a_start_is_refused_in_a_line(recorded, lines, message):
    folder, scene, motion = recorded
    lean = reduced(motion, ["root_position", "root_orientation", "root_velocity", "joint_orientation"])
    write(folder / "lean.h5", motions_result(BodyModel(scene, "cpu"), scene, {"lean": lean}))
    with pytest.raises(SceneError, match=message) as caught:
        scene_at(folder, lines)
    assert "\n" not in str(caught.value)


def test_a_motion_of_another_body_is_refused_by_the_joint_that_the_scene_lacks(recorded):
    folder, *_ = recorded
    (folder / "other.toml").write_text('name = "other"\nbase = "walk56"\n[initial_state]\nfile = "walk.h5"\n')
    with pytest.raises(SceneError, match=r"other.toml:4: initial_state.file: .*walk.h5: its motion has a joint '.*', "):
        wm.load(folder / "other.toml")


def test_a_scene_of_python_cannot_hold_a_file_that_nobody_reads(recorded):
    _, scene, _ = recorded
    with pytest.raises(SceneError, match=r"initial_state.file: is read with the scene's own file"):
        toml.write(msgspec.structs.replace(scene, initial_state=InitialState(file="walk.h5")), "nowhere.toml")
