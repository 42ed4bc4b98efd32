"""The plan of a walk over time: steps last as long as their formula says, by gravity and the length of a leg."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.simulation.rollout import Rollout

STEP_TIME, QUICKENING = 1.83, 0.845  # of the scene


@pytest.mark.parametrize("speed", [0.0, 0.9])
def test_a_phase_goes_on_by_the_time_of_a_step(speed: float):
    """step_time sqrt(L/g) / (1 + quickening V/sqrt(g L)), V the speed that is followed; of who stands, none."""
    scene = load("steer")
    scene.controller.parameters |= {"step_time": STEP_TIME, "quickening": QUICKENING}
    rollout = Rollout(scene, 1, "cpu")
    rollout.set_commands({"speed": speed})
    rollout.run(0.6)
    memories = []
    for _ in range(2):
        memories.append(rollout._extensions.struct.first.memory.numpy()[0, 0].astype(float))
        rollout.run(scene.time_step)
    before, after = memories
    followed, leg = after[int(places.SPEED)], after[int(places.LEG)]
    duration = STEP_TIME * np.sqrt(leg / scene.gravity) / (1.0 + QUICKENING * followed / np.sqrt(scene.gravity * leg))
    gained = after[int(places.PHASE)] - before[int(places.PHASE)]
    if speed == 0.0:
        assert after[int(places.PHASE)] == followed == 0.0
        return
    assert 0.02 < followed < speed
    assert after[int(places.HASTE)] == 1.0
    assert gained == pytest.approx(scene.time_step / duration, rel=1e-3)
