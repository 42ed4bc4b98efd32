"""Parts of a working set that lie in a GPU's main memory: here on a CPU, behind the rest, with the same motion."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.memory.main_memory import LEAN, SIDE, apart_floats
from warpmuscle.kernels.step import step_kernel
from warpmuscle.kernels.structs import Record
from warpmuscle.scene import Body, Character, Displacement, Failure, Ground, Joint, Scene
from warpmuscle.simulation.rollout import Rollout

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
NEAR, FAR = (0.03, -0.2, 0.01), (-0.02, 0.2, 0.03)
TURNING, INSTANCES, STEPS = 2.0, 3, 20  # rad/s, of the starts


def body() -> Scene:
    """A shoulder blade that follows the arm, over joints of several types."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("pelvis", "chest", "scapula", "arm", "fore", "head")}
    turns = [Displacement((0.2, 0.9, -0.3), 0.1, 0.4), Displacement(X, polynomial=[0.01, 0.2, -0.03])]
    joints = {
        "waist": Joint("ball", "pelvis", "chest", NEAR, FAR),
        "scapular": Joint("coupled", "chest", "scapula", NEAR, FAR, rotations=turns, follows="elbow"),
        "shoulder": Joint("universal", "scapula", "arm", NEAR, FAR, [X, Z]),
        "elbow": Joint("hinge", "arm", "fore", NEAR, FAR, [X]),
        "neck": Joint("slide", "chest", "head", FAR, NEAR, [Y]),
    }
    character = Character("pelvis", bodies, joints, "free")
    return Scene("body", character, ground=Ground(stiffness=0.0), failure=Failure(com_height=0.0, heading=0.0))


def moved(rollout: Rollout, apart: bool, lean: bool) -> np.ndarray:
    """Where instances come to; their memory holds no numbers at first, so that what has no place of its own shows."""
    config = rollout._launcher.config
    config = config.compiling(skeleton=config.kind.skeleton._replace(apart=apart, lean=lean))
    rollout.reset()
    speeds = rollout.state.speeds
    speeds.assign(np.random.default_rng(1).uniform(-TURNING, TURNING, speeds.shape).astype(np.float32))
    far = config.buffer_floats(INSTANCES) if apart else 0
    memory = wp.full(config.work_floats + far, np.nan, dtype=float, device="cpu")
    running = wp.array(np.arange(INSTANCES), dtype=int, device="cpu")
    given = [
        STEPS, running, rollout.model, rollout.state, Record(), wp.uint64(memory.ptr), rollout._extensions.struct
    ]  # fmt: skip
    wp.launch(step_kernel(*config), (INSTANCES, 1), given, device="cpu", block_dim=1)
    return rollout.state.coordinates.numpy()


@pytest.mark.long
@pytest.mark.usefixtures("unoptimized_kernels")
def test_motion_is_the_same_wherever_numbers_lie():
    rollout = Rollout(body(), INSTANCES, "cpu", threads=1)
    near = moved(rollout, apart=False, lean=False)
    assert np.ptp(near, axis=0).max() > 1e-3
    assert np.isfinite(near).all()
    for lean in (False, True):
        np.testing.assert_array_equal(moved(rollout, apart=True, lean=lean), near)


def test_main_memory_has_room_for_whole_groups_of_instances():
    config = Rollout(body(), 1, "cpu")._launcher.config
    entries, bodies = config.kind.skeleton.entries, config.capacity
    assert apart_floats(entries, bodies, False) == 13 * entries
    assert apart_floats(entries, bodies, True) == 13 * entries + LEAN * bodies
    lean = config.compiling(skeleton=config.kind.skeleton._replace(apart=True, lean=True))
    for instances, rows in ((1, SIDE), (SIDE, SIDE), (SIDE + 1, 2 * SIDE)):
        assert lean.buffer_floats(instances) == (13 * entries + LEAN * bodies) * rows
    assert lean.work_floats < config.work_floats
