"""Bodies of other sizes: in slow motion what the smaller one does, and each in a batch as if it were alone."""

import math

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.sizes.batch_scene import batch_scene
from warpmuscle.scene.sizes.sized import height_of, sized
from warpmuscle.simulation.rollout import Rollout

LENGTH = 1.21  # so that time goes by 1.1


@pytest.fixture(scope="module")
def walk():
    return msgspec.structs.replace(load("fwalk"), time_step=0.001, duration=2.0, implicit_pd=True)


def steps(scene, count):
    rollout = Rollout(scene, 1, "cpu", threads=1)
    rollout.step(count)
    return rollout.state.coordinates.numpy()[0].astype(float)


def test_a_larger_body_walks_as_the_smaller_one_in_slow_motion(walk):
    """Dynamic similarity with a ground that is as much harder: after sqrt(l) of the time all angles are the same."""
    mass = LENGTH**3
    grown = sized(walk, LENGTH * height_of(walk))
    ground = walk.ground
    harder = msgspec.structs.replace(
        ground,
        stiffness=ground.stiffness * mass / LENGTH, damping=ground.damping * mass / math.sqrt(LENGTH),
        tangential_damping=ground.tangential_damping * mass / math.sqrt(LENGTH),
    )  # fmt: skip
    grown = msgspec.structs.replace(grown, ground=harder, time_step=walk.time_step * math.sqrt(LENGTH))
    for joint in grown.character.joints.values():  # whose stops are those of a body of this size, too
        joint.limit_stiffness *= mass * LENGTH
        joint.limit_damping *= mass * LENGTH**1.5
    own, other = steps(walk, 300), steps(grown, 300)
    unchanged = steps(
        msgspec.structs.replace(grown, controller=walk.controller, initial_state=grown.initial_state), 300
    )
    assert np.abs(other[7:] - own[7:]).max() < 0.02
    assert np.abs(unchanged[7:] - own[7:]).max() > 0.1
    np.testing.assert_allclose(other[2] / own[2], LENGTH, rtol=0.02)


def test_each_body_of_a_batch_walks_as_by_itself(walk):
    sizes = [(1.3, 28.0), (1.9, 110.0), (1.7, 60.0)]
    bodies = [sized(walk, *size) for size in sizes]
    batch = Rollout(walk, len(bodies), "cpu", threads=1)
    batch.change(batch_scene(bodies))
    batch.reset()
    batch.step(200)
    for k, body in enumerate(bodies):
        alone = Rollout(walk, 1, "cpu", threads=1)
        alone.change(batch_scene([body]))
        alone.reset()
        alone.step(200)
        np.testing.assert_array_equal(batch.state.coordinates.numpy()[k], alone.state.coordinates.numpy()[0])
    masses = sum(body.mass for body in batch.numeric.character.bodies.values())
    np.testing.assert_allclose(masses, [mass for _, mass in sizes])


def test_scenes_that_differ_in_more_than_numbers_do_not_go_together(walk):
    plain = substitute(walk, start_values(walk))
    alike = batch_scene([plain, plain])
    assert body_mass(alike.character) == body_mass(plain.character)
    with pytest.raises(SceneError, match="more than numbers"):
        batch_scene([walk, load("bwalk")])
    with pytest.raises(SceneError, match="more than numbers"):
        batch_scene([walk, msgspec.structs.replace(walk, duration=3.0)])
    with pytest.raises(SceneError, match="no scenes"):
        batch_scene([])
