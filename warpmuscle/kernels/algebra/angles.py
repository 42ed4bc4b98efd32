"""Sine, cosine and arcsine as short polynomials, and the rotation between two orientations.

On the CPU they save calls into the mathematics library, on the GPU its slow paths. Errors are those of single
precision: 1.5e-7 absolute for sine and cosine within +-1000 rad, 5e-7 relative for the arcsine ratio.
"""

import warp as wp

from warpmuscle.kernels.functions import func


@func
def sine_cosine(x: float) -> wp.vec2:
    """sin x and cos x: reduction to +-pi/4 in three parts (Cody and Waite 1980), minimax polynomials."""
    k = wp.floor(x * wp.static(2.0 / wp.PI) + 0.5)
    r = ((x - k * 1.5703125) - k * 4.837512969970703125e-4) - k * 7.549789948768648e-8
    z = r * r
    s = r + r * z * (-0.16666665 + z * (0.00833275 - z * 0.00019588))
    c = 1.0 - 0.5 * z + z * z * (0.0416666646 + z * (-0.00138882965 + z * 2.45471008e-5))
    quadrant = int(k)
    odd = (quadrant & 1) != 0
    sine = wp.where(odd, c, s)
    cosine = wp.where(odd, s, c)
    return wp.vec2(wp.where((quadrant & 2) != 0, -sine, sine), wp.where(((quadrant + 1) & 2) != 0, -cosine, cosine))


@func
def arcsine_ratio(square: float) -> float:
    """asin(x)/x from x^2, 0..1: a polynomial up to x = 1/2, beyond it asin x = pi/2 - 2 asin(sqrt((1 - x)/2))."""
    if square <= 0.25:
        return arcsine_ratio_small(square)
    x = wp.min(wp.sqrt(square), 1.0)
    z = 0.5 * wp.max(1.0 - square, 0.0) / (1.0 + x)
    return (wp.static(0.5 * wp.PI) - 2.0 * wp.sqrt(z) * arcsine_ratio_small(z)) / x


@func
def arcsine_ratio_small(z: float) -> float:
    """asin(x)/x for z = x^2 up to 1/4."""
    p = 0.03188414 + z * (0.01419883 + z * 0.03780636)
    return 1.0 + z * (0.16666657 + z * (0.07500592 + z * (0.04450524 + z * p)))


@func
def pd_error(orientation: wp.quat, target: wp.quat) -> wp.vec3:
    """Rotation from the orientation to the target along the child's axes, as axis times angle (up to pi), rad."""
    e = wp.quat_inverse(orientation) * target
    v = wp.vec3(e[0], e[1], e[2])
    factor = 2.0 * arcsine_ratio(wp.dot(v, v))
    if e[3] < 0.0:
        factor = -factor
    return v * factor
