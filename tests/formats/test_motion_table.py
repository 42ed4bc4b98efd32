"""Motions of OpenSim's storage files and of exports, as references to track."""

import re
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import ResultError
from warpmuscle.formats import load, motion_table, sto
from warpmuscle.gait.cycles import strides
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Objective, Scene, Tracking
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.reference_gait import motion_in_file
from warpmuscle.simulation.rollout import Rollout

KNEES = "time\tlKnee\trKnee\n"


def plain(name: str) -> Scene:
    scene = load(name)
    return substitute(scene, start_values(scene))


@pytest.fixture(scope="module")
def walk() -> Recording:
    scene = plain("fwalk")
    scene.duration = 5.0
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run()
    return rollout.recording()


@pytest.mark.parametrize("name", ["walk.mot", "walk.csv"])
def test_an_export_comes_back_with_its_angles_and_its_steps(walk, name, tmp_path):
    scene = plain("fwalk")
    sto.write(walk, scene, tmp_path / name)
    motion = motion_table.read(tmp_path / name, scene)
    assert set(motion.joint_names) == set(walk.joint_names)
    order = [walk.joint_names.index(joint) for joint in motion.joint_names]
    frames = np.searchsorted(walk.time, motion.time - 1e-6)
    same = np.sum(motion.joint_orientation * walk.joint_orientation[frames][:, order], axis=-1)
    np.testing.assert_allclose(np.abs(same), 1.0, atol=1e-6)  # cosine of half the angle between them
    downs = motion.time[np.flatnonzero(np.diff(motion.stance) == -1) + 1]
    contacts = np.array([down for down, _ in strides(walk, "left")])
    assert len(downs) > 0
    for down in downs:
        assert np.abs(contacts - down).min() < 0.05  # of a cycle of 1.15 s
    assert motion.by_contact
    assert set(motion.stance) == {0, 1}


@pytest.mark.usefixtures("unoptimized_test")
def test_coordinates_of_an_opensim_model_turn_its_balls_as_they_were(tmp_path):
    scene = plain("gait2392_walk")
    scene.duration = 3.5
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=100.0)
    rollout.run()
    recording = rollout.recording()
    sto.write(recording, scene, tmp_path / "walk.mot")
    motion = motion_table.read(tmp_path / "walk.mot", scene)
    assert {"hip_r", "knee_angle_l"} < set(motion.joint_names)
    frames = np.searchsorted(recording.time, motion.time - 1e-6)
    for index, name in enumerate(motion.joint_names):
        there = recording.joint_orientation[frames, recording.joint_names.index(name)]
        same = np.sum(motion.joint_orientation[:, index] * there, axis=-1)
        np.testing.assert_allclose(np.abs(same), 1.0, atol=1e-6)


def test_a_measured_walk_steps_where_force_plates_say(reference_data):
    folder = reference_data / "opensim_walk"
    with pytest.warns(UserWarning, match="falls"):
        scene = load(folder / "subject01.osim", ignored=None)
    scene.character.feet = ("calcn_l", "calcn_r")
    motion = motion_table.read(folder / "ik/subject01_walk_IK.mot", scene)
    # Left force (1_ground_force_vy of subject01_walk_grf.mot) from 1.247 s and again from 2.46 s on.
    assert motion.time[0] == pytest.approx(1.247, abs=0.06)
    assert motion.time[-1] == pytest.approx(2.46, abs=0.06)


def knees(path: Path, text: str, header: str = "inDegrees=yes\n") -> Path:
    path.write_text(f"x\n{header}endheader\n{text}")
    return path


def test_columns_that_are_no_coordinates_may_hold_anything(tmp_path):
    text = "time\tcycle\tlKnee\tnote\n0\t0\t30\tfirst\n1\t0.5\t20\tlast\n"
    motion = motion_table.read(knees(tmp_path / "a.mot", text), plain("fwalk"))
    assert motion.joint_names == ("lKnee",)


def test_units_are_those_of_the_header_and_paths_of_states_are_understood(tmp_path):
    scene = plain("fwalk")
    rows = "0.0\t0.0\t30\t-7\n0.5\t0.5\t45\t-7\n1.0\t1.0\t30\t-7\n"
    names = "time\tcycle\t/jointset/left/lKnee/value\t/jointset/left/lKnee/speed\n"
    degrees = motion_table.read(knees(tmp_path / "d.sto", names + rows), scene)
    turn = 2.0 * np.arccos(np.abs(degrees.joint_orientation[:, 0, 3]))
    np.testing.assert_allclose(np.degrees(turn), [30.0, 45.0, 30.0], atol=1e-6)
    rows = rows.replace("30", "0.5").replace("45", "0.7")
    radians = motion_table.read(knees(tmp_path / "r.mot", names + rows, "inDegrees=no\n"), scene)
    turn = 2.0 * np.arccos(np.abs(radians.joint_orientation[:, 0, 3]))
    np.testing.assert_allclose(turn, [0.5, 0.7, 0.5], atol=1e-6)
    assert radians.by_contact
    np.testing.assert_array_equal(radians.stance, [0, 1, 0])


@pytest.mark.parametrize(
    ("text", "header", "message"),
    [
        ("time\tcycle\tlKnee\n0\t0\t30\n", "", "a.mot: the header does not tell the unit of angles: write"),
        ("time\tcycle\tlKnee\n0\t0\t30\n", "inDegrees=no\n", "column 'lKnee' goes beyond a whole turn in rad"),
        ("time\tcycle\tknee\n0\t0\t30\n", "inDegrees=yes\n", "no column has the name of a coordinate"),
        ("time\tcycle\tlHip_x\n0\t0\t30\n", "inDegrees=yes\n", "has no column 'lHip_y', which goes with 'lHip_x'"),
        ("time\tcycle\tlKnee\n0\t0\tnan\n", "inDegrees=yes\n", "column 'lKnee' holds a value that is not finite"),
        ("time\tcycle\tlKnee\n0\t0\tx\n", "inDegrees=yes\n", "'x' is not a number"),
        ("time\tcycle\tlKnee\n0\t2\t3\n", "inDegrees=yes\n", "'cycle' goes from 0 to 1, not from 2 to 2"),
        ("lKnee\n30\n", "inDegrees=yes\n", "has no column 'time', nor 'cycle'"),
        (KNEES + "0\t1\t2\n0\t1\t2\n", "inDegrees=yes\n", "times must increase"),
        (KNEES + "0\t1\t2\n1\t1\t2\n2\t1\t2\n", "inDegrees=yes\n", "holds no whole gait cycle of the left foot"),
        (KNEES, "inDegrees=yes\n", "no rows"),
    ],
)
def test_what_cannot_be_tracked_is_one_line(text, header, message, tmp_path):
    with pytest.raises(ResultError, match=re.escape(message)):
        motion_table.read(knees(tmp_path / "a.mot", text, header), plain("fwalk"))


def test_a_scene_tracks_the_exported_motion_of_its_own_gait_closely(walk, tmp_path):
    scene = plain("fwalk")
    sto.write(walk, scene, tmp_path / "walk.mot")
    assert motion_in_file(Tracking(file=str(tmp_path / "walk.mot")), scene).by_contact
    errors = []
    for name in ("fwalk", "bwalk"):
        scene = load(name)
        scene.duration, scene.objective = 5.0, Objective(tracking=1.0)
        scene.tracking = Tracking(file=str(tmp_path / "walk.mot"), start=0.0)
        rollout = Rollout(scene, 1, "cpu")
        rollout.run()
        errors.append(float(rollout.terms()["tracking"][0]))
    assert errors[0] < 0.1 * errors[1]
