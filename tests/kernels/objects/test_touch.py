"""An object in a body: the same force whether the body's frame has its principal axes or is turned against them."""

import numpy as np
import pytest
import warp as wp
from probes import filled, matrix, turn_about

from warpmuscle.kernels.body_structs import Couplings
from warpmuscle.kernels.object_structs import ObjectCapsule, ObjectMotion, ObjectRow
from warpmuscle.kernels.objects.touch import object_touch_of
from warpmuscle.kernels.structs import Model, Scratch, Skeleton

INERTIA = np.array([0.02, 0.3, 0.05])  # kg m^2, about principal axes
TURN = turn_about(np.array([0.6, 0.0, 0.8]), np.array([0.9]))  # of the body's frame against these axes


def touching(turned: bool) -> wp.Kernel:
    """A kernel of what an object and a body do to each other."""
    object_touch = object_touch_of(turned)

    @wp.kernel(enable_backward=False, module="unique")
    def touch(
        capsule: ObjectCapsule,
        row: ObjectRow,
        motion: ObjectMotion,
        model: Model,
        work: Scratch,
        found: wp.array[wp.vec3],
    ):
        its = work
        found[0] = object_touch(1, 0, True, False, capsule, row, motion, model, its).force

    return touch


def force_on_body(frame: np.ndarray | None) -> np.ndarray:
    """Force, N, of a ball that comes down beside the middle of a capsule at rest.

    Args:
        frame: matrix of the body's frame in its principal axes, which are the world's; None: it is these axes.
    """
    to_frame = np.eye(3) if frame is None else frame.T
    capsule = ObjectCapsule()
    capsule.middle, capsule.half = (wp.vec3(*(to_frame @ np.array(v))) for v in ([0.1, 0.0, 0.2], [0.3, 0.0, 0.0]))
    capsule.radius, capsule.reach = 0.05, 0.35
    row = ObjectRow()
    row.mass, row.inertia, row.radius, row.reach = 0.5, wp.vec3(0.002, 0.002, 0.002), 0.1, 0.1
    row.stiffness, row.damping_ratio, row.friction, row.tangential_damping = 3e5, 0.1, 0.4, 1e3
    motion = ObjectMotion()
    motion.place, motion.velocity = wp.vec3(0.25, 0.145, 0.22), wp.vec3(0.3, -1.0, 0.2)
    motion.orientation = wp.quat(0.0, 0.0, 0.0, 1.0)
    bodies = {"com": np.zeros((1, 1, 3)), "inertia": INERTIA[None, None], "mass": np.array([[1.0]])}
    model = filled(Model, time_step=0.002, skeleton=filled(Skeleton, row=bodies))
    if frame is not None:
        model.couplings = filled(Couplings, inertia_axes=np.float32(to_frame)[None, None])
    still = np.zeros((1, 3), np.float32)
    work = filled(
        Scratch, rotation=np.float32(to_frame.T)[None], position=still, velocity=still.copy(),
        angular_velocity=still.copy(), lag_velocity=still.copy(), lag_angular=still.copy(),
    )  # fmt: skip
    found = wp.zeros(1, dtype=wp.vec3, device="cpu")
    wp.launch(touching(frame is not None), 1, [capsule, row, motion, model, work, found], device="cpu")
    return found.numpy()[0].astype(float)


def test_a_force_does_not_depend_on_the_frame_that_a_body_is_described_in():
    expected = force_on_body(None)
    assert expected[1] < -10.0
    np.testing.assert_allclose(force_on_body(matrix(TURN)[0]), expected, rtol=1e-4, atol=1e-3)
    other = np.eye(3)[[1, 2, 0]]
    assert np.linalg.det(other) == pytest.approx(1.0)
    np.testing.assert_allclose(force_on_body(other), expected, rtol=1e-4, atol=1e-3)
