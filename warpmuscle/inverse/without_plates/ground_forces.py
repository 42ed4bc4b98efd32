"""Ground forces that a motion needs, shared out among points of the feet.

What nothing but the ground can give, force and moment at the root, is the sum of forces at points within their cones of
friction (Fluit et al. 2014, J Biomech 47: 2321-2329). Among all such forces those are taken that are least, where
points count more the higher they are and the faster they leave the ground, and that point from each foot to a pivot
above the hips, as those of walking people do (Maus et al. 2010, Nature Communications 1: 70): the sum
alone does not tell how far two feet push against each other.
"""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.formats.external_loads import TO_OPENSIM
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.dynamics import prepare
from warpmuscle.inverse.trial import Coordinates, Loads, Plate
from warpmuscle.inverse.without_plates.contact_points import Points, contact_points

FRICTION = 0.8
EXACT = np.array([9.0, 30.0, 9.0, 30.0, 30.0, 30.0])  # weights of what the root needs: force, and moment in 1/m
TO_PIVOT = 2.0  # weight of forces beside the line to the pivot
PIVOT = 0.2  # m, of it above the root
FULL_ROOT = 3  # coordinates of the root at least
SIDES = ("left", "right")
EDGES = np.array([[FRICTION, 1.0, 0.0], [-FRICTION, 1.0, 0.0], [0.0, 1.0, FRICTION], [0.0, 1.0, -FRICTION]])


def ground_forces(body: BodyModel, motion: Coordinates, filter: float | None = None) -> Loads:
    """Forces of the level ground on both feet in all frames of a motion.

    Args:
        filter: Hz, the cut-off of a low-pass filter of the coordinates, which accelerations need where they were
            measured; None for none.

    Returns:
        A plate under each foot, ground axes, as measured ones are.

    Raises:
        ArgumentError: the model stands still or has no feet, or the motion is of another model.
    """
    if body.map.roots < FULL_ROOT:
        raise ArgumentError("ground forces without plates need a model that may fall; this one's root is held")
    trials = prepare(body, motion, None, filter, None)
    dynamics = body.dynamics(trials.states, trials.loads)
    points = contact_points(body, motion.times, dynamics)
    needed = np.concatenate([dynamics.force[:, 0], dynamics.moment[:, 0]], axis=1)
    force = _shared(points, needed, dynamics.position[:, 0])
    plates = [_plate(body, points, force, side, dynamics.position) for side in (0, 1)]
    return Loads(motion.times, tuple(plates))


def _shared(points: Points, needed: Floats, root: Floats) -> Floats:
    """Forces (n, P, 3), N, of points, of which the root needs (n, 6), about its place (n, 3)."""
    from scipy.optimize import nnls

    count, edges = len(points.foot), len(EDGES)
    found = np.zeros((len(needed), count, 3))
    for k, want in enumerate(needed):
        arm = points.place[k] - root[k]
        moment = np.cross(arm[:, None], EDGES[None])
        wrench = np.concatenate([np.broadcast_to(EDGES, moment.shape), moment], axis=2).reshape(-1, 6).T
        way = -arm + np.array([0.0, PIVOT, 0.0])
        beside = (EDGES[None] - (way / way[:, 1:2])[:, None])[..., [0, 2]]  # (P, edges, 2)
        lean = np.zeros((2, 2, count, edges))
        for side in (0, 1):
            own = points.foot == side
            lean[side][:, own] = np.moveaxis(beside[own], 2, 0)
        rows = np.vstack(
            [EXACT[:, None] * wrench, TO_PIVOT * lean.reshape(4, -1), np.diag(np.repeat(points.reluctance[k], edges))]
        )
        size, _ = nnls(rows, np.concatenate([EXACT * want, np.zeros(len(rows) - 6)]), maxiter=100 * rows.shape[1])
        found[k] = size.reshape(count, edges) @ EDGES
    return found


def _plate(body: BodyModel, points: Points, force: Floats, side: int, position: Floats) -> Plate:
    """The sum of the forces on a foot, at its centre of pressure."""
    own, number = points.foot == side, points.bodies[side]
    up, total = force[:, own, 1], force[:, own].sum(axis=1)
    below = position[:, number] * (1.0, 0.0, 1.0)
    at = np.where(
        up.sum(axis=1)[:, None] > 1.0,
        np.einsum("np,npk->nk", up, points.place[:, own]) / np.maximum(up.sum(axis=1), 1.0)[:, None], below,
    )  # fmt: skip
    moment = np.cross(points.place[:, own] - at[:, None], force[:, own]).sum(axis=1)
    turn = TO_OPENSIM.T
    return Plate(SIDES[side], body.topology.bodies[number], total @ turn, at @ turn, moment @ turn)
