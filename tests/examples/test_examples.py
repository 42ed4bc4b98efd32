"""Sample files are what their names say: scenes run, EMG has the synergies it was made of; none is overwritten."""

from pathlib import Path

import numpy as np
import pytest

from importing import importable_from
from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.examples import EXAMPLES, write
from warpmuscle.examples.emg import WEIGHTS
from warpmuscle.formats import load, save
from warpmuscle.scene.trusted_code import trust
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.plan import read as read_sweep
from warpmuscle.synergy.preparation import Preparation, prepare
from warpmuscle.throw.recordings.motion_files import read as read_motions

FILES = Path(__file__).parents[2] / "warpmuscle" / "examples" / "files"


def test_every_shipped_file_belongs_to_an_example(tmp_path: Path):
    quick = [name for name in EXAMPLES if name not in ("gait", "lift", "model", "simbicon")]
    written = {path.name for name in quick for path in write(name, tmp_path)}
    assert {path.name for path in FILES.iterdir() if path.is_file()} - written == {
        "arm_scene.toml",
        "reach.toml",
        "track.toml",
    }


def test_a_file_that_exists_stays_unless_it_is_to_be_replaced(tmp_path: Path):
    (tmp_path / "knees.toml").write_text("mine")
    with pytest.raises(Error, match=r"knees\.toml exists already; --replace"):
        write("muscles", tmp_path)
    assert (tmp_path / "knees.toml").read_text() == "mine"
    assert not (tmp_path / "my_muscles.toml").exists()
    assert len(write("muscles", tmp_path, replace=True)) == 2


def test_an_unknown_name_is_answered_by_the_nearest_one():
    with pytest.raises(Error, match="no example called 'throw'; did you mean 'throws'"):
        write("throw")


OTHERWISE = {  # valued, which moves nobody: so others have compiled their steps
    "mine": {"objective.torque": 1.0, "objective.speed": 0.0, "objective.cost_of_transport": 0.0},
    "track": {"objective.speed": 1.0},
}


@pytest.mark.parametrize(("name", "file"), [("scene", "mine"), ("muscles", "knees"), ("gait", "track")])
def test_scenes_without_code_walk(name: str, file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    write(name)
    rollout = Rollout(load(f"{file}.toml", set=OTHERWISE.get(file)), 1, "cpu", record=[0])
    rollout.run()
    assert rollout.status()[0] == Status.COMPLETED
    assert rollout.recording().com[-1, 2] > 5.0  # m forward


@pytest.mark.usefixtures("unoptimized_test")
def test_each_joint_is_held_by_gains_of_its_own(tmp_path: Path):
    write("gains", tmp_path)
    scene = load(tmp_path / "steady.toml")
    trust(scene, tmp_path)
    with importable_from(tmp_path):
        rollout = Rollout(scene, 1, "cpu", record=[0])
        rollout.run()
    shoulder, elbow = rollout.state.coordinates.numpy()[0, 7:]
    at_elbow = 1.0 * 9.8 * 0.2 * np.sin(shoulder + elbow)  # weight times lever
    at_shoulder = at_elbow + (2.0 + 2.0 * 1.0) * 9.8 * 0.2 * np.sin(shoulder)
    assert 40.0 * (0.5 - elbow) == pytest.approx(at_elbow, abs=0.01)
    assert -30.0 * shoulder == pytest.approx(at_shoulder, abs=0.01)
    motion = rollout.recording()
    assert (motion.controller_value_names, motion.controller_value_units) == (("squared_error",), ("rad^2 s",))
    assert np.all(np.diff(motion.controller_value[:, 0]) > 0.0)


@pytest.mark.usefixtures("unoptimized_test")
def test_the_pendulum_is_held_where_its_controller_wants_it(tmp_path: Path):
    write("controller", tmp_path)
    scene = load(tmp_path / "hold.toml")
    trust(scene, tmp_path)
    with importable_from(tmp_path):
        rollout = Rollout(scene, 1, "cpu")
        rollout.run()
    assert rollout.state.coordinates.numpy()[0, 7] == pytest.approx(0.5, abs=0.01)


@pytest.mark.usefixtures("unoptimized_test")
def test_the_arm_of_the_opensim_model_reaches_forward(tmp_path: Path):
    write("model", tmp_path)
    save(load(tmp_path / "arm.osim"), tmp_path / "arm.toml")
    rollout = Rollout(load(tmp_path / "reach.toml"), 1, "cpu", record=[0])
    rollout.run()
    forearm = rollout.recording().body_position[:, -1]
    assert forearm[-1, 2] - forearm[0, 2] > 0.1  # m


def test_the_sweep_and_the_throws_can_be_read(tmp_path: Path):
    write("sweep", tmp_path)
    assert len(read_sweep(tmp_path / "speeds.toml").runs) == 6
    write("throws", tmp_path)
    motions = [read_motions(path, ("shoulder", "elbow", "wrist"))[0] for path in tmp_path.glob("throws/*.csv")]
    assert [motion.absent for motion in motions] == [()] * 4


def test_the_emg_holds_the_synergies_that_it_was_made_of(tmp_path: Path):
    write("emg", tmp_path)
    found = prepare([tmp_path / "emg.csv"], Preparation()).values
    strongest = found[:, WEIGHTS.max(axis=1) == 1.0]
    assert np.linalg.matrix_rank(strongest, tol=0.1 * np.linalg.norm(strongest, 2)) >= 3
