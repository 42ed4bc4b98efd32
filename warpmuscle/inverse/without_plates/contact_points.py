"""Points of feet that may touch the ground, in all frames of a motion; world axes, x to the left, y up, z forward."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.pose import rotate
from warpmuscle.inverse.body_model import BodyModel, Dynamics
from warpmuscle.inverse.recordings.motion import scene_with_feet

HALF_WIDTH = 0.03  # m, of a foot
TOES = 0.065  # m, from the joint of the toes to their end
LOWEST = 0.02  # quantile of a point's heights, that counts as on the ground
HEIGHT, SPEED = 0.015, 0.3  # m and m/s of a point that leaves the ground, at which its force weighs four times


class Points(NamedTuple):
    """Points in n frames, those of the left foot first."""

    foot: Integers  # (P,) 0 left, 1 right
    place: Floats  # (n, P, 3) m, on the ground below them
    reluctance: Floats  # (n, P), 1 of a point that rests on the ground
    bodies: tuple[int, int]  # that forces act on, left and right


def contact_points(body: BodyModel, times: Floats, dynamics: Dynamics) -> Points:
    """Heels, balls and ends of the toes, two of each at a foot.

    Args:
        times: (n,) s. dynamics: of the motion without loads.

    Raises:
        ArgumentError: the names of bodies do not tell the feet, or a foot has no toes.
    """
    scene = scene_with_feet(body.scene)
    if scene.feet is None:
        raise ArgumentError(
            "ground forces without plates need two feet: bodies called talus, calcn or foot with _l and _r"
        )
    names, places, foot, heels = body.topology, [], [], []
    for side, name in enumerate(scene.feet):
        heel, toes = heel_and_toes(list(names.parents), names.bodies.index(name), name)
        heels.append(heel)
        for x in (-HALF_WIDTH, HALF_WIDTH):
            for part, z in ((heel, 0.0), (toes, 0.0), (toes, TOES)):
                offset = np.tile([x, 0.0, z], (len(times), 1))
                places.append(dynamics.position[:, part] + rotate(dynamics.orientation[:, part], offset))
                foot.append(side)
    place = np.stack(places, axis=1)
    height = place[..., 1] - np.quantile(place[..., 1], LOWEST, axis=0)
    rate = np.gradient(height, times, axis=0) if len(times) > 1 else np.zeros_like(height)
    reluctance = 1.0 + 3.0 * (np.maximum(height, 0.0) / HEIGHT) ** 2 + 3.0 * (rate / SPEED) ** 2
    place[..., 1] = 0.0
    return Points(np.array(foot), place, reluctance, (heels[0], heels[1]))


def heel_and_toes(parents: list[int], foot: int, name: str) -> tuple[int, int]:
    """Numbers of the last two bodies of a foot."""
    chain = [foot]
    while below := [k for k, parent in enumerate(parents) if parent == chain[-1] and k > chain[-1]]:
        chain.append(below[0])
    if len(chain) < 2:
        raise ArgumentError(f"ground forces without plates need toes, and no body hangs on {name!r}")
    return chain[-2], chain[-1]
