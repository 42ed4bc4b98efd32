"""Quantities of one's own are recorded, kept in files, and told to whoever reads them."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from importing import importable_from
from muscle_arm import constant, leg
from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.results.motion_layout import load_recordings, put_motions
from warpmuscle.scene import Scene
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

NAME = "recorded_by_others"
MODULE = '''"""What is recorded besides."""

import warp as wp

from warpmuscle.kernels.objective.accelerations import centre_acceleration
from warpmuscle.kernels.objective.declaration import Declaration
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.func
def _acceleration(instance: int, model: Model, state: State, work: Scratch) -> wp.vec3:
    return centre_acceleration(instance, model.body_count - 1, model, work)


@wp.func
def _steps(instance: int, model: Model, state: State, work: Scratch, memory: wp.array[float]) -> float:
    memory[0] = memory[0] + 1.0
    return memory[0]


@wp.func
def height(instance: int, model: Model, state: State, work: Scratch) -> float:
    return work.center[0][1]


@wp.func
def pair(instance: int, model: Model, state: State, work: Scratch) -> wp.vec2:
    return wp.vec2(0.0)


acceleration = Declaration(function=_acceleration, stage="accelerations", unit="m/s^2", description="of the last body")
steps = Declaration(function=_steps, memory=1)
'''
EVERY = 4  # steps between frames


@pytest.fixture(scope="module", autouse=True)
def importable(tmp_path_factory):
    place: Path = tmp_path_factory.mktemp("recorded")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield


def scene(*names: str) -> Scene:
    one = leg(duration=0.1)
    one.recorded = [f"{NAME}:{name}" for name in names]
    for index, muscle in enumerate(one.character.muscles.values()):
        muscle.excitation = constant(0.2 + 0.3 * index)
    return one


def test_quantities_are_recorded_with_names_and_units_and_come_back_from_files(tmp_path: Path):
    rollout = Rollout(scene("acceleration", "steps", "height"), 2, "cpu", record=[0, 1], record_rate=500.0, trust=True)
    rollout.run()
    motion = rollout.recording(1)
    axes = tuple(f"{NAME}:acceleration.{axis}" for axis in "xyz")
    assert motion.recorded_names == (*axes, f"{NAME}:steps", f"{NAME}:height")
    assert motion.recorded_units == ("m/s^2",) * 3 + ("1", "1")
    np.testing.assert_array_equal(motion.recorded[:, 3], EVERY * np.arange(motion.frames) + 1)
    np.testing.assert_allclose(motion.recorded[:, 4], motion.com[:, 1], rtol=1e-6)
    velocity = np.gradient(motion.body_position[:, -1], motion.time, axis=0, edge_order=2)
    wanted = np.gradient(velocity, motion.time, axis=0, edge_order=2)[4:-4]
    np.testing.assert_allclose(motion.recorded[4:-4, :3], wanted, atol=0.05 * np.abs(wanted).max())
    with h5py.File(tmp_path / "motion.h5", "w") as file:
        put_motions(file, [motion])
        again = load_recordings(file["replay"])[0]
    assert again.recorded_names == motion.recorded_names
    assert again.recorded_units == motion.recorded_units
    np.testing.assert_allclose(again.recorded, motion.recorded)
    assert toml.loads(toml.dumps(rollout.scene)) == rollout.scene


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("pair", r"recorded.0: .* must say that it returns float or wp.vec3, and says wp.vec2"),
        ("heigt", "has no function 'heigt'; did you mean 'height'"),
    ],
)
def test_what_cannot_be_recorded_is_said_in_one_line(name: str, message: str):
    with pytest.raises(Error, match=message) as caught:
        Rollout(scene(name), 1, "cpu", trust=True)
    assert "\n" not in str(caught.value)
