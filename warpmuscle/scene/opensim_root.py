"""The root of a scene that was made of an OpenSim model: the coordinates of its joint to the ground, and its pose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import first_number, rows
from warpmuscle.core.pose import about, euler_xyz, multiply, normalized, rotate, twist_angle, unwrapped
from warpmuscle.scene.displacement import Displacement
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.scene import Character, Joint, OpenSim

_STRAIGHT = 1.0e-6  # of the angle's cosine, by which axes may miss being at right angles


class RootMotion(NamedTuple):
    """Where the root body is in n states, and how its joint's R coordinates move it; world axes."""

    position: Floats  # (n, 3) m, of its centre of mass
    orientation: Floats  # (n, 4)
    moving: Floats  # (n, R, 3) velocity of its centre of mass by a unit rate of each coordinate
    turning: Floats  # (n, R, 3) angular velocity


def usual_root(character: Character) -> OpenSim:
    """The root of a scene that came from elsewhere, as OpenSim's models have it.

    It turns about OpenSim's z, x and y axes and moves along x, y and z, or only as it does in a plane: `pelvis_tilt`,
    `pelvis_list`, `pelvis_rotation`, `pelvis_tx`, `pelvis_ty`, `pelvis_tz`, of its centre of mass.
    """
    name, speeds = character.root, root_type(character).speeds
    if not speeds:
        return OpenSim()
    turns = {"tilt": (-1.0, 0.0, 0.0), "list": (0.0, 0.0, 1.0), "rotation": (0.0, 1.0, 0.0)}
    shifts = {"tx": (0.0, 0.0, 1.0), "ty": (0.0, 1.0, 0.0), "tz": (-1.0, 0.0, 0.0)}
    if len(speeds) == 3:
        turns, shifts = {"tilt": turns["tilt"]}, {"tx": shifts["tx"], "ty": shifts["ty"]}
    root = Joint("coupled", "ground", name, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    root.rotations = [Displacement(axis, slope=1.0) for axis in turns.values()]
    root.translations = [Displacement(axis, slope=1.0) for axis in shifts.values()]
    return OpenSim(root=root, root_coordinates=[f"{name}_{word}" for word in (*turns, *shifts)])


def root_motion(opensim: OpenSim, values: Floats) -> RootMotion:
    """The root's pose at the coordinates (n, R) of `root_coordinates`, rad and m; a fixed one has none.

    The joint turns about its rotations in their order, each axis riding on the turns before, and its point on the root
    body moves along its translations, as of OpenSim's CustomJoint.
    """
    count, joint = len(values), opensim.root
    orientation, position = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), np.zeros((count, 3))
    moving, turning = np.zeros((count, values.shape[1], 3)), np.zeros((count, values.shape[1], 3))
    if joint is None:
        return RootMotion(position, orientation, moving, turning)
    position += rows(joint.position_in_parent)
    for k, rotation in enumerate(joint.rotations):
        axis, slope, shift = _line(rotation)
        turning[:, k] = slope * rotate(orientation, np.broadcast_to(axis, (count, 3)))
        orientation = multiply(orientation, about(axis, shift + slope * values[:, k]))
    for k, translation in enumerate(joint.translations, start=len(joint.rotations)):
        axis, slope, shift = _line(translation)
        moving[:, k] = slope * axis
        position = position + axis * (shift + slope * values[:, k])[:, None]
    arm = -rotate(orientation, rows(joint.position_in_child))
    return RootMotion(position + arm, orientation, moving + np.cross(turning, arm[:, None]), turning)


def root_values(opensim: OpenSim, position: Floats, orientation: Floats, breaks: ArrayLike = ()) -> Floats:
    """The coordinates (n, R), rad and m, of a root that is there: centre of mass (n, 3), m, and orientation (n, 4).

    Args:
        breaks: states at which others begin; angles are continuous from state to state but there.
    """
    joint = opensim.root
    if joint is None:
        return np.zeros((len(position), 0))
    turned = normalized(orientation)
    place = position + rotate(turned, rows(joint.position_in_child)) - rows(joint.position_in_parent)
    columns = _angles(joint, turned, breaks)
    lines = [_line(translation) for translation in joint.translations]
    if lines:
        with np.errstate(invalid="ignore"):  # what is not finite stays so
            along = place @ np.linalg.pinv(np.array([axis for axis, _, _ in lines]))
        columns += [(along[:, k] - shift) / slope for k, (_, slope, shift) in enumerate(lines)]
    return np.stack(columns, axis=1) if columns else np.zeros((len(position), 0))


def _angles(joint: Joint, orientation: Floats, breaks: ArrayLike) -> list[Floats]:
    """Coordinates of one rotation, or of three about axes at right angles."""
    lines = [_line(rotation) for rotation in joint.rotations]
    if len(lines) < 2:
        angles = [unwrapped(twist_angle(orientation, axis), breaks) for axis, _, _ in lines]
        return [(angle - shift) / slope for angle, (_, slope, shift) in zip(angles, lines, strict=True)]
    axes = np.array([axis for axis, _, _ in lines])
    handed = np.linalg.det(axes)  # 1, or -1 if they are left-handed
    if abs(abs(handed) - 1.0) > _STRAIGHT:
        raise ValueError("the rotations of a free root are about axes at right angles")
    basis = axes * [[1.0], [1.0], [handed]]
    inside = np.concatenate([orientation[:, :3] @ basis.T, orientation[:, 3:]], axis=1)
    angles = list((euler_xyz(inside, breaks) * [1.0, 1.0, handed]).T)
    return [(angle - shift) / slope for angle, (_, slope, shift) in zip(angles, lines, strict=True)]


def _line(displacement: Displacement) -> tuple[Floats, float, float]:
    """Axis (3,), slope and value at 0 of a displacement of the root."""
    slope, value = first_number(displacement.slope), first_number(displacement.value)
    return np.asarray(normalized(rows(displacement.axis))[0]), slope, value
