"""Differences between states of a body: which motion brings one to another."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import conjugate, from_rotation_vector, multiply, rotation_vector
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.scene.joints import joint_type, root_type


def difference(body: BodyModel, q: Floats, target: Floats) -> Floats:
    """What rates of the speeds (n, S) bring coordinates of the state (n, C) to others in a second, rad and m."""
    names, character = body.topology, body.scene.character
    root, found = root_type(character), np.zeros((len(q), names.speeds))
    count, turns = len(root.moving), len(root.turning)
    found[:, :count] = target[:, :count] - q[:, :count]
    if not turns:
        pass  # it is fixed
    elif root.placed:
        turn = multiply(target[:, 3:7], conjugate(q[:, 3:7]))
        found[:, count : count + turns] = rotation_vector(turn)
    else:
        found[:, count : count + turns] = target[:, count : count + turns] - q[:, count : count + turns]
    for own, at, ball in _joints(body):
        if ball:
            found[:, at] = rotation_vector(multiply(conjugate(q[:, own]), target[:, own]))
        else:
            found[:, at] = target[:, own] - q[:, own]
    return found


def moved_by(body: BodyModel, q: Floats, change: Floats) -> Floats:
    """Coordinates of the state (n, C) that are so far (n, S) from others; `difference` the other way round."""
    root, found = root_type(body.scene.character), np.array(q, dtype=np.float64)
    count, turns = len(root.moving), len(root.turning)
    found[:, :count] += change[:, :count]
    if not turns:
        pass  # it is fixed
    elif root.placed:
        found[:, 3:7] = multiply(from_rotation_vector(change[:, count : count + turns]), q[:, 3:7])
    else:
        found[:, count : count + turns] += change[:, count : count + turns]
    for own, at, ball in _joints(body):
        if ball:
            found[:, own] = multiply(q[:, own], from_rotation_vector(change[:, at]))
        else:
            found[:, own] += change[:, at]
    return found


def _joints(body: BodyModel) -> list[tuple[slice, slice, bool]]:
    """Coordinates and speeds of joints that move, and whether the coordinates are a quaternion."""
    names = body.topology
    found = []
    for number, name in enumerate(names.joints, start=1):
        kind = joint_type(body.scene.character.joints[name])
        if kind.moves:
            found.append((names.coordinates_of(number), names.speeds_of(number), kind.quaternion))
    return found
