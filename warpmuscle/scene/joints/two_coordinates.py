"""Functions of two coordinates q and p: sums of powers of both, and where the end of a rod is that bends along an arc.

A rod of length L along y bends by turns x and then z about these axes, with the same curvature all along (Simbody's and
OpenSim's ConstantCurvatureJoint). With c = cos x cos z = cos theta, its end is at

    L (-g sin z, f, g sin x cos z),    f(c) = sin(theta)/theta,    g(c) = f/(1 + c),

which are smooth where the rod is straight, c = 1 (see `kernels.algebra.bending`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.number_rows import rows
from warpmuscle.kernels.algebra.bending import SERIES, STRAIGHT
from warpmuscle.scene import Displacement


class RatesOfTwo(NamedTuple):
    """A function of q and p in n states, and its derivatives (n,)."""

    value: Floats
    first: Floats  # by q
    second: Floats  # by q twice
    mixed: Floats  # by q and p


def rates_of_two(displacement: Displacement, component: int, rate_only: bool, q: Floats, p: Floats) -> RatesOfTwo:
    """What a displacement is at coordinates (n,) of a joint and of the one beside it.

    Args:
        component: along which axis of a rod it is. rate_only: whether q is the second one of its turns.
    """
    if displacement.rod:
        return _rod(displacement, component, rate_only, q, p)
    zero = np.zeros(np.broadcast(q, p).shape)
    value, first, second, mixed = zero + rows(displacement.value), zero, zero, zero
    for number, m, n in displacement.terms:
        a = rows(number)
        value = value + a * q**m * p**n
        first = first + a * m * q ** max(m - 1, 0) * p**n
        second = second + a * m * (m - 1) * q ** max(m - 2, 0) * p**n
        mixed = mixed + a * m * n * q ** max(m - 1, 0) * p ** max(n - 1, 0)
    return RatesOfTwo(value, first, second, mixed)


def _rod(displacement: Displacement, component: int, rate_only: bool, q: Floats, p: Floats) -> RatesOfTwo:
    length, first, second = (rows(number) for number in displacement.rod)
    x, z = (p + first, q + second) if rate_only else (q + first, p + second)
    sx, cx, sz, cz = np.sin(x), np.cos(x), np.sin(z), np.cos(z)
    c = cx * cz
    f = bend_rates(1.0 - c)
    c_q, c_qq, c_qp = (-cx * sz, -c, sx * sz) if rate_only else (-sx * cz, -c, sx * sz)
    if component == 1:
        u, u_q, u_p, u_qq, u_qp = (np.ones_like(c), *[np.zeros_like(c)] * 4)
    elif component == 0:
        u = -sz
        u_q, u_p, u_qq = (-cz, 0.0 * cz, sz) if rate_only else (0.0 * cz, -cz, 0.0 * cz)
        u_qp = 0.0 * cz
    else:
        u, by_x, by_z = sx * cz, cx * cz, -sx * sz
        u_q, u_p = (by_z, by_x) if rate_only else (by_x, by_z)
        u_qq, u_qp = -u, -cx * sz
    c_p = -sx * cz if rate_only else -cx * sz
    h, h1, h2 = f
    if component != 1:
        part = 1.0 / (1.0 + c)
        h, h1, h2 = f[0] * part, (f[1] - f[0] * part) * part, (f[2] - 2.0 * (f[1] - f[0] * part) * part) * part
    return RatesOfTwo(
        length * h * u,
        length * (h1 * c_q * u + h * u_q),
        length * (h2 * c_q * c_q * u + h1 * (c_qq * u + 2.0 * c_q * u_q) + h * u_qq),
        length * (h2 * c_q * c_p * u + h1 * (c_qp * u + c_q * u_p + c_p * u_q) + h * u_qp),
    )


def bend_rates(e: Floats) -> tuple[Floats, Floats, Floats]:
    """sin(theta)/theta where cos(theta) = 1 - e, and its first and second derivatives by cos(theta)."""
    near = np.minimum(e, STRAIGHT)
    powers = np.polynomial.Polynomial(SERIES)
    f, f1, f2 = powers(near), -powers.deriv()(near), powers.deriv(2)(near)
    c = 1.0 - np.maximum(e, STRAIGHT)
    theta, s = np.arccos(c), np.sqrt(1.0 - c * c)
    far = e > STRAIGHT
    f = np.where(far, s / theta, f)
    f1 = np.where(far, (s - theta * c) / (theta * theta * s), f1)
    f2 = np.where(far, (2.0 / theta**3 - (theta + c * s) / (theta * theta * s * s)) / s, f2)
    return f, f1, f2


def depends_on_two(displacement: Displacement) -> bool:
    """Whether a displacement changes with one of two coordinates."""
    return bool(displacement.rod) or any(m + n > 0 for _, m, n in displacement.terms)
