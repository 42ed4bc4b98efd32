"""Whether OpenSim's accelerations are the rates of its velocities, and its inverse dynamics if they were.

Simbody's joints of functions turn their second and third axis as if each coordinate moved one rotation alone
(`MobilizedBody::FunctionBasedImpl::CacheInfo::buildHdot`). Where one coordinate turns several axes, or the coordinates
are not in the order of the axes, what a body's acceleration has of its joint's rates is not the derivative of the
joint's own velocity. Here it is found by differences of velocities along the motion, and inertial forces are put right.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from opensim_posed import Posed

Floats = NDArray[np.float64]
MOMENT = 1e-4  # s, of central differences of fourth order
SAME = 1e-6  # of the mass matrix, to which the bodies' masses have to add up


def put_right(model: Posed, q: Floats, rate: Floats, acceleration: Floats) -> tuple[Floats, float]:
    """Generalised forces (S,) of all speeds that OpenSim's inverse dynamics lacks, and the worst acceleration.

    Args:
        q, rate, acceleration: of all coordinates, (K,).

    Returns:
        NaN in place of forces if OpenSim has divided bodies whose masses it does not tell; and the greatest difference
        of a body's acceleration from the rate of its velocity, over the greatest acceleration.
    """
    opensim, state, matter = model.opensim, model.bare_state, model.bare.getMatterSubsystem()
    parts = [_velocity(model, q + t * rate + 0.5 * t * t * acceleration, rate + t * acceleration)
             for t in (-2.0 * MOMENT, -MOMENT, MOMENT, 2.0 * MOMENT)]  # fmt: skip
    expected = (8.0 * (parts[2] - parts[1]) - (parts[3] - parts[0])) / (12.0 * MOMENT)
    _velocity(model, q, rate)
    drift, bias = opensim.Vector(state.getNQ(), 0.0), opensim.Vector()
    matter.multiplyByNDot(state, False, state.getU(), drift)
    left = model.speeds(model.bare, state, acceleration - drift.to_numpy()[model.place])
    matter.calcBiasForSystemJacobian(state, bias)
    along = _jacobian(model)
    missing = (expected - along @ left.to_numpy() - bias.to_numpy()).reshape(-1, 6)
    worst = float(np.abs(missing).max() / max(np.abs(expected).max(), 1e-9))
    inertia, matrix = _inertia(model, len(missing)), opensim.Matrix()
    matter.calcM(state, matrix)
    per_body = along.reshape(len(missing), 6, -1)
    added = np.einsum("bis,bij,bjt->st", per_body, inertia, per_body)
    whole = matrix.to_numpy()
    forces: Floats = np.einsum("bis,bij,bj->s", per_body, inertia, missing)
    if np.abs(added - whole).max() > SAME * np.abs(whole).max():
        forces = np.full_like(forces, np.nan)
    return forces, worst


def _velocity(model: Posed, q: Floats, rate: Floats) -> Floats:
    """Angular and linear velocity of all bodies in the ground's axes, (6 B,); the state is left there."""
    model.put(model.bare_state, model.bare_coordinates, q)
    model.put_speeds(model.bare, model.bare_state, rate)
    model.bare.realizeVelocity(model.bare_state)
    return np.asarray(_jacobian(model) @ model.bare_state.getU().to_numpy())


def _jacobian(model: Posed) -> Floats:
    matrix = model.opensim.Matrix()
    model.bare.getMatterSubsystem().calcSystemJacobian(model.bare_state, matrix)
    return np.asarray(matrix.to_numpy())


def _inertia(model: Posed, count: int) -> Floats:
    """Spatial inertia (B, 6, 6) of the bodies about their origins in the ground's axes."""
    found = np.zeros((count, 6, 6))
    bodies = model.bare.getBodySet()
    for k in range(bodies.getSize()):
        body = bodies.get(k)
        mass = body.getMass()
        turn = body.getTransformInGround(model.bare_state).R()
        axes = np.array([[turn.get(i, j) for j in range(3)] for i in range(3)])
        centre = _cross(axes @ body.getMassCenter().to_numpy())
        about = axes @ _tensor(body.getInertia()) @ axes.T - mass * centre @ centre
        place = int(body.getMobilizedBodyIndex())
        found[place] += np.block([[about, mass * centre], [-mass * centre, mass * np.eye(3)]])
    return found


def _tensor(inertia: Any) -> Floats:
    moments, products = inertia.getMoments().to_numpy(), inertia.getProducts().to_numpy()
    xy, xz, yz = products
    return np.diag(moments) + np.array([[0.0, xy, xz], [xy, 0.0, yz], [xz, yz, 0.0]])


def _cross(v: Floats) -> Floats:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
