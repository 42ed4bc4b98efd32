"""The leg that stands bears its share of the weight at the knee."""

import numpy as np

from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

SUPPORT = (0.6, 1.4)


def torques(rollout: Rollout) -> np.ndarray:
    """Of joints on the bodies that they carry, world, N m, (instances, bodies, 3)."""
    memory = rollout._extensions.struct.first.memory.numpy()[:, 0, places.STATE :].astype(float)
    count = len(rollout.names.bodies)
    return memory[:, : places.OF_BODY * count].reshape(len(memory), count, places.OF_BODY)[:, :, :3]


def test_both_ankles_of_who_stands_do_the_same():
    """Of a symmetric body: the same about x, the opposite about y and z."""
    rollout = Rollout(load("steer"), 1, "cpu")
    rollout.set_commands({"speed": 0.0})
    rollout.run(0.1)
    left, right = (torques(rollout)[0, rollout.names.bodies.index(foot)] for foot in rollout.numeric.character.feet)
    assert np.abs(left).max() > 2.0
    np.testing.assert_allclose(left, right * [1.0, -1.0, -1.0], atol=0.2)


def test_knees_bear_what_more_of_the_weight_they_are_to_support():
    """-(hip - knee) x F on each shank, F along its leg; both legs of one that stands share the weight."""
    scene = load("steer")
    scene.controller.parameters["weight_support"] = Free(1.0, 0.5, 1.5)
    rollout = Rollout(scene, 2, "cpu")
    rollout.set_commands({"speed": 0.0})
    rollout.set_parameters(np.array([[value] for value in SUPPORT]))
    rollout.reset()
    rollout.run(scene.time_step)
    names = rollout.names
    torque = torques(rollout)
    poses = Stages(load("steer"), 1, "cpu").forward_kinematics()
    middles, turns = (poses[name][0].astype(float) for name in ("position", "orientation"))
    place = middles - rotate(turns, rollout.model.skeleton.row.numpy()["com"][0].astype(float))  # of joints
    weight = scene.gravity * sum(body.mass for body in rollout.numeric.character.bodies.values())
    shares = []
    for side in rollout.numeric.character.feet:
        foot = names.bodies.index(side)
        shank = names.parents[foot]
        thigh = names.parents[shank]
        along = (place[thigh] - place[foot]) / np.linalg.norm(place[thigh] - place[foot])
        all_of_it = -np.cross(place[thigh] - place[shank], (SUPPORT[1] - SUPPORT[0]) * weight * along)
        more = torque[1, shank] - torque[0, shank]
        shares.append(more @ all_of_it / (all_of_it @ all_of_it))
        assert np.linalg.norm(all_of_it) > 5.0
        np.testing.assert_allclose(more, shares[-1] * all_of_it, atol=0.05)
    np.testing.assert_allclose(sum(shares), 1.0, atol=0.01)
    assert min(shares) > 0.2
