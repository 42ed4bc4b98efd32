"""Failing conditions of a scene's own, and that of standing still."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from importing import importable_from
from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.scene import Actuation, Failure, Ground, InitialState, JointState, Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.simulation.rollout import Rollout

NAME = "their_conditions"
MODULE = """
import warp as wp
from warpmuscle.kernels.structs import ModelRef, StateRef, ScratchRef


@wp.func
def swings(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> bool:
    return instance == 1 and wp.abs(state.coordinates[instance, 7]) > 0.3


@wp.func
def is_third(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> bool:
    return instance == 2 and state.step[instance] >= 20


@wp.func
def counts(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return 1.0
"""


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    place = tmp_path_factory.mktemp("conditions")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield place


def swinging(*conditions: str, **limits: Any) -> Scene:
    """A forearm that swings from 0.5 rad through the middle."""
    start = InitialState((0.0, 1.0, 0.0), joints={"elbow": JointState((0.0, 0.0, 0.0, 1.0), (2.0, 0.0, 0.0))})
    failure = Failure(0.0, 0.0, custom=[f"{NAME}:{name}" for name in conditions], **limits)
    drives = {"elbow": Actuation("torque")}
    return arm(duration=0.3, initial_state=start, failure=failure, actuation=drives)


def test_conditions_end_instances_by_name_when_they_are_met() -> None:
    scene = swinging("swings", "is_third")
    rollout = Rollout(scene, 3, "cpu", record=[0], record_rate=1.0 / scene.time_step, trust=True)
    rollout.run()
    assert rollout.status().tolist() == [Status.COMPLETED, Status.FAILED, Status.FAILED]
    told = [f"the failing condition '{NAME}:{name}' is met" for name in ("swings", "is_third")]
    assert rollout.causes() == ("", *told)
    assert rollout.status_names()[1] == "failed"
    angle = np.abs(rollout.recording().joint_angle[:, 0])
    first = int(np.argmax(angle > 0.3))
    assert 0 < first < len(angle) - 1
    steps = rollout.state.step.numpy()
    assert abs(steps[1] - first) <= 1
    assert steps[2] == 20
    assert rollout.cost()[1] > scene.objective.failure_cost


def test_a_scene_without_them_moves_alike() -> None:
    with_them, without = (Rollout(swinging(*names), 1, "cpu", trust=True) for names in (("swings", "is_third"), ()))
    for rollout in (with_them, without):
        rollout.run()
    np.testing.assert_array_equal(with_them.state.speeds.numpy(), without.state.speeds.numpy())


def test_conditions_are_code_that_must_be_trusted_and_have_to_fit(folder: Path) -> None:
    toml.write(swinging("swings"), folder / "swings.toml")
    assert load(folder / "swings.toml").failure.custom == [f"{NAME}:swings"]
    (folder / "more_conditions.py").write_text(MODULE)
    scene = swinging()
    scene.failure.custom = ["more_conditions:swings"]
    with pytest.raises(SceneError, match="wants to run code of 'more_conditions:swings'"):
        Rollout(scene, 1, "cpu")
    for name, why in [("counts", "must say that it returns bool, and says float"), ("swing", "did you mean 'swings'")]:
        with pytest.raises(SceneError, match=f"failure.custom.{NAME}:{name}: .*{why}"):
            Rollout(swinging(name), 1, "cpu", trust=True)


def flying(**limits: Any) -> Scene:
    """Two bodies in free fall, whose way over the ground is their speed times the time."""
    scene = arm(duration=0.5, failure=Failure(0.0, 0.0, **limits), ground=Ground(stiffness=0.0), actuation={})
    scene.character.root_joint = "free"
    return scene


def test_those_who_make_no_progress_in_a_window_are_told() -> None:
    """Forward, sideways and along both, faster or slower than 0.5 m/s; and one that stops in the second window."""
    rollout = Rollout(flying(no_progress=0.5, no_progress_window=0.2), 6, "cpu")
    x, z = (rollout.speed_names.index(f"root.{axis}") for axis in "xz")
    speeds = np.zeros((6, len(rollout.speed_names)))
    speeds[:, x], speeds[:, z] = [0.0, 0.0, -0.6, 0.4, 0.33, 0.0], [0.0, 0.6, 0.0, 0.4, 0.33, 0.6]
    rollout.set_initial(speeds=speeds)
    rollout.run(0.2 + 0.001)
    stopped, running = Status.STOPPED, Status.RUNNING
    assert rollout.status().tolist() == [stopped, running, running, running, stopped, running]
    np.testing.assert_allclose(rollout.end_time()[[0, 4]], 0.2, atol=1e-9)
    now = rollout.state.speeds.numpy()
    now[5, z] = 0.0
    rollout.state.speeds.assign(now)
    rollout.run()
    assert rollout.status().tolist() == [stopped, *[Status.COMPLETED] * 3, stopped, stopped]
    assert rollout.end_time()[5] == pytest.approx(0.4)
    rollout.reset()
    rollout.run(0.1)
    assert (rollout.status() == running).all()


def test_without_a_limit_nothing_is_compiled_in() -> None:
    rollout = Rollout(flying(), 1, "cpu")
    assert not rollout.structure.objective.progress
    assert len(rollout.state.passed) == 0
    assert not free_parameters(flying(no_progress=0.5))
    with pytest.raises(SceneError, match=r"failure\.no_progress_window"):
        Rollout(flying(no_progress=0.5, no_progress_window=0.0), 1, "cpu")
