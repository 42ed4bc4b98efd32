"""The leg that stands bears its share of the weight at the knee."""

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.kernels.control.walking.body import Leg
from warpmuscle.kernels.control.walking.stance import lowered_knee
from warpmuscle.kernels.structs import Model, Scratch, Skeleton
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


@wp.kernel(enable_backward=False)
def lowered(p: places.Walking, model: Model, work: Scratch, memory: wp.array[float], found: wp.array[float]):
    its = work
    leg = Leg()
    leg.thigh = 0
    leg.shank = 1
    leg.foot = 2
    found[0] = lowered_knee(0, leg, p, model, its, memory)


@pytest.mark.parametrize("drop", [0.0, 0.1])
def test_a_knee_that_stands_bends_until_the_other_leg_reaches_its_foothold(drop: float):
    """The hip, gone on until the foot lands, sinks to a straight leg's 98 % above a foothold that lies lower."""
    gravity, leg, sole, speed, phase, step_time = 9.8, 0.9, 0.08, 0.5, 0.4, 1.6
    thigh, shank = 0.42, 0.40
    hip, ankle = np.array([0.3, 1.2, 2.0]), np.array([0.25, 0.39, 1.95])
    velocity = np.array([0.1, 0.3, 0.6])
    foothold = np.array([0.1, 0.39 - drop, 2.55])
    memory = np.zeros(places.STATE, np.float32)
    for place, value in ((places.PHASE, phase), (places.SPEED, speed), (places.LEG, leg), (places.SOLE, sole)):
        memory[int(place)] = value
    memory[int(places.FOOTHOLD) : int(places.FOOTHOLD) + 3] = foothold
    p = places.Walking()
    p.step_time, p.quickening, p.stance_knee = step_time, 0.0, 0.0
    zero = np.zeros((1, 3), np.float32)
    anchors, axes = np.zeros((1, 3, 3), np.float32), np.tile(np.float32([1.0, 0.0, 0.0]), (1, 3, 1))
    anchors[0, 1, 1], anchors[0, 2, 1] = -thigh, -shank
    model = filled(Model, gravity=np.float32([[gravity]]))
    model.skeleton = filled(
        Skeleton, row={"anchor": anchors, "axis_a": axes}, limits={"sine": np.tile(np.float32([0.5, 0, 0]), (1, 3, 1))}
    )
    work = filled(Scratch, position=np.float32([hip, zero[0], ankle]), velocity=np.float32([velocity, *zero, *zero]))
    found = wp.zeros(1, dtype=float, device="cpu")
    wp.launch(lowered, 1, [p, model, work, wp.array(memory, device="cpu")], [found], device="cpu")
    remaining = (0.88 - phase) * step_time * np.sqrt(leg / gravity)
    over = hip + velocity * [1.0, 0.0, 1.0] * remaining - foothold
    high = np.sqrt((0.98 * (leg - sole)) ** 2 - over[0] ** 2 - over[2] ** 2)
    sinks = max(over[1] - high, 0.0)
    assert sinks > 0.03
    distance = np.linalg.norm(ankle - hip + [0.0, sinks, 0.0])
    wanted = np.pi - np.arccos((thigh**2 + shank**2 - distance**2) / (2.0 * thigh * shank))  # cosine rule
    assert 0.3 < wanted < 2.0
    assert found.numpy()[0] == pytest.approx(wanted, abs=1e-4)
