"""Dynamics with prescribed coordinates: what the others must do, by inverse dynamics in float64."""

import numpy as np
import pytest
import warp as wp
from joint_chains import accelerate_of, accelerated, chain
from probes import filled

from warpmuscle.kernels.body.hybrid import hybrid_integrate_stage
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.structs import (
    FIXED,
    HINGE,
    ROOT_FIXED,
    ROOT_PRESCRIBED,
    SECOND_HINGE,
    UNIVERSAL,
    Model,
    PrescribedMotion,
    Scratch,
    Skeleton,
    State,
)
from warpmuscle.model.prescribed_motion import speed_numbers
from warpmuscle.scene import Motion
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

CHAINS = {
    "first axis of a universal joint": (("universal", ["kinematic", "none"]), ("hinge", "kinematic"), ("ball", "none")),
    "second axis of a universal joint": (("ball", "none"), ("universal", ["none", "kinematic"]), ("hinge", "none")),
    "whole joints between others": (("hinge", "none"), ("universal", "kinematic"), ("universal", "none")),
}


@pytest.mark.parametrize("drives", CHAINS.values(), ids=CHAINS)
def test_the_others_accelerate_so_that_no_force_acts_along_them(drives: tuple):
    scene = chain(*drives)
    found = accelerated(scene)
    needed = inverse_dynamics(scene, found.coordinates, found.speeds, found.accelerations)
    scale = np.abs(needed).max()
    assert scale > 0.5  # along the prescribed ones
    np.testing.assert_allclose(needed[:, found.others], 0.0, atol=3e-4 * scale)
    assert np.abs(found.accelerations[:, found.others]).max() > 1.0


@pytest.mark.parametrize("root", ["free", "planar"])
def test_a_prescribed_root_accelerates_as_given(root: str):
    """A planar one as far as it can move: up, forwards and about its axis across."""
    scene = chain(("hinge", "none"), root=root)
    times, still = [0.0, 0.2, 0.5], [(0.0, 0.0, 0.0)] * 3
    scene.motion["root"] = Motion(times, position=[(0.0, 1.0, 0.0)] * 3, rotation=still)
    rollout = Rollout(scene, 3, "cpu")
    numbers = speed_numbers(rollout.structure.kinematic)
    assert len(numbers) == {"free": 6, "planar": 3}[root]
    given = np.zeros((3, rollout.names.speeds))
    given[:, numbers] = 4.0 * np.random.default_rng(3).normal(size=(3, len(numbers)))
    rollout.state.accelerations.assign(given.astype(np.float32))
    rollout.model.time_step = 0.0
    room = wp.zeros((3, work_floats(capacity_of(2), True)), dtype=float, device="cpu")
    rate = wp.zeros(given.shape, dtype=float, device="cpu")
    wp.launch(accelerate_of(True), 3, [rollout.model, rollout.state, room, rate], device="cpu")
    np.testing.assert_allclose(rate.numpy()[:, numbers], given[:, numbers], rtol=1e-5)


@wp.kernel(enable_backward=False)
def integrate(model: Model, state: State, work: Scratch):
    its = work
    hybrid_integrate_stage(0, 0, 1, model, state, its)


@pytest.mark.parametrize("step", [0, 3])
def test_what_is_left_of_a_universal_joint_moves_by_leapfrog(step: int):
    """The middle of the step: v - h/2 a_before + h a (h/2 in the first); then q + h v_middle, v_middle + h/2 a."""
    h, rng = 0.01, np.random.default_rng(1)
    kinds, left = [ROOT_FIXED, UNIVERSAL, UNIVERSAL, HINGE, HINGE], [ROOT_PRESCRIBED, SECOND_HINGE, HINGE, HINGE, FIXED]
    plan = {
        "joint_type": kinds, "parent": [-1, 0, 1, 2, 3], "coordinate_start": [0, 7, 9, 11, 12],
        "speed_start": [0, 0, 2, 4, 5], "speed_end": [0, 2, 4, 5, 6],
    }  # fmt: skip
    motion = filled(
        PrescribedMotion,
        start=np.zeros(1),
        remaining=left,
        curve=wp.zeros((1, 1, 1), PrescribedMotion.vars["curve"].type.dtype),
    )
    model = filled(
        Model, body_count=5, time_step=h, skeleton=filled(Skeleton, plan=plan), motion=motion,
        failure={"max_speed": [[1.0e3]]},
    )  # fmt: skip
    q, v, before = (np.float32(rng.normal(size=(1, n))) for n in (13, 6, 6))
    state = filled(State, coordinates=q, speeds=v, accelerations=before, step=np.int32([step]))
    new = rng.normal(size=(5, 3))
    work = filled(Scratch, factor_c=np.float32(new), flags=np.zeros(2, np.int32))
    wp.launch(integrate, 1, [model, state, work], device="cpu")
    moved = {1: (8, 1), 2: (9, 2), 3: (11, 4)}  # bodies, and coordinate and speed of what is left
    expected_q, expected_v = q[0].astype(float), v[0].astype(float)
    for body, (coordinate, speed) in moved.items():
        middle = v[0, speed] - 0.5 * h * before[0, speed] + (h if step else 0.5 * h) * new[body, 0]
        expected_q[coordinate] += h * middle
        expected_v[speed] = middle + 0.5 * h * new[body, 0]
    np.testing.assert_allclose(state.coordinates.numpy()[0], expected_q, atol=1e-6)
    np.testing.assert_allclose(state.speeds.numpy()[0], expected_v, atol=1e-6)
    assert work.flags.numpy().tolist() == [0, 0]
