"""Pairs of bodies that touch push each other once, however many lanes share the pairs."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.contact.touching import Touch, push_each_other_of
from warpmuscle.kernels.force.extensions import touch_extension
from warpmuscle.kernels.structs import Model, ModelRef, Scratch, ScratchRef, Skeleton

PAIRS = [(0, 1), (1, 2), (0, 2)]
FORCE = [3.0, -2.0, 0.0]  # N, along x on the second body of each; the last ones do not touch
ARM = 0.5  # m, along y from both centres of mass to where they touch


@wp.struct
class Push:
    along: float


@wp.func
def touch_between(instance: int, first: int, second: int, model: ModelRef, work: ScratchRef, p: Push) -> Touch:
    touch = Touch()
    touch.force = wp.vec3(p.along, 0.0, 0.0)
    touch.first_arm = wp.vec3(0.0, wp.static(ARM), 0.0)
    touch.second_arm = wp.vec3(0.0, wp.static(ARM), 0.0)
    return touch


Pairs = touch_extension(Push)
push_each_other = push_each_other_of(touch_between, Pairs)


@wp.kernel(enable_backward=False)
def take_turns(lanes: int, model: Model, work: Scratch, extension: Pairs):
    its = work
    own = extension
    for lane in range(lanes):
        push_each_other(0, lane, lanes, 0, model, its, own)


@pytest.mark.parametrize("lanes", [1, 2, 3, 5])
def test_every_pair_pushes_both_bodies_once(lanes: int):
    model = filled(Model, touch_interval=1, skeleton=filled(Skeleton, row={"com": np.zeros((1, 3, 3))}))
    work = filled(
        Scratch, near=np.zeros(1), rotation=np.tile(np.eye(3, dtype=np.float32), (3, 1, 1)),
        bias_force=np.zeros((3, 3), np.float32), bias_moment=np.zeros((3, 3), np.float32),
    )  # fmt: skip
    first, second = np.int32(PAIRS).T
    extension = filled(
        Pairs, parameters={"along": np.array([FORCE])}, memory=np.zeros((1, 3, 1), np.float32), first=first,
        second=second,
    )  # fmt: skip
    wp.launch(take_turns, 1, [lanes, model, work, extension], device="cpu")
    expected = np.zeros((3, 3))
    for (one, other), along in zip(PAIRS, FORCE, strict=True):
        expected[one, 0] += along  # biases are forces with the other sign
        expected[other, 0] -= along
    np.testing.assert_allclose(work.bias_force.numpy(), expected)
    np.testing.assert_allclose(work.bias_moment.numpy(), np.cross([0.0, ARM, 0.0], expected))
