"""Forces on bodies and efforts on joints: each acts on its own body, for its own instance, once an entry."""

import numpy as np
import warp as wp
from probes import filled, matrix, units, vectors

from warpmuscle.kernels.force.extensions import extension_list
from warpmuscle.kernels.force.forces import ForceKind, Wrench, body_forces_stage_of, joint_forces_stage_of
from warpmuscle.kernels.structs import (
    FIXED,
    HINGE,
    ROOT_FREE,
    Model,
    ModelRef,
    Scratch,
    ScratchRef,
    Skeleton,
    State,
    StateRef,
)


@wp.struct
class Pull:
    """Parameters of an effort."""

    size: float  # N m


@wp.func
def blow(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> Wrench:
    w = Wrench()
    w.force = wp.vec3(float(instance + 1), 10.0 * float(body), 3.0)
    w.moment = wp.vec3(0.5, 0.0, float(instance))
    return w


@wp.func
def pull(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef, p: Pull) -> wp.vec3:
    return wp.vec3(p.size, 0.0, 0.0)


FORCES = (ForceKind(wrench=blow), ForceKind(effort=pull, parameters=Pull))
Extensions = extension_list(tuple(force.extension for force in FORCES))
push_bodies, turn_joints = body_forces_stage_of(FORCES), joint_forces_stage_of(FORCES)
COM, AXES = vectors(3, 1, 0.1), units(3, 2)


@wp.kernel(enable_backward=False)
def act(instance: int, model: Model, state: State, work: Scratch, extensions: Extensions):
    its, own = work, extensions
    push_bodies(instance, 0, 1, model, state, its, own)
    turn_joints(instance, 0, 1, model, state, its, own)


def acted(instance: int, sizes: list[float]) -> tuple[Scratch, np.ndarray, list[int]]:
    """After forces on the root once and on the last body twice, and efforts on the hinge of body 1; frames; causes."""
    frames = matrix(units(3, 3, 4))
    plan = {"joint_type": [ROOT_FREE, HINGE, FIXED], "parent": [-1, 0, 1]}
    row = {"com": COM[None], "axis_a": AXES[None]}
    model = filled(Model, body_count=3, skeleton=filled(Skeleton, plan=plan, row=row))
    state, flags = filled(State, cause=np.zeros(3, np.int32)), np.zeros(2, np.int32)
    none = np.zeros((3, 3), np.float32)
    work = filled(
        Scratch, rotation=np.float32(frames), bias_force=none, bias_moment=none.copy(), torque=none + 1.0, flags=flags
    )  # fmt: skip
    extensions = Extensions()
    extensions.first.start = wp.array([0, 1, 1, 3], dtype=int, device="cpu")
    extensions.rest.first.start = wp.array([0, 0, len(sizes), len(sizes)], dtype=int, device="cpu")
    extensions.rest.first.parameters = filled(FORCES[1].extension, parameters={"size": [sizes]}).parameters
    wp.launch(act, 1, [instance, model, state, work, extensions], device="cpu")
    return work, frames, state.cause.numpy().tolist()


def test_forces_act_at_the_centres_of_mass_of_their_bodies_as_often_as_they_are_named():
    for instance in (0, 2):
        work, frames, cause = acted(instance, [4.0])
        for body, times in ((0, 1.0), (1, 0.0), (2, 2.0)):
            force = times * np.array([instance + 1.0, 10.0 * body, 3.0])
            moment = times * np.array([0.5, 0.0, instance]) + np.cross(frames[body] @ COM[body], force)
            np.testing.assert_allclose(work.bias_force.numpy()[body], -force, atol=1e-5)
            np.testing.assert_allclose(work.bias_moment.numpy()[body], -moment, atol=1e-5)
        assert cause == [0, 0, 0]


def test_efforts_turn_the_child_about_the_axis_of_its_joint_and_the_parent_back():
    work, frames, _ = acted(1, [4.0, -1.5])
    torque = work.torque.numpy()
    np.testing.assert_allclose(torque[1], 1.0 - 2.5 * frames[1] @ AXES[1], atol=1e-5)
    np.testing.assert_array_equal(torque[[0, 2]], 1.0)


def test_an_effort_that_is_no_number_is_named_by_its_entry():
    """Kind 1 of the forces, entry 1: 2 + 8 kind + 2048 entry, for the instance alone."""
    _, _, cause = acted(1, [4.0, np.nan])
    assert cause == [0, 2 + 8 * 1 + 2048 * 1, 0]
