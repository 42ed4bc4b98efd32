"""Each type of joint moves on the device as on the host: who adds a type and forgets a part of its motion is told."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.kernels.body.joint_motion import JointMotion
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import Model, ModelRef, at
from warpmuscle.model.joints import motion_of
from warpmuscle.scene import Body, Character, Displacement, Failure, InitialState, Joint, Scene
from warpmuscle.scene.joints import TYPES, JointType
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

Q = np.random.default_rng(5).uniform(-1.2, 1.2, 12)
ORIGIN = (0.0, 0.0, 0.0)


def joint_of(kind: JointType) -> Joint:
    """A joint of a type about an oblique axis."""
    joint = Joint(kind.name, "base", "rod", ORIGIN, ORIGIN, [(0.36, -0.8, 0.48)][: kind.axes])
    if kind.displaced:
        wave = Displacement((0.36, 0.48, 0.8), x=[-3.0, -1.0, 0.2, 1.0, 3.0], y=[0.3, -0.2, 0.1, 0.4, -0.1])
        joint.rotations = [Displacement((0.36, -0.8, 0.48), 0.2, 1.1), wave]
        joint.translations = [Displacement((0.8, 0.36, -0.48), slope=0.05), wave]
    return joint


def on_device(joint: Joint, motion: object) -> np.ndarray:
    """The motion that the function of a type finds at each of the coordinates."""
    bodies = {name: Body(1.0, (0.02, 0.03, 0.01)) for name in ("base", "rod")}
    scene = Scene(
        "joint", Character("base", bodies, {"joint": joint}, "fixed"), initial_state=InitialState(),
        failure=Failure(com_height=0.0, heading=0.0), duration=0.1,
    )  # fmt: skip
    model = Rollout(scene, 1, "cpu").model

    @wp.kernel(enable_backward=False, module="unique")
    def move(model: Model, q: wp.array[float], found: wp.array[JointMotion]):
        i = wp.tid()
        found[i] = motion(0, 1, q[i], model)

    found = wp.zeros(len(Q), dtype=JointMotion, device="cpu")
    given = wp.array(Q, dtype=float, device="cpu")
    wp.launch(move, len(Q), [model, given, found], device="cpu")
    return found.numpy()


def check(kind: JointType, motion: object) -> None:
    """The host's pose, motion subspace, and its rate at a unit speed, which is its slope."""
    joint = joint_of(kind)
    found, told = on_device(joint, motion), kind.motion(joint, Q[:, None], np.ones((len(Q), 1)))
    same = np.abs(np.sum(found["orientation"] * told.orientation, axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-5, err_msg="orientation")
    for name, wanted in (
        ("place", told.place), ("turning", told.turning[0]), ("moving", told.moving[0]),
        ("turning_slope", told.turning_drift), ("moving_slope", told.moving_drift),
    ):  # fmt: skip
        np.testing.assert_allclose(found[name], wanted, atol=1e-4, err_msg=name)


@pytest.mark.parametrize("name", sorted(name for name, kind in TYPES.items() if kind.kernel))
def test_the_device_moves_a_joint_as_the_host_does(name: str):
    check(TYPES[name], motion_of(TYPES[name]))


def test_a_part_of_its_motion_that_the_device_forgets_is_found():
    @func
    def stiff(instance: int, body: int, q: float, model: ModelRef) -> JointMotion:
        m = JointMotion()
        m.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
        m.place = at(model.skeleton.row, instance, body).axis_a * q
        return m

    with pytest.raises(AssertionError, match="moving"):
        check(TYPES["slide"], stiff)
