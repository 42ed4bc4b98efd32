"""The timing tool: the same motion as without a clock, and times of all stages that the scene has."""

import msgspec
import numpy as np
import pytest
from stage_times import StageTimes

from muscle_arm import constant, leg
from warpmuscle.kernels.step import STAGES
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
STEPS = 50


def test_stages_are_timed_without_a_change_of_the_motion():
    scene = leg(duration=0.1)
    for muscle in scene.character.muscles.values():
        muscle.excitation = constant(0.3)
    times = StageTimes(Rollout(scene, 3, "cpu", threads=1), 0.0)
    found = times.split(STEPS, 2)
    timed = times.rollout.state.coordinates.numpy()
    times.run(STEPS, times.plain)
    np.testing.assert_array_equal(timed, times.rollout.state.coordinates.numpy())
    assert tuple(found) == ("all", *STAGES)
    stages = np.array([found[name] for name in STAGES])
    assert (stages > 0.0).all()
    np.testing.assert_allclose(stages.sum(), found["all"], rtol=1e-9)
    assert found["kinematics"] + found["muscles"] + found["acceleration"] > 0.3 * found["all"]


def test_a_stage_that_a_scene_does_not_have_takes_next_to_nothing():
    scene = msgspec.structs.replace(leg(duration=0.1), name="bones")
    scene.character.muscles = {}
    found = StageTimes(Rollout(scene, 3, "cpu", threads=1), 0.0).split(STEPS, 3)
    assert found["muscles"] < 0.3 * found["kinematics"]
