"""Ribs of an animal on four legs: where they are, and that an upright trunk has none of them."""

import numpy as np
import pytest

from closed_meshes import check, volume
from warpmuscle.scene import Body, Character, Joint
from warpmuscle.scene.topology import topology
from warpmuscle.view.bones.barrel import barrel_bones
from warpmuscle.view.figure import figure_of
from warpmuscle.view.pieces import Hull

HIPS = [np.array([0.1, -0.05, -0.35]), np.array([-0.1, -0.05, -0.35])]
NECK = np.array([0.0, 0.09, 0.42])
SHOULDERS = [np.array([0.1, -0.11, 0.36]), np.array([-0.1, -0.11, 0.36])]


def test_ribs_are_closed_mirrored_and_lie_between_hips_and_neck():
    corners, normals, faces = barrel_bones(HIPS, NECK, SHOULDERS, 1.0)
    check(corners, normals, faces)
    assert volume((corners, normals, faces)) > 0.0
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert high[0] == pytest.approx(-low[0], abs=1e-3)
    assert low[2] > -0.35
    assert high[2] < 0.45
    assert low[1] == pytest.approx(-0.16, abs=0.03)  # a little below the shoulders


@pytest.mark.parametrize(("turned", "barrels"), [(False, 1), (True, 0)])
def test_only_a_level_trunk_has_a_barrel(turned: bool, barrels: int):
    """The same trunk upright, legs below and arms above, is no animal's."""

    def place(point: np.ndarray) -> tuple[float, float, float]:
        x, y, z = point
        return (x, z, -y) if turned else (x, y, z)

    ends = {"lLeg": HIPS[0], "rLeg": HIPS[1], "lArm": SHOULDERS[0], "rArm": SHOULDERS[1], "head": NECK}
    bodies = {name: Body(5.0, (0.1, 0.1, 0.1)) for name in ("trunk", *ends, "lFoot", "rFoot")}
    joints = {f"j{name}": Joint("hinge", "trunk", name, place(end), (0.0, 0.2, 0.0), [(1.0, 0.0, 0.0)])
              for name, end in ends.items()}  # fmt: skip
    for side in "lr":
        above, below = (0.0, -0.2, 0.0), (0.0, 0.1, 0.0)
        joints[f"{side}Ankle"] = Joint("hinge", f"{side}Leg", f"{side}Foot", above, below, [(1.0, 0.0, 0.0)])
    character = Character(bodies=bodies, joints=joints, root="trunk", feet=("lFoot", "rFoot"))
    names = topology(character).bodies
    pieces = figure_of(character, ("lFoot", "rFoot"), names)
    bones = [p for p in pieces if isinstance(p, Hull) and p.layer == "bone" and names[p.body] == "trunk"]
    assert len(bones) == 1 + barrels
