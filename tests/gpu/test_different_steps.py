"""Instances that share a warp may be at different steps, as where episodes of learning end one by one."""

import msgspec
import numpy as np
import pytest
import warp as wp

from warpmuscle.formats import load
from warpmuscle.simulation.rollout import Rollout

FIRST, MORE = 3, 40  # steps; bodies are looked at every second one


@pytest.mark.parametrize(
    "device", [pytest.param("cuda:0", marks=pytest.mark.gpu), pytest.param("cpu", marks=pytest.mark.long)]
)
def test_bodies_touch_and_collide_alike_whatever_step_neighbours_are_at(device: str):
    if device != "cpu" and not wp.get_cuda_devices():
        pytest.skip("there is no GPU here")
    scene = load("walk56_person")
    assert scene.body_contact is not None
    scene = msgspec.structs.replace(scene, failure=msgspec.structs.replace(scene.failure, self_collision=0.02))
    later = np.array([False, True, True, False, True, False, False])
    for lanes in (8, 16) if device != "cpu" else (None,):
        rollout = Rollout(scene, len(later), device, lanes=lanes)
        rollout.step(FIRST)
        rollout.reset(mask=later)
        rollout.step(MORE)
        apart = rollout.state.coordinates.numpy()
        for mask, steps in ((later, MORE), (~later, FIRST + MORE)):
            rollout.reset()
            rollout.step(steps)
            np.testing.assert_array_equal(apart[mask], rollout.state.coordinates.numpy()[mask])
