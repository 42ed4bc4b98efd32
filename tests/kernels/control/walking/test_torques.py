"""Torques of a walk: where the foot that swings is to be, and hips that hold the pelvis by what their feet bear."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, filled

from warpmuscle.core.pose import rotate
from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.kernels.control.walking import swing
from warpmuscle.kernels.control.walking.torques import GRIP, ankle_wanted
from warpmuscle.kernels.structs import Model
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages

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


def on_the_right_leg(count: int) -> Rollout:
    """Bodies that walk, in the middle of a step."""
    rollout = Rollout(load("steer"), count, "cpu")
    rollout.set_commands({"speed": 0.9})
    rollout.run(1.31)
    return rollout


def loaded(rollout: Rollout, load: np.ndarray) -> np.ndarray:
    """The controller's memory after a step with these loads (n, 2) on the left and the right foot, N.

    Horizontal forces keep the left foot from counting as landed.
    """
    memory = rollout._extensions.struct.first.memory
    values, force = memory.numpy().copy(), np.zeros((len(load), 2, 3), np.float32)
    assert np.all(values[:, 0, int(places.STANCE)] == 1.0)
    force[:, :, 1], force[:, :, 0] = load, 1e4
    values[:, 0, int(places.LOAD) : int(places.LOAD) + 2] = load
    memory.assign(values)
    rollout.state.foot_force.assign(force)
    rollout.run(rollout.scene.time_step)
    after = memory.numpy()[:, 0].astype(float)
    assert np.all(after[:, int(places.STANCE)] == 1.0)
    return after


def thigh_of(rollout: Rollout, side: int) -> int:
    names = rollout.names
    return names.parents[names.parents[names.bodies.index(rollout.numeric.character.feet[side])]]


def torque_on(body: int, memory: np.ndarray) -> np.ndarray:
    """Torque that a body's joint is to give it, world, N m, (n, 3)."""
    start = places.STATE + places.OF_BODY * body
    return memory[:, start : start + 3]


def posed(rollout: Rollout) -> tuple[np.ndarray, np.ndarray]:
    """Centres of mass and joints of all bodies, m, (n, bodies, 3)."""
    stages = Stages(load("steer"), rollout.instances, "cpu")
    stages.state.coordinates.assign(rollout.state.coordinates)
    poses = stages.forward_kinematics()
    middles, turns = (poses[name].astype(float) for name in ("position", "orientation"))
    return middles, middles - rotate(turns, rollout.model.skeleton.row.numpy()["com"][0].astype(float))


def test_the_hip_that_swings_holds_the_pelvis_by_its_share_of_the_load():
    """It gets -(A + B s)(1 - s), of which A and B are the body's: two shares tell what it gets for the others.

    The right leg stands.
    """
    rollout = on_the_right_leg(len(SHARES))
    after = loaded(rollout, np.stack([400.0 * (1.0 - SHARES), 400.0 * SHARES], axis=1))
    got = torque_on(thigh_of(rollout, 0), after - after[0])
    both = np.linalg.lstsq((1.0 - SHARES[1:3, None]) * SHARES[1:3, None] ** [0, 1], got[1:3], rcond=None)[0]
    expected = (1.0 - SHARES[:, None]) * (both[0] + both[1] * SHARES[:, None])
    assert np.abs(got[-1]).max() > 5.0
    np.testing.assert_allclose(got, expected, atol=0.05 * np.abs(got).max())
    assert np.abs(got[1] - got[-1]).max() > 0.3 * np.abs(got).max()


def test_hips_bear_the_body_about_each_by_its_share_of_the_load():
    """Both together bear b_right s + b_left (1 - s), where b is the torque of all but a leg's weight about its hip."""
    rollout = on_the_right_leg(2)
    middles, joints = posed(rollout)
    names, bodies = rollout.names, list(rollout.numeric.character.bodies.values())
    weight = rollout.scene.gravity * np.array([body.mass for body in bodies])
    borne = []
    for side in (0, 1):
        thigh = thigh_of(rollout, side)
        leg = {thigh} | {k for k, parent in enumerate(names.parents) if parent == thigh}
        leg |= {k for k, parent in enumerate(names.parents) if parent in leg}
        rest = [k for k in range(len(bodies)) if k not in leg]
        arms = middles[0, rest] - joints[0, thigh]
        borne.append(np.cross(arms, weight[rest, None] * [0.0, 1.0, 0.0]).sum(axis=0))
    after = loaded(rollout, np.array([[0.0, 500.0], [250.0, 250.0]]))
    left, right = (torque_on(thigh_of(rollout, side), after) for side in (0, 1))
    more = -(left + right)[1] + (left + right)[0]  # on the pelvis, for half of the load on the other foot
    expected = 0.5 * (borne[0] - borne[1])
    assert abs(expected[2]) > 30.0  # to the side; in the other ways the standing leg's grip takes a part
    assert more[2] == pytest.approx(expected[2], abs=1.0)


def test_a_leg_that_stands_turns_about_itself_by_no_more_than_its_foot_bears():
    """Bodies that spin want more; a foot's friction bears GRIP of its length times its load."""
    rollout = on_the_right_leg(2)
    speeds = rollout.state.speeds.numpy()
    speeds[:, 4] += [25.0, -25.0]  # rad/s about the vertical
    rollout.state.speeds.assign(speeds)
    _, joints = posed(rollout)
    after = loaded(rollout, np.array([[0.0, 500.0]] * 2))
    thigh, foot = thigh_of(rollout, 1), rollout.names.bodies.index(rollout.numeric.character.feet[1])
    leg = joints[0, foot] - joints[0, thigh]
    bears = float(GRIP) * (after[0, int(places.TOE)] - after[0, int(places.HEEL)]) * 500.0
    assert bears > 10.0
    about = torque_on(thigh, after) @ leg / np.linalg.norm(leg)
    np.testing.assert_allclose(np.sort(about), [-bears, bears], rtol=0.01)
