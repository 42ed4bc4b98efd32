"""Torques of a walk: where the foot that swings is to be, and hips that hold the pelvis by what their feet bear."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled

from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.kernels.control.walking import swing
from warpmuscle.kernels.control.walking.torques import ankle_wanted
from warpmuscle.kernels.structs import Model
from warpmuscle.simulation.rollout import Rollout

LENGTH, FIRST, HIGH = 0.9, 0.3, 0.12  # m of a leg; phase at which a foot goes forwards to a stair; leg's lengths
LIFTED = np.array([0.1, 0.08, -0.3])  # m


@wp.kernel(enable_backward=False)
def wanted(
    phase: wp.array[float], given: places.Walking, model: Model, memory: wp.array2d[float], found: wp.array[wp.vec3],
):  # fmt: skip
    i = wp.tid()
    m = model
    found[i] = ankle_wanted(i, phase[i], given, m, memory[0])


@pytest.mark.parametrize("rise", [0.0, 0.25, -0.25])
@pytest.mark.parametrize("forwards", [0.0, 0.4])
def test_a_foot_rises_to_a_stair_before_it_goes_forwards_and_else_goes_at_once(rise: float, forwards: float):
    phase = np.linspace(0.02, 0.98, 25)
    foothold = np.array([0.14, LIFTED[1] + rise, forwards])
    given = places.Walking()
    given.rise_first, given.step_height = FIRST, HIGH
    memory = np.zeros((1, places.STATE), np.float32)
    for start, values in ((places.LIFTED, LIFTED), (places.FOOTHOLD, foothold), (places.LEG, [LENGTH])):
        memory[0, int(start) : int(start) + len(values)] = values
    found = wp.zeros(len(phase), dtype=wp.vec3, device="cpu")
    arrays = [wp.array(np.float32(v), device="cpu") for v in (phase, memory)]
    wp.launch(wanted, len(phase), [arrays[0], given, filled(Model), arrays[1], found], device="cpu")
    begins, ends = (FIRST if rise > 0.0 else 0.0), float(swing.ARRIVES)  # a stair of 25 cm is a whole one
    s = np.clip((phase - begins) / (ends - begins), 0.0, 1.0)
    share = s * s * (3.0 - 2.0 * s)
    np.testing.assert_allclose(found.numpy()[:, 0], LIFTED[0] + (foothold[0] - LIFTED[0]) * share, atol=1e-5)
    np.testing.assert_allclose(found.numpy()[:, 2], LIFTED[2] + (foothold[2] - LIFTED[2]) * share, atol=1e-5)
    height = evaluate(swing.way_height, phase, LIFTED[1], foothold[1])
    height += HIGH * LENGTH * evaluate(swing.lift, phase) - float(swing.BELOW) * LENGTH * np.maximum(phase - ends, 0.0)
    np.testing.assert_allclose(found.numpy()[:, 1], height, atol=1e-5)


SHARES = np.array([1.0, 0.75, 0.5, 0.25, 0.0])  # of the load, on the right foot


def test_the_hip_that_swings_holds_the_pelvis_by_its_share_of_the_load():
    """It gets -(A + B s)(1 - s), of which A and B are the body's: two shares tell what it gets for the others.

    The right leg stands; horizontal forces keep the left foot from counting as landed.
    """
    rollout = Rollout(load("steer"), len(SHARES), "cpu")
    rollout.set_commands({"speed": 0.9})
    rollout.run(1.31)
    memory = rollout._extensions.struct.first.memory
    values, force = memory.numpy().copy(), np.zeros((len(SHARES), 2, 3), np.float32)
    assert np.all(values[:, 0, int(places.STANCE)] == 1.0)
    force[:, 0, 1], force[:, 1, 1], force[:, :, 0] = 400.0 * (1.0 - SHARES), 400.0 * SHARES, 1e4
    values[:, 0, int(places.LOAD) : int(places.LOAD) + 2] = force[:, :, 1]
    memory.assign(values)
    rollout.state.foot_force.assign(force)
    rollout.run(rollout.scene.time_step)
    names = rollout.names
    thigh = names.parents[names.parents[names.bodies.index(rollout.numeric.character.feet[0])]]
    start = places.STATE + places.OF_BODY * thigh
    after = memory.numpy()[:, 0].astype(float)
    assert np.all(after[:, int(places.STANCE)] == 1.0)
    got = (after - after[0])[:, start : start + 3]
    both = np.linalg.lstsq((1.0 - SHARES[1:3, None]) * SHARES[1:3, None] ** [0, 1], got[1:3], rcond=None)[0]
    expected = (1.0 - SHARES[:, None]) * (both[0] + both[1] * SHARES[:, None])
    assert np.abs(got[-1]).max() > 5.0
    np.testing.assert_allclose(got, expected, atol=0.05 * np.abs(got).max())
    assert np.abs(got[1] - got[-1]).max() > 0.3 * np.abs(got).max()
