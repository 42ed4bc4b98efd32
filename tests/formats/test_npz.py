"""Joint motion from NumPy archives: angles, quaternions, gait cycles, recordings of the original program; bad files."""

import io
from pathlib import Path

import numpy as np
import pytest

from biped import biped, load_recording
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError
from warpmuscle.core.pose import about, euler_xyz, normalized
from warpmuscle.formats import load, npz
from warpmuscle.scene.joints import joint_type

K = 12
PHASE, STANCE = np.arange(K) % 6 / 6.0, np.arange(K) // 6
STEPS = {"phase": PHASE, "stance": STANCE}
ANGLES = np.linspace(-1.0, 1.0, K)
QUATERNIONS = normalized(np.random.default_rng(1).normal(size=(K, 4)))


def character():
    return load("fwalk").character


def read(folder: Path, **arrays) -> npz.JointMotion:
    np.savez(folder / "a.npz", **arrays)
    return npz.read(folder / "a.npz", character())


def coordinates(motion: npz.JointMotion, joint: str) -> Floats:
    orientation = motion.joint_orientation[:, motion.joint_names.index(joint)]
    found = character().joints[joint]
    return joint_type(found).nearest(found, orientation, np.zeros((K, 3)))[0]


def test_angles_are_those_of_the_joints(tmp_path):
    two, three = np.stack([ANGLES, 0.5 * ANGLES], axis=1), np.stack([ANGLES, -0.3 * ANGLES, 0.2 + ANGLES], axis=1)
    motion = read(tmp_path, **STEPS, time=0.1 * np.arange(K), lKnee=ANGLES, rAnkle=two, lHip=three, comment=np.ones(3))
    assert motion.joint_names == ("lHip", "lKnee", "rAnkle")
    np.testing.assert_allclose(coordinates(motion, "lKnee")[:, 0], ANGLES, atol=1e-12)
    np.testing.assert_allclose(coordinates(motion, "rAnkle"), two, atol=1e-12)
    np.testing.assert_allclose(euler_xyz(motion.joint_orientation[:, 0]), three, atol=1e-12)
    np.testing.assert_array_equal(motion.window(0.55).phase, PHASE[6:])


def test_quaternions_are_taken_as_they_are_for_any_joint(tmp_path):
    motion = read(tmp_path, **STEPS, lHip=QUATERNIONS, lKnee=QUATERNIONS.astype(np.float32))
    np.testing.assert_array_equal(motion.joint_orientation[:, 0], QUATERNIONS)
    np.testing.assert_array_equal(motion.joint_orientation[:, 1], QUATERNIONS.astype(np.float32))
    assert motion.window(100.0) is motion  # without times


def test_a_gait_cycle_is_a_step_of_left_stance_and_one_of_right(tmp_path):
    motion = read(tmp_path, cycle=np.array([0.0, 0.1, 0.4999, 0.5, 0.75, 1.0]), lKnee=ANGLES[:6])
    assert motion.stance.tolist() == [0, 0, 0, 1, 1, 0]
    np.testing.assert_allclose(motion.phase, [0.0, 0.2, 0.9998, 0.0, 0.5, 0.0], atol=1e-12)


def test_recordings_of_the_original_program_are_read(reference_data: Path):
    path = reference_data / "simbicon/reference/bipV2_fWalk.npz"
    motion, recording = npz.read(path, character()), load_recording(path, biped())
    assert set(motion.joint_names) == set(recording.joint_names)
    for joint in motion.joint_names:
        expected = recording.joint_orientation[:, recording.joint_names.index(joint)]
        np.testing.assert_allclose(motion.joint_orientation[:, motion.joint_names.index(joint)], expected, atol=1e-6)
    np.testing.assert_array_equal(motion.stance, recording.stance)
    np.testing.assert_array_equal(motion.phase, recording.phase)
    np.testing.assert_array_equal(motion.time, recording.time)


NAN = np.where(np.arange(K) == 3, np.nan, 0.1)
OBJECTS = np.array([print] * K, dtype=object)
ORIGINAL = {"t": PHASE, "phi": PHASE, "stance": STANCE, "joint_names": ["lKnee"], "joint_quat": QUATERNIONS[:, None]}


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"lKnee": ANGLES}, "give either 'phase' and 'stance', or 'cycle'"),
        ({"lKnee": ANGLES, "phase": PHASE}, "array 'stance' is missing"),
        ({"lKnee": ANGLES, **STEPS, "cycle": PHASE}, "give either 'phase'"),
        ({"lKne": ANGLES, **STEPS}, "no array has the name of a joint; the character's joints are "),
        ({"lKnee": ANGLES[:5], **STEPS}, r"'lKnee' has shape \(5,\); expected \(12,\) for the angles of a hinge joint"),
        ({"lHip": ANGLES, **STEPS}, r"'lHip' has shape \(12,\); expected \(12, 3\) for the angles of a ball joint"),
        ({"lAnkle": QUATERNIONS[:, :3], **STEPS}, r"'lAnkle' .* \(12, 2\) for .* universal joint, or \(12, 4\)"),
        ({"lKnee": ANGLES * 60.0, **STEPS}, "'lKnee' goes up to 60; angles are in rad"),
        ({"lKnee": QUATERNIONS * 2.0, **STEPS}, "'lKnee' holds quaternions that are not of unit length"),
        ({"lKnee": NAN, **STEPS}, "'lKnee' holds a value that is not finite"),
        ({"lKnee": ANGLES.astype(complex), **STEPS}, "'lKnee' must hold numbers, has type complex128"),
        ({"lKnee": ANGLES.astype(str), **STEPS}, "'lKnee' must hold numbers"),
        ({"lKnee": OBJECTS, **STEPS}, "array 'lKnee' cannot be read: damaged, or of Python objects"),
        ({"lKnee": ANGLES, "phase": PHASE * 100.0, "stance": STANCE}, "'phase' goes from 0 to 1, not from 0 to 83.3"),
        ({"lKnee": ANGLES, "phase": PHASE, "stance": STANCE + 1}, r"'stance' must be 0 \(left\) or 1 \(right\)"),
        ({"lKnee": ANGLES, "phase": PHASE, "stance": STANCE[:3]}, r"'stance' has shape \(3,\), not \(12,\)"),
        ({"lKnee": ANGLES, "time": PHASE[:3], **STEPS}, r"'time' has shape \(3,\), not \(12,\)"),
        ({"lKnee": ANGLES, "cycle": PHASE[:, None]}, r"'cycle' must be a row of numbers"),
        ({"lKnee": ANGLES[:0], "cycle": PHASE[:0]}, r"'cycle' must be a row of numbers"),
        ({"lKnee": ANGLES, "cycle": PHASE, "period": 0.0}, "'period' is 0.05 to 100 s, not 0"),
        ({"lKnee": ANGLES, "cycle": PHASE, "period": [1.0, 2.0]}, r"'period' is one number, has shape \(2,\)"),
        ({"lKnee": ANGLES, **STEPS, "period": 1.0}, "'period' goes with 'cycle'"),
        ({"lKnee": ANGLES, "cycle": 2.0 * PHASE}, "'cycle' goes from 0 to 1, not from 0 to 1.6"),
        ({**ORIGINAL, "joint_quat": QUATERNIONS}, r"'joint_quat' has shape \(12, 4\), not \(12, 1, 4\)"),
        ({**ORIGINAL, "joint_names": [1.0]}, "'joint_names' must be a row of names"),
        ({key: ORIGINAL[key] for key in ORIGINAL if key != "phi"}, "array 'phi' is missing, which goes with"),
    ],
)  # fmt: skip
def test_arrays_that_do_not_fit_are_named(tmp_path, arrays: dict, message: str):
    with pytest.raises(ResultError, match=r"a\.npz: " + message) as caught:
        read(tmp_path, **arrays)
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("error::RuntimeWarning")  # and not what other tests have left open
def test_huge_quaternions_are_refused_without_a_warning(tmp_path):
    with pytest.raises(ResultError, match="'lHip' holds quaternions that are not of unit length"):
        read(tmp_path, **STEPS, lHip=1e300 * QUATERNIONS)


def test_what_is_no_archive_is_an_error(tmp_path):
    np.save(tmp_path / "b.npy", ANGLES)
    memory = io.BytesIO()
    np.savez(memory, **STEPS, lKnee=ANGLES)
    whole = memory.getvalue()
    contents = {
        "empty": b"", "text": b"phase,stance\n0,1\n", "row": (tmp_path / "b.npy").read_bytes(),
        "cut": whole[: len(whole) // 2], "pickle": b"\x80\x04\x95\x0b",
    }  # fmt: skip
    for name, content in contents.items():
        (tmp_path / f"{name}.npz").write_bytes(content)
        with pytest.raises(ResultError, match=rf"{name}\.npz: not an \.npz file, or damaged"):
            npz.read(tmp_path / f"{name}.npz", character())
    for path, message in ((tmp_path / "no.npz", "there is no such file"), (tmp_path, "this is a folder")):
        with pytest.raises(ResultError, match=message):
            npz.read(path, character())


def test_damaged_archives_never_give_anything_but_an_error(tmp_path):
    memory, path, known = io.BytesIO(), tmp_path / "a.npz", character()
    np.savez_compressed(memory, **STEPS, lKnee=ANGLES)
    whole, random = memory.getvalue(), np.random.default_rng(2)
    for _ in range(300):
        broken = bytearray(whole)
        for place in random.integers(0, len(whole), 3):
            broken[place] = random.integers(0, 256)
        path.write_bytes(bytes(broken))
        try:
            motion = npz.read(path, known)
        except ResultError:
            continue
        assert np.isfinite(motion.joint_orientation).all()


def test_hinge_angles_turn_about_the_joints_axis(tmp_path):
    motion = read(tmp_path, **STEPS, lKnee=ANGLES)
    axis = normalized(character().joints["lKnee"].axes[0])
    np.testing.assert_allclose(motion.joint_orientation[:, 0], about(axis, ANGLES), atol=1e-15)
