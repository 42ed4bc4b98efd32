"""Ground forces of a recorded motion, computed again, are those of the simulation, step by step."""

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Ground, Scene, Terrain
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Slope
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.ground_loads import _load, ground_loads, step_accelerations
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

SETTLED = 20  # steps after which nothing of the first one is left


@pytest.fixture(scope="module")
def walk() -> tuple[Recording, Scene]:
    """Every step of a short walk."""
    scene = msgspec.structs.replace(load("fwalk"), duration=0.4)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / float(scene.time_step))
    rollout.run()
    return rollout.recording(), scene


def test_forces_are_those_that_the_feet_felt(walk: tuple[Recording, Scene]):
    motion, scene = walk
    loads = {load.body: load for load in ground_loads(motion, scene)}
    for foot, felt in (("lFoot", motion.foot_force_left), ("rFoot", motion.foot_force_right)):
        own = [one.force for name, one in loads.items() if name.startswith(foot[0])]
        if not own:
            assert not np.any(felt)
            continue
        after = np.asarray(felt, float)[1:]  # a frame has the force of the step that led to it
        off = np.abs(sum(own)[:-1] - after)[SETTLED:]
        assert np.quantile(off, 0.99) < 2e-3 * np.abs(after).max()


def test_forces_and_moments_leave_nothing_to_the_root(walk: tuple[Recording, Scene]):
    """Inverse dynamics of the whole body: what moves the root is the ground alone."""
    motion, scene = walk
    accelerations = step_accelerations(motion, float(scene.time_step))
    assert accelerations is not None
    root = inverse_dynamics(scene, motion.coordinate, motion.speed, accelerations)[:, :6]
    center = np.asarray(motion.position_of(scene.character.root), float)
    given = np.zeros_like(root)
    for one in ground_loads(motion, scene):
        given[:, :3] += one.force
        given[:, 3:] += np.cross(one.point - center, one.force) + one.torque
    off = np.abs(given - root)[SETTLED:-1]
    assert off.max(axis=0) == pytest.approx(np.zeros(6), abs=0.005 * np.abs(root[SETTLED:]).max())


def test_light_and_pulling_forces_and_their_moments_are_whole():
    """As at the end of a contact, which gives way over the step that it ends in."""
    random = np.random.default_rng(5)
    force, moment, center = random.normal(size=(3, 40, 3))
    force[:20] *= 100.0
    found = _load("foot", force, moment, center, surface(Ground()))
    np.testing.assert_array_equal(found.force, force)
    about_center = np.cross(found.point - center, found.force) + found.torque
    np.testing.assert_allclose(about_center, moment, atol=1e-9)
    pressed = force[:, 1] > 1.0
    np.testing.assert_allclose(found.point[pressed, 1], 0.0, atol=1e-9)
    np.testing.assert_array_equal(found.point[~pressed], center[~pressed])


def test_loads_act_on_ground_that_rises_as_on_an_inclined_plane():
    random, tilt = np.random.default_rng(6), 0.2
    force, moment, center = random.normal(size=(3, 40, 3)) * [[[100.0]], [[5.0]], [[0.3]]]
    grounds = Ground(terrain=Terrain([Slope(tilt)])), Ground(normal=(0.0, np.cos(tilt), -np.sin(tilt)))
    found, expected = (_load("foot", force, moment, center, surface(ground)) for ground in grounds)
    np.testing.assert_allclose(found.point, expected.point, atol=1e-9)
    np.testing.assert_allclose(found.torque, expected.torque, atol=1e-9)


def test_accelerations_need_every_step(walk: tuple[Recording, Scene]):
    motion, scene = walk
    assert step_accelerations(motion.at(slice(None, None, 2)), float(scene.time_step)) is None
    assert ground_loads(motion.at(slice(None, None, 2)), scene)
