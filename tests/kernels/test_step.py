"""The whole step: what its stages are given, and in which order, told by what becomes of a pendulum."""

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

from importing import importable_from
from muscle_arm import ABOUT_JOINT, MASS, REACH, arm
from warpmuscle.core.status import Status
from warpmuscle.kernels import step
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Actuation, Failure, InitialState, JointState, Scene
from warpmuscle.simulation.rollout import Rollout

NAME = "conditions_of_a_step"
MODULE = """
import warp as wp
from warpmuscle.kernels.structs import ModelRef, StateRef, ScratchRef


@wp.func
def beyond(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> bool:
    return instance == 1 and state.coordinates[instance, 7] > 0.02
"""
STEPS, G = 40, 9.8


@pytest.fixture(scope="module")
def swung(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rollout]:
    """Pendulums let go at 2 rad/s, the second of which must not go beyond 0.02 rad; the last one is too fast."""
    place: Path = tmp_path_factory.mktemp("conditions")
    (place / f"{NAME}.py").write_text(MODULE)
    with importable_from(place):
        yield _run(_pendulum())


def _pendulum() -> Scene:
    start = InitialState((0.0, 1.0, 0.0), joints={"elbow": JointState((0.0, 0.0, 0.0, 1.0), (2.0, 0.0, 0.0))})
    failure = Failure(0.0, 0.0, custom=[f"{NAME}:beyond"], max_speed=2.3)
    scene = arm(duration=0.1, initial_state=start, failure=failure, actuation={"elbow": Actuation("torque")})
    scene.character.muscles.clear()
    return scene


def _run(scene: Scene) -> Rollout:
    rollout = Rollout(scene, 4, "cpu", trust=True)
    rollout.set_initial(speeds=np.array([[2.0], [2.0], [2.0], [2.4]]))
    rollout.step(STEPS)
    return rollout


def test_a_condition_of_a_scenes_own_ends_the_instance_that_meets_it_as_soon_as_it_does(swung: Rollout):
    assert swung.status().tolist()[:3] == [Status.RUNNING, Status.FAILED, Status.RUNNING]
    steps, h = swung.state.step.numpy(), swung.scene.time_step
    assert steps[[0, 2]].tolist() == [STEPS, STEPS]
    assert abs(steps[1] - 0.02 / (2.0 * h)) <= 1
    assert swung.causes() == ("", f"the failing condition '{NAME}:beyond' is met", "", "")


def test_what_goes_beyond_the_largest_speed_has_diverged_though_it_meets_no_condition(swung: Rollout):
    assert swung.status()[3] == Status.DIVERGED
    assert swung.state.step.numpy()[3] <= 1


def test_a_pendulum_swings_as_its_equation_says(swung: Rollout):
    """I q'' = -m g l sin q, in steps of a hundredth."""
    h, q, v = swung.scene.time_step, 0.0, 2.0
    for _ in range(100 * STEPS):
        v -= MASS * G * REACH * np.sin(q) / ABOUT_JOINT * h / 100.0
        q += v * h / 100.0
    state = swung.state
    np.testing.assert_allclose(state.coordinates.numpy()[[0, 2], 7], q, atol=2e-5)
    np.testing.assert_allclose(state.speeds.numpy()[[0, 2], 0], v, atol=2e-4)


def test_blocks_are_made_for_multiprocessors_as_their_maker_says():
    """CUDA C++ Programming Guide, technical specifications by compute capability, 9.0."""
    assert (step.REGISTERS, step.WARP) == (65536, 32)
    assert (step.SHARED_MEMORY, step.SHARED_BY_SYSTEM) == (233472, 1024)
    assert step.MAX_REGISTERS * 4 * 3 * step.WARP <= step.REGISTERS < (step.MAX_REGISTERS + 8) * 4 * 3 * step.WARP


ABSENT = {  # modules of kernels that a pendulum on springs of the ground needs nothing of
    "constraint.constraints", "body.hybrid", "body.resistance", "contact.belts", "contact.beneath",
    "contact.gait_cycle", "contact.soft_constraint", "contact.terrain", "contact.touching", "contact.walls",
    "force.forces", "water.stage",
}  # fmt: skip


def named_by(adjoint: Any, found: dict[Any, str]) -> dict[Any, str]:
    """The modules of all functions that Warp reads for one, and for what these call."""
    _, _, functions = adjoint.get_references()
    statics = [value for value in adjoint.resolved_static_expressions.values() if isinstance(value, wp.Function)]
    for function in [*functions, *statics]:
        if not function.is_builtin() and function.adj not in found:
            found[function.adj] = function.func.__module__.removeprefix("warpmuscle.kernels.")
            named_by(function.adj, found)
    return found


def test_a_step_has_warp_read_nothing_that_its_kind_of_scene_does_not_have():
    read = set(named_by(step.step_kernel(4, 1, 1).adj, {}).values())
    assert {"body.dynamics", "contact.contact", "step_parts"} <= read
    assert not ABSENT & read


@pytest.mark.parametrize(("floats", "blocks"), [(11_200, 5), (11_300, 4)])
def test_a_block_takes_its_numbers_what_the_system_takes_and_a_flag_for_each_thread(floats: int, blocks: int):
    """Of 228 KiB: 4 bytes a number, 1 KiB and 4 bytes a thread, with 128 threads."""
    assert blocks == 228 * 1024 // (4 * floats + 1024 + 4 * 128)
    assert step.blocks_of(128, floats) == blocks


def test_the_model_is_small_enough_for_a_compiler_to_look_into():
    """Of a larger one, each thread of a GPU gets a copy in memory of its own: its reads are slow, and its code long."""
    assert ctypes.sizeof(Model.ctype) <= 8192
