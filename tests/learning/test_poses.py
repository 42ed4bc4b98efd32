"""Episodes that start with other angles: joints shaken, drawn from ranges, or as a file has them."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from muscle_arm import arm, leg
from small_result import no_parameters
from warpmuscle import Rollout
from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.learning import EpisodeBatch, Task, Variation
from warpmuscle.results.records import Result
from warpmuscle.results.result import write
from warpmuscle.scene import Scene

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

COUNT, KNEE = 400, 4 + 7  # instances, and the knee among coordinates of a fixed root, a ball joint and a hinge


def batch_of(count: int = COUNT, scene: Scene | None = None, **variation: object) -> EpisodeBatch:
    task = Task(episode_time=0.01, variation=Variation(velocity_noise=0.0, **variation))
    return EpisodeBatch(scene or leg(), count, "cpu", task, threads=1)


def coordinates(batch: EpisodeBatch) -> np.ndarray:
    return batch.rollout.state.coordinates.numpy().astype(np.float64)


def test_joints_are_off_by_the_deviation_that_is_asked_for_about_every_axis():
    still, shaken = batch_of(1), batch_of(joint_noise=0.1, poses=2000)
    start, found = coordinates(still)[0], coordinates(shaken)
    np.testing.assert_array_equal(found[:, :7], np.tile(start[:7], (COUNT, 1)))  # the root stays
    knee = found[:, KNEE] - start[KNEE]
    assert knee.std() == pytest.approx(0.1, rel=0.12)
    assert abs(knee.mean()) < 0.02
    hip = (Rotation.from_quat(start[7:11]).inv() * Rotation.from_quat(found[:, 7:11])).as_rotvec()
    np.testing.assert_allclose(hip.std(axis=0), 0.1, rtol=0.12)
    np.testing.assert_allclose(np.linalg.norm(found[:, 7:11], axis=1), 1.0, atol=1e-6)
    shaken.step()
    assert (shaken.episodes.number.numpy() == 2).all()
    assert not np.array_equal(coordinates(shaken), found)  # another one for another episode


def test_a_range_is_drawn_from_evenly_and_the_same_in_every_batch():
    many, few = batch_of(pose={"knee": (0.2, 1.2)}, poses=300), batch_of(3, pose={"knee": (0.2, 1.2)}, poses=300)
    knee = coordinates(many)[:, KNEE]
    assert 0.2 <= knee.min() < 0.25
    assert 1.15 < knee.max() <= 1.2
    assert knee.std() == pytest.approx(1.0 / np.sqrt(12.0), rel=0.1)
    np.testing.assert_array_equal(knee[:3], coordinates(few)[:, KNEE])
    np.testing.assert_array_equal(many.episodes.start_row.numpy()[:3], few.episodes.start_row.numpy())


def test_muscles_move_from_there_as_those_of_a_body_that_always_stood_so():
    batch = batch_of(2, pose={"knee": (0.2, 1.2)}, poses=5)
    start = coordinates(batch)
    alone = Rollout(leg(), 2, "cpu", threads=1)
    alone.set_initial(start)
    batch.actions.requested.fill_(0.5)
    batch.step(restart=False)
    alone.step(batch.decision_steps, excitations=np.full((2, 3), 0.3))  # 0.1 + 0.4 * 0.5
    np.testing.assert_allclose(coordinates(batch), alone.state.coordinates.numpy(), atol=1e-6)
    own, other = batch.rollout.state.muscles, alone.state.muscles
    np.testing.assert_allclose(own.activation.numpy(), other.activation.numpy(), atol=1e-6)
    assert np.ptp(coordinates(batch)[:, KNEE]) > 0.01


def test_states_of_a_file_are_starts_with_their_speeds_and_activation(tmp_path: Path):
    path, random = tmp_path / "states.npz", np.random.default_rng(1)
    states = np.tile(coordinates(batch_of(1))[0], (4, 1))
    states[:, KNEE] = [0.1, 0.4, 0.7, 1.0]
    speeds, activation = random.normal(size=(4, 4)), random.uniform(0.1, 0.9, (4, 3))
    np.savez(path, coordinates=states, speeds=speeds, activation=activation)
    batch = batch_of(40, start_file=str(path))
    row, state = batch.episodes.start_row.numpy(), batch.rollout.state
    assert set(row) == {0, 1, 2, 3}
    np.testing.assert_allclose(coordinates(batch), states[row], atol=1e-6)
    np.testing.assert_allclose(state.speeds.numpy(), speeds[row], atol=1e-6)
    np.testing.assert_allclose(state.muscles.activation.numpy(), activation[row], atol=1e-6)
    shaken = batch_of(40, start_file=str(path), joint_noise=0.01, poses=50)
    off = np.abs(coordinates(shaken)[:, KNEE, None] - states[:, KNEE]).min(axis=1)
    assert 0.0 < off.max() < 0.05


def test_frames_of_a_motion_in_a_result_file_are_starts(tmp_path: Path):
    path = tmp_path / "moved.h5"
    rollout = Rollout(leg(duration=0.05), 1, "cpu", record=[0], record_rate=100.0, threads=1)
    rollout.run()
    motion = rollout.recording()
    write(path, Result("", "cpu", "", 0, no_parameters(), replays=(motion,)))
    batch = batch_of(40, start_file=str(path))
    row = batch.episodes.start_row.numpy()
    assert len(set(row)) == len(motion.time)
    np.testing.assert_allclose(coordinates(batch), motion.coordinate[row], atol=1e-6)
    np.testing.assert_allclose(batch.rollout.state.muscles.activation.numpy(), motion.muscle_activation[row], atol=1e-6)
    with pytest.raises(RolloutError, match="holds the motion of another character than that of arm"):
        batch_of(1, arm(), start_file=str(path))


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"speeds": np.zeros((2, 4))}, "holds no array `coordinates`"),
        ({"coordinates": np.zeros((2, 5))}, r"coordinates have shape \(2, 5\); leg takes \(2, 12\)"),
        ({"coordinates": np.zeros((2, 12))}, r"is not a quaternion of length 1"),
        ({"coordinates": np.full((2, 12), np.nan)}, "a number of the coordinates is not finite"),
        ({"coordinates": np.zeros((0, 12))}, "holds 0 states, and should hold 1 to 65536"),
        (None, "states.npz: there is no such file|states.npz: .*[Nn]o such"),
    ],
)
def test_files_of_other_states_are_refused_in_one_line(arrays: dict | None, message: str, tmp_path: Path):
    path = tmp_path / "states.npz"
    if arrays is not None:
        np.savez(path, **arrays)
    with pytest.raises(RolloutError, match=message):
        batch_of(1, start_file=str(path))


@pytest.mark.parametrize(
    ("variation", "message"),
    [
        ({"pose": {"kne": (0.0, 1.0)}}, "no coordinate of a joint is called 'kne'; did you mean 'knee'"),
        ({"pose": {"hip": (0.0, 1.0)}}, "is a ball joint, which has no single angle"),
        ({"pose": {"knee": (1.0, 0.0)}}, "1 is greater than 0"),
        ({"pose": {"knee": (0.0, np.inf)}}, "finite"),
        ({"joint_noise": -0.1}, "joint_noise"),
        ({"poses": 0}, "must be 1 to 65536"),
        ({"start_file": "a.npz", "start_states": 3}, "give either a file of states or start_states"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(variation: dict, message: str):
    with pytest.raises(SceneError, match=message):
        batch_of(1, **variation)


def test_a_scene_says_it_in_its_learning_section():
    scene = leg()
    scene.learning = msgspec.convert({"variation": {"joint_noise": 0.1, "pose": {"knee": [0.2, 0.4]}}}, Task)
    found = coordinates(EpisodeBatch(scene, 30, "cpu", threads=1))[:, KNEE]
    assert found.std() > 0.05
