"""What joints put on a body, at any frame and in any axes, against NumPy in float64."""

import numpy as np
import pytest
import warp as wp

from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.core.pose import conjugate, normalized, rotate
from warpmuscle.kernels.inverse import joint_reactions as kernels

FRAMES, BODIES = 5, 4
TURNED = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@pytest.mark.parametrize("pulled", [False, True])
@pytest.mark.parametrize(("sign", "acting", "shown"), [(1.0, 2, 2), (-1.0, 1, 2), (1.0, 3, -1), (-1.0, -1, 1)])
def test_reactions_are_those_of_float64(pulled: bool, sign: float, acting: int, shown: int):
    random = np.random.default_rng(4)
    moment, force, m_muscle, f_muscle, position = (random.normal(size=(FRAMES, BODIES, 3)) for _ in range(5))
    orientation = normalized(random.normal(size=(FRAMES, BODIES, 4)))
    place, origin, center = random.normal(size=(3, 3))
    columns = {
        "body": [2], "sign": [sign], "acting": [acting], "place": [place], "shown": [shown],
        "origin": [origin], "turn": [TURNED], "center": [center],
    }  # fmt: skip
    joints = structs_to_device(kernels.ReactionJoint, {k: np.array(v) for k, v in columns.items()}, "cpu")
    wrenches = kernels.JointWrenches()
    vectors = {"moment": moment, "force": force, "position": position}
    if pulled:
        vectors |= {"pulled_moment": m_muscle, "pulled_force": f_muscle}
    for name, values in vectors.items():
        setattr(wrenches, name, to_device(values, wp.vec3, "cpu"))
    wrenches.orientation = to_device(orientation, wp.quat, "cpu")
    found = [wp.empty((FRAMES, 1), dtype=wp.vec3, device="cpu") for _ in range(3)]
    wp.launch(kernels.joint_reactions, (FRAMES, 1), [joints, wrenches], found, device="cpu")

    carried, turning = force[:, 2] - pulled * f_muscle[:, 2], moment[:, 2] - pulled * m_muscle[:, 2]
    at = place if acting < 0 else position[:, acting] + rotate(orientation[:, acting], np.tile(place, (FRAMES, 1)))
    turning = turning + np.cross(position[:, 2] - at, carried)
    start = 0.0
    if shown >= 0:
        start = position[:, shown] + rotate(orientation[:, shown], np.tile(origin, (FRAMES, 1)))
    vectors = [sign * carried, sign * turning, np.broadcast_to(at - start, (FRAMES, 3))]
    if shown >= 0:
        vectors = [rotate(conjugate(orientation[:, shown]), one) for one in vectors]
    wanted = [one @ TURNED.T for one in vectors]
    for array, expected, shift in zip(found, wanted, (0.0, 0.0, center), strict=True):
        assert array.numpy()[:, 0] == pytest.approx(expected + shift, abs=3e-6)
