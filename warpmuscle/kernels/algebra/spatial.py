"""Spatial algebra on plain values: symmetric 3x3 blocks, quaternions about the vertical, rotation integration.

A symmetric 3x3 matrix is kept as six numbers (xx, xy, xz, yy, yz, zz). Quaternions are (x, y, z, w).
"""

import warp as wp

from warpmuscle.kernels.functions import func

symmetric = wp.types.vector(length=6, dtype=float)


@func
def symmetric_part(m: wp.mat33) -> symmetric:
    """The symmetric part of a matrix, (m + m^T)/2."""
    return symmetric(
        m[0, 0],
        0.5 * (m[0, 1] + m[1, 0]),
        0.5 * (m[0, 2] + m[2, 0]),
        m[1, 1],
        0.5 * (m[1, 2] + m[2, 1]),
        m[2, 2],
    )


@func
def full(s: symmetric) -> wp.mat33:
    """The 3x3 matrix of six numbers."""
    return wp.mat33(s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5])


@func
def symmetric_times(s: symmetric, v: wp.vec3) -> wp.vec3:
    """S v."""
    return wp.vec3(
        s[0] * v[0] + s[1] * v[1] + s[2] * v[2],
        s[1] * v[0] + s[3] * v[1] + s[4] * v[2],
        s[2] * v[0] + s[4] * v[1] + s[5] * v[2],
    )


@func
def symmetric_outer(v: wp.vec3, factor: float) -> symmetric:
    """factor v v^T."""
    w = v * factor
    return symmetric(w[0] * v[0], w[0] * v[1], w[0] * v[2], w[1] * v[1], w[1] * v[2], w[2] * v[2])


@func
def symmetric_inverse(s: symmetric) -> symmetric:
    """S^-1 by cofactors."""
    c0 = s[3] * s[5] - s[4] * s[4]
    c1 = s[2] * s[4] - s[1] * s[5]
    c2 = s[1] * s[4] - s[2] * s[3]
    d = 1.0 / (s[0] * c0 + s[1] * c1 + s[2] * c2)
    return symmetric(
        c0 * d,
        c1 * d,
        c2 * d,
        (s[0] * s[5] - s[2] * s[2]) * d,
        (s[1] * s[2] - s[0] * s[4]) * d,
        (s[0] * s[3] - s[1] * s[1]) * d,
    )


@func
def symmetric_rotated(rotation: wp.mat33, d: wp.vec3) -> symmetric:
    """R diag(d) R^T: a tensor with principal values d along body axes, in world axes."""
    x = wp.vec3(rotation[0, 0], rotation[0, 1], rotation[0, 2])
    y = wp.vec3(rotation[1, 0], rotation[1, 1], rotation[1, 2])
    z = wp.vec3(rotation[2, 0], rotation[2, 1], rotation[2, 2])
    dx = wp.cw_mul(d, x)
    dy = wp.cw_mul(d, y)
    dz = wp.cw_mul(d, z)
    return symmetric(wp.dot(dx, x), wp.dot(dx, y), wp.dot(dx, z), wp.dot(dy, y), wp.dot(dy, z), wp.dot(dz, z))


@func
def symmetric_product(a: wp.mat33, b: wp.mat33) -> symmetric:
    """A B where the product is known to be symmetric: its upper half."""
    a0 = wp.vec3(a[0, 0], a[0, 1], a[0, 2])
    a1 = wp.vec3(a[1, 0], a[1, 1], a[1, 2])
    a2 = wp.vec3(a[2, 0], a[2, 1], a[2, 2])
    b0 = wp.vec3(b[0, 0], b[1, 0], b[2, 0])
    b1 = wp.vec3(b[0, 1], b[1, 1], b[2, 1])
    b2 = wp.vec3(b[0, 2], b[1, 2], b[2, 2])
    return symmetric(wp.dot(a0, b0), wp.dot(a0, b1), wp.dot(a0, b2), wp.dot(a1, b1), wp.dot(a1, b2), wp.dot(a2, b2))


@wp.func_native(
    snippet="""
#if defined(__CUDA_ARCH__)
const float c = 2.0f * q.w * q.w - 1.0f;
const float x = 2.0f * q.x, y = 2.0f * q.y, z = 2.0f * q.z;
return wp::mat33(
    c + q.x * x, fmaf(q.x, y, -(q.w * z)), q.x * z + q.w * y,
    q.y * x + q.w * z, c + q.y * y, fmaf(q.y, z, -(q.w * x)),
    fmaf(q.z, x, -(q.w * y)), q.z * y + q.w * x, c + q.z * z);
#else
return wp::quat_to_matrix(q);
#endif
"""
)
def rotation_matrix(q: wp.quat) -> wp.mat33: ...  # of a unit quaternion; `quat_to_matrix` would multiply by many zeros


@func
def cross_rows(r: wp.vec3, s: symmetric) -> wp.mat33:
    """[r]x S, with [r]x the matrix of the cross product."""
    return wp.mat33(
        r[1] * s[2] - r[2] * s[1],
        r[1] * s[4] - r[2] * s[3],
        r[1] * s[5] - r[2] * s[4],
        r[2] * s[0] - r[0] * s[2],
        r[2] * s[1] - r[0] * s[4],
        r[2] * s[2] - r[0] * s[5],
        r[0] * s[1] - r[1] * s[0],
        r[0] * s[3] - r[1] * s[1],
        r[0] * s[4] - r[1] * s[2],
    )


@func
def shifted_angular(b: wp.mat33, shifted: wp.mat33, r: wp.vec3) -> symmetric:
    """[r]x M^T - B [r]x: what the angular block gains by a shift of the reference point, with M = B + [r]x C."""
    x = r[0]
    y = r[1]
    z = r[2]
    m = shifted
    return symmetric(
        y * m[0, 2] - z * m[0, 1] - b[0, 1] * z + b[0, 2] * y,
        y * m[1, 2] - z * m[1, 1] + b[0, 0] * z - b[0, 2] * x,
        y * m[2, 2] - z * m[2, 1] - b[0, 0] * y + b[0, 1] * x,
        z * m[1, 0] - x * m[1, 2] + b[1, 0] * z - b[1, 2] * x,
        z * m[2, 0] - x * m[2, 2] - b[1, 0] * y + b[1, 1] * x,
        x * m[2, 1] - y * m[2, 0] - b[2, 0] * y + b[2, 1] * x,
    )


@func
def turn(q: wp.quat, angular_velocity: wp.vec3, time_step: float) -> wp.quat:
    """Orientation after one step of constant angular velocity in the body's own axes, rad/s.

    Exponential map q exp(h w / 2), to third order in h |w| and then normalised.
    """
    half = angular_velocity * (0.5 * time_step)
    s = wp.dot(half, half)
    v = half * (1.0 - s * (1.0 / 6.0))
    return wp.normalize(q * wp.quat(v[0], v[1], v[2], 1.0 - 0.5 * s))


@func
def heading(q: wp.quat) -> wp.quat:
    """The twist of an orientation about the vertical: q = heading(q) r, with r about a horizontal axis."""
    n = wp.sqrt(q[1] * q[1] + q[3] * q[3])
    if n < 1.0e-10:
        return wp.quat(0.0, 0.0, 0.0, 1.0)
    return wp.quat(0.0, q[1] / n, 0.0, q[3] / n)


@func
def turn_about_x(q: wp.quat) -> float:
    """Angle of the twist about x in a rotation, rad, -pi..pi."""
    return within_pi(2.0 * wp.atan2(q[0], q[3]))


@func
def heading_angle(q: wp.quat) -> float:
    """Angle of the heading about the vertical, rad, -pi..pi."""
    return within_pi(2.0 * wp.atan2(q[1], q[3]))


@func
def within_pi(angle: float) -> float:
    """An angle of -2 pi to 2 pi, rad, within -pi..pi."""
    if angle > wp.static(wp.PI):
        return angle - wp.static(2.0 * wp.PI)
    if angle < -wp.static(wp.PI):
        return angle + wp.static(2.0 * wp.PI)
    return angle
