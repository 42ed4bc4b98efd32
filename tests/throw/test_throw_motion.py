"""Recorded motions: what files may hold, what is refused, and smooth derivatives up to the ends."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.throw.motion import MARGIN, ArmMotion, resample, without_stillness
from warpmuscle.throw.recordings.motion_files import read

JOINTS = ("shoulder", "elbow")
TIME = np.arange(0.0, 1.001, 0.02)


def table(tmp_path: Path, header: str, *columns: np.ndarray) -> Path:
    path = tmp_path / "throw.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="")
    return path


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("time_s,shoulder_deg,elbow_deg", 180.0 / np.pi),
        ("time,elbow_flexion_rad,shoulder_flexion_rad", 1.0),
        ("T,Shoulder,Elbow", 180.0 / np.pi),
        ("t,shoulder,elbow", 1.0),
    ],
)
def test_units_follow_the_names_or_the_size_of_the_angles(tmp_path: Path, header: str, factor: float):
    shoulder, elbow = 0.5 + TIME, 2.0 - TIME
    columns = (elbow, shoulder) if header.startswith("time,elbow") else (shoulder, elbow)
    path = table(tmp_path, header, TIME - 0.4, *(c * factor for c in columns))
    motion = read(path, JOINTS)[0]
    assert motion.start == pytest.approx(-0.4)
    np.testing.assert_allclose(motion.angles, np.stack([shoulder, elbow], axis=1), atol=1e-12)
    np.testing.assert_allclose(motion.time, TIME, atol=1e-12)


def test_the_trunks_pitch_follows_from_the_angle_to_gravity(tmp_path: Path):
    header = "time,shoulder_deg,elbow_deg,shoulder_flexion_gravity_deg,shoulder_forward_m,shoulder_up_m"
    path = table(tmp_path, header, TIME, 20.0 + TIME, 30.0 * TIME, 5.0 + TIME, TIME**2, 1.4 + 0.0 * TIME)
    motion = read(path, JOINTS)[0]
    np.testing.assert_allclose(motion.pitch, np.radians(15.0))  # leaning forwards lessens the angle to gravity
    np.testing.assert_allclose(motion.place[:, 0], TIME**2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("time,shoulder\n" + "".join(f"{t},1\n" for t in range(20)), "elbow_deg"),
        ("shoulder,elbow\n" + "1,1\n" * 20, "time"),
        ("time,shoulder,elbow\n" + "".join(f"{t},1,1\n" for t in range(5)), "5 samples"),
        ("time,shoulder,elbow\n" + "".join(f"{min(t, 7)},1,1\n" for t in range(20)), "increase"),
        ("time,shoulder,elbow\n" + "".join(f"{t},1,nan\n" for t in range(20)), ":2: column 'elbow'"),
        ("time,shoulder,elbow\n" + "".join(f"{t},1,x\n" for t in range(20)), "'x' is not a number"),
        ("time,shoulder,elbow\n0,1\n", "cells"),
        ("time,shoulder,elbow\n" + "".join(f"{10 * t},1,1\n" for t in range(20)), "seconds"),
    ],
)
def test_unusable_files_are_refused_in_one_line_with_their_name(tmp_path: Path, text: str, message: str):
    path = tmp_path / "throw.csv"
    path.write_text(text)
    with pytest.raises(Error, match=r"throw\.csv") as error:
        read(path, JOINTS)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_and_foreign_files_are_refused(tmp_path: Path):
    with pytest.raises(Error, match="no such file"):
        read(tmp_path / "none.csv", JOINTS)
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    with pytest.raises(Error, match=r"bad\.npz"):
        read(tmp_path / "bad.npz", JOINTS)


def test_many_motions_are_read_from_arrays(tmp_path: Path):
    angles = np.degrees(np.stack([TIME, 2.0 * TIME]))
    place = np.zeros((2, len(TIME), 2, 3))
    place[:, :, 1, 2] = 1.5
    np.savez(
        tmp_path / "two.npz", time=TIME, shoulder_flexion=angles, elbow_flexion=angles, trial=np.array(["a", "b"]),
        keypoint_pos_m=place, keypoints=np.array(["R_HIP", "R_SHOULDER"]),
    )  # fmt: skip
    motions = read(tmp_path / "two.npz", JOINTS)
    assert [motion.name for motion in motions] == ["a", "b"]
    np.testing.assert_allclose(motions[1].angles[:, 0], 2.0 * TIME)
    np.testing.assert_allclose(motions[0].place, np.tile([0.0, 1.5], (len(TIME), 1)))
    np.savez(tmp_path / "ms.npz", time_ms=1e3 * TIME, shoulder_deg=angles, elbow=angles)
    np.testing.assert_allclose(read(tmp_path / "ms.npz", JOINTS)[0].time, TIME, atol=1e-12)


@pytest.mark.parametrize("name", ["time", "elbow_flexion"])
@pytest.mark.parametrize("kind", ["c8", "U8", "M8[s]", "?"])
def test_arrays_of_other_than_numbers_are_refused_by_their_name(tmp_path: Path, name: str, kind: str):
    angles = np.stack([80.0 + 20.0 * TIME, 90.0 + 20.0 * TIME])
    arrays = {"time": TIME, "shoulder_flexion": angles, "elbow_flexion": angles}
    np.savez(tmp_path / "a.npz", **arrays | {name: np.ones(arrays[name].shape, int).astype(kind)})
    with pytest.raises(Error, match=rf"a\.npz: motion 0: column '{name}.*holds values of type .*, not numbers"):
        read(tmp_path / "a.npz", JOINTS)


@pytest.mark.parametrize(
    "wrong",
    [{"trial": np.array(["a"])}, {"keypoint_pos_m": np.zeros((1, len(TIME), 1, 3)), "keypoints": ["R_SHOULDER"]}],
)
def test_names_and_points_of_another_number_of_motions_are_refused(tmp_path: Path, wrong: dict):
    angles = np.stack([80.0 + 20.0 * TIME, 90.0 + 20.0 * TIME])
    np.savez(tmp_path / "a.npz", time=TIME, shoulder_flexion=angles, elbow_flexion=angles, **wrong)
    with pytest.raises(Error, match=r"a\.npz: `.*` has shape"):
        read(tmp_path / "a.npz", JOINTS)


def made(time: np.ndarray) -> ArmMotion:
    angles = np.stack([np.sin(3.0 * time), np.cos(2.0 * time)], axis=1)
    return ArmMotion("made", 0.0, time, angles, 0.1 * time, np.zeros((len(time), 2)))


def test_derivatives_are_those_of_the_motion_and_stay_small_at_its_ends():
    regular = resample([made(TIME)])
    time = regular.time[15:-15]
    np.testing.assert_allclose(regular.angles[0][0, 15:-15, 0], np.sin(3.0 * time), atol=1e-6)
    np.testing.assert_allclose(regular.angles[2][0, 15:-15, 0], -9.0 * np.sin(3.0 * time), atol=1e-2)
    assert np.abs(regular.angles[2]).max() < 12.0


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_accelerations_at_the_ends_of_a_file_are_those_of_the_motion(noise: float):
    """Of a motion that is cut where it accelerates, with noise, deg: no more error at the ends than in between."""
    time = np.arange(0.0, 0.801, 0.01)
    errors = []
    for start in np.arange(0.0, 6.0, 0.1):
        angle = np.sin(6.0 * (time + start))
        noisy = angle + np.radians(noise) * np.random.default_rng(int(10 * start)).normal(size=time.shape)
        motion = ArmMotion("cut", 0.0, time, noisy[:, None], 0.0 * time, np.zeros((len(time), 2)))
        errors.append(resample([motion]).angles[2][0, :, 0] + 36.0 * angle)
    size = np.sqrt(np.mean(np.square(errors), axis=0))
    assert size[[0, -1]].max() < max(1.2 * size[10:-10].max(), 3.0)  # rad/s^2, of 36


def test_shorter_motions_come_to_rest_beyond_their_end_without_a_jump():
    motions = resample([made(TIME), made(TIME[:26])])
    assert motions.valid.sum(axis=1).tolist() == [101.0, 51.0]
    angle, speed, bend = (part[1, 48:, 0] for part in motions.angles)
    assert np.abs(np.diff(speed)).max() < 1.0  # rad/s, of 3
    np.testing.assert_allclose(np.gradient(angle, 0.01)[1:-1], speed[1:-1], atol=0.1)
    assert np.abs(angle[20:] - angle[2]).max() < 3.0 * MARGIN
    assert max(np.abs(speed[35:]).max(), np.abs(bend[35:]).max()) < 1e-3
    assert motions.rows([1]).names == ("made",)


@pytest.mark.parametrize(("before", "after"), [(0, 50), (30, 0), (30, 50), (4, 4)])
def test_ends_in_which_nothing_moves_are_left_out_and_counted(before: int, after: int):
    moving = made(TIME)
    padded = replace(
        moving, time=0.02 * np.arange(len(TIME) + before + after), pitch=np.pad(moving.pitch, (before, after), "edge"),
        **{name: np.pad(getattr(moving, name), ((before, after), (0, 0)), "edge") for name in ("angles", "place")},
    )  # fmt: skip
    found = without_stillness(padded)
    short = before + after < 10
    np.testing.assert_allclose(found.angles, padded.angles if short else moving.angles)
    assert (found.start, found.cut) == pytest.approx((0.0, 0.0) if short else (0.02 * before, 0.02 * (before + after)))
    assert len(found.time) == len(found.pitch) == len(found.place) == len(found.angles)


def columns(**columns: np.ndarray) -> tuple[str, list[np.ndarray]]:
    return ",".join(["time_s", *columns]), [TIME, *columns.values()]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"shoulder_deg": 0.3 + TIME, "elbow_deg": 1.5 - TIME}, "name the column `shoulder_rad`"),
        ({"shoulder_rad": 90.0 * TIME, "elbow_rad": 1.5 - TIME}, "name the column `shoulder_deg`"),
        ({"shoulder_deg": 90.0 * TIME, "elbow_deg": 20.0 * TIME, "elbow_rad": TIME}, "more than one column"),
        ({"shoulder_deg": 90.0 * TIME, "Elbow_deg": 20.0 * TIME, "elbow_deg": TIME}, "more than one column"),
        ({"shoulder": TIME, "shoulder_flexion_deg": 90.0 * TIME, "elbow": TIME}, "shoulder, shoulder_flexion_deg"),
        ({"t": TIME, "shoulder_deg": 90.0 * TIME, "elbow_deg": 20.0 * TIME}, "more than one column with times"),
        (
            {"shoulder_deg": 160.0 * TIME, "elbow_deg": 20.0 * TIME, "shoulder_flexion_gravity_deg": 2.8 * TIME},
            "the trunk would lean by 157 deg",
        ),
    ],
)
def test_columns_that_are_in_another_unit_or_there_twice_are_refused(tmp_path: Path, given: dict, message: str):
    header, values = columns(**given)
    with pytest.raises(Error) as error:
        read(table(tmp_path, header, *values), JOINTS)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_still_joint_without_a_unit_is_in_degrees_if_the_others_are(tmp_path: Path):
    header, values = columns(shoulder=100.0 * TIME, elbow=3.0 + 0.0 * TIME)
    np.testing.assert_allclose(read(table(tmp_path, header, *values), JOINTS)[0].angles[:, 1], np.radians(3.0))


def test_what_a_file_does_not_say_is_known(tmp_path: Path):
    header, values = columns(shoulder_deg=100.0 * TIME, elbow_deg=30.0 * TIME, shoulder_up_m=TIME)
    assert read(table(tmp_path, header, *values), JOINTS)[0].absent == ("trunk_pitch", "shoulder_forward")
    header, values = columns(
        shoulder_deg=100.0 * TIME, elbow_deg=30.0 * TIME, trunk_pitch_deg=TIME, shoulder_up_m=TIME,
        shoulder_forward_m=TIME,
    )  # fmt: skip
    assert read(table(tmp_path, header, *values), JOINTS)[0].absent == ()
