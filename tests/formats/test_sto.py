"""Motions as OpenSim storage and comma-separated values: headers, names, angles that give the motion back."""

import msgspec
import numpy as np
import pytest

from opensim_table import table
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about, euler_xyz, multiply
from warpmuscle.formats import load, sto
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def walk() -> tuple[Recording, Scene]:
    """A short walk on muscles."""
    scene = msgspec.structs.replace(load("walk56"), duration=0.5)
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    return rollout.recording(), scene


def test_angles_of_a_ball_joint_give_its_orientation_back():
    rng = np.random.default_rng(0)
    q = rng.normal(size=(200, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    angles = euler_xyz(q)
    x, y, z = (about(np.eye(3)[k], angles[:, k]) for k in range(3))
    same = np.abs(np.sum(multiply(multiply(x, y), z) * q, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-9)


def test_mot_holds_angles_in_degrees_for_opensim(walk, tmp_path):
    motion, scene = walk
    sto.write(motion, scene, tmp_path / "walk.mot")
    header, names, rows = table(tmp_path / "walk.mot")
    assert (header["inDegrees"], header["nRows"], header["nColumns"]) == ("yes", str(len(rows)), str(len(names)))
    assert {
        "time",
        "pelvis_tilt",
        "pelvis_list",
        "pelvis_rotation",
        "pelvis_tz",
        "lHip_x",
        "lKnee",
        "lAnkle_a",
        "lAnkle_b",
    } < set(names)
    k = motion.joint_names.index("lKnee")
    half = np.radians(rows[:, names.index("lKnee")]) / 2.0
    np.testing.assert_allclose(np.sin(half), motion.joint_orientation[:, k, 0], atol=1e-6)
    for axis, ours in {"x": motion.root_position[:, 2], "y": motion.root_position[:, 1]}.items():
        np.testing.assert_allclose(rows[:, names.index(f"pelvis_t{axis}")], ours, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(rows[:, names.index("pelvis_tz")], -motion.root_position[:, 0], atol=1e-7)


def test_the_title_of_a_file_steers_no_terminal(walk, tmp_path):
    motion, scene = walk
    sto.write(motion, msgspec.structs.replace(scene, name="a\x1b[31m\nb\u202e"), tmp_path / "walk.mot")
    assert (tmp_path / "walk.mot").read_text().splitlines()[:2] == [r"a\x1b[31m b\u202e", "version=1"]


def test_sto_holds_activations_and_forces(walk, tmp_path):
    motion, scene = walk
    sto.write(motion, scene, tmp_path / "walk.sto")
    header, names, rows = table(tmp_path / "walk.sto")
    assert header["inDegrees"] == "no"
    m = motion.muscle_names.index("rSOL")
    np.testing.assert_allclose(rows[:, names.index("rSOL.force")], motion.muscle_force[:, m], rtol=1e-6)
    np.testing.assert_allclose(rows[:, names.index("rSOL.activation")], motion.muscle_activation[:, m], rtol=1e-6)


def test_csv_holds_both(walk, tmp_path):
    motion, scene = walk
    sto.write(motion, scene, tmp_path / "walk.csv")
    _, names, rows = table(tmp_path / "walk.csv")
    assert {"lKnee", "rSOL.force"} < set(names)
    assert rows.shape == (motion.frames, len(names))


def test_what_cannot_be_written_is_said(walk, tmp_path):
    motion, scene = walk
    with pytest.raises(Error, match=r"\.mot, \.sto, \.csv"):
        sto.write(motion, scene, tmp_path / "walk.txt")
    torque = load("fwalk")
    rollout = Rollout(msgspec.structs.replace(torque, duration=0.1), 1, "cpu", record=[0])
    rollout.run()
    with pytest.raises(Error, match="no muscles"):
        sto.write(rollout.recording(), torque, tmp_path / "walk.sto")
    assert not list(tmp_path.iterdir())
