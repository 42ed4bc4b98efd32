"""Musculotendon units: pennation, rigid and compliant tendons, forces.

Lengths in m, speeds in m/s (positive when lengthening), forces of fibre and tendon over f_max unless they are said to
be in N. `width` is l_opt sin(pennation at l_opt), m: the distance of the aponeuroses, which stays constant (Millard
2013, eq. 3), so that a fibre of length l reaches sqrt(l^2 - width^2) along the tendon. `model` chooses the curves.
"""

import warp as wp

from warpmuscle.kernels.curves import (
    active_force_length,
    exponential_passive,
    force_velocity,
    force_velocity_slope,
    gaussian_active,
    hyperbolic_velocity,
    passive_force_length,
    tendon_force_slope,
    tendon_force_strain,
)

SHORTEST_FIBRE = 0.05  # of l_opt
SMALLEST_COSINE = 0.1  # of the pennation
LARGEST_PASSIVE = 1.5  # of f_max
LARGEST_SPEED = 1.0  # of v_max
FIBRE_DAMPING = 0.1  # beta of Millard 2013, of f_max at v_max
EQUILIBRIUM_STEPS = 40
SPEED_STEPS = 16
FORCE_TOLERANCE = 2.0e-6  # of f_max
STAGE = 1.0 - 0.5**0.5  # of a step


@wp.func
def bounded_fibre_length(length: float, l_opt: float, width: float) -> float:
    """The length, or the shortest that the fibre may have, m."""
    shortest = wp.max(SHORTEST_FIBRE * l_opt, width * wp.static((1.0 - SMALLEST_COSINE**2) ** -0.5))
    return wp.max(length, shortest)


@wp.func
def along_tendon(length: float, width: float) -> float:
    """Length of the fibre along the tendon, m: l cos(pennation)."""
    return wp.sqrt(wp.max((length - width) * (length + width), 0.0))


@wp.func
def rigid_fibre_length(mt_length: float, l_opt: float, l_slack: float, width: float) -> float:
    """Fibre length with a rigid tendon, m, from the length of the whole musculotendon unit."""
    reach = wp.max(mt_length - l_slack, 0.0)
    return bounded_fibre_length(wp.sqrt(reach * reach + width * width), l_opt, width)


@wp.func
def rigid_fibre_speed(mt_speed: float, length: float, width: float) -> float:
    """Lengthening speed of the fibre with a rigid tendon, m/s: the unit's times the cosine of the pennation."""
    return mt_speed * along_tendon(length, width) / length


@wp.func
def switched_fibre_length(mt_length: float, l_opt: float, l_slack: float) -> float:
    """Fibre length, m, with a tendon rigid up to l_opt and infinitely compliant beyond it (Bergmann 2017, 4.1.1)."""
    return wp.where(mt_length - l_opt < l_slack, mt_length - l_slack, l_opt)


@wp.func
def switched_fibre_speed(mt_length: float, mt_speed: float, l_opt: float, l_slack: float) -> float:
    """Lengthening speed of the fibre of `switched_fibre_length`, m/s."""
    return wp.where(mt_length - l_opt < l_slack, mt_speed, 0.0)


@wp.func
def legacy_force(f_max: float, activation: float, length: float, speed: float, l_opt: float) -> float:
    """Force in N as the program of Bergmann 2017 computed it: unbounded, the passive term not times f_max.

    Args:
        length: of `switched_fibre_length`, m. speed: its backward difference over a step, m/s; v_max is 10 l_opt/s.
    """
    x = length / l_opt
    active = activation * gaussian_active(x, 0.5) * hyperbolic_velocity(speed / (10.0 * l_opt), 0.3, 1.8)[0]
    return f_max * active + exponential_passive(x, 4.0)


@wp.func
def bounded_passive(model: int, length: float) -> float:
    """Passive fibre force, at most LARGEST_PASSIVE, at a length over l_opt."""
    return wp.min(passive_force_length(model, length), LARGEST_PASSIVE)


@wp.func
def fibre_force(model: int, activation: float, length: float, speed: float, damping: float) -> float:
    """Force along the fibre, never negative: a f_l f_v + f_p + damping v (Millard 2013, eq. 8).

    Args:
        length: over l_opt. speed: over v_max, taken within +-LARGEST_SPEED. damping: force at v_max over f_max.
    """
    v = wp.clamp(speed, -LARGEST_SPEED, LARGEST_SPEED)
    active = activation * active_force_length(model, length) * force_velocity(model, v, activation)
    return wp.max(active + bounded_passive(model, length) + damping * v, 0.0)


@wp.func
def rigid_force(
    model: int, activation: float, mt_length: float, mt_speed: float,
    l_opt: float, l_slack: float, width: float, v_max: float, damping: float,
) -> float:  # fmt: skip
    """Force of a unit with a rigid tendon.

    Args:
        mt_length, mt_speed: of the whole unit. v_max: l_opt/s.
    """
    length = rigid_fibre_length(mt_length, l_opt, l_slack, width)
    speed = rigid_fibre_speed(mt_speed, length, width)
    force = fibre_force(model, activation, length / l_opt, speed / (v_max * l_opt), damping)
    return force * along_tendon(length, width) / length


@wp.func
def tendon_strain(mt_length: float, length: float, l_slack: float, width: float) -> float:
    """Strain of the tendon of a unit whose fibre has a length."""
    return (mt_length - l_slack - along_tendon(length, width)) / l_slack


@wp.func
def compliant_force(model: int, mt_length: float, length: float, l_slack: float, width: float) -> float:
    """Force of a unit with a compliant tendon: that of its tendon."""
    return tendon_force_strain(model, tendon_strain(mt_length, length, l_slack, width))


@wp.func
def fibre_equilibrium(
    model: int, activation: float, mt_length: float, l_opt: float, l_slack: float, width: float
) -> float:
    """Fibre length, m, at which fibre and tendon are in equilibrium at rest, by bisection.

    Of several, as are possible where the active force falls with length, it finds one. The shortest fibre if the unit
    is too short for any force.
    """
    low = bounded_fibre_length(0.0, l_opt, width)
    high = rigid_fibre_length(mt_length, l_opt, l_slack, width)
    for _ in range(EQUILIBRIUM_STEPS):
        middle = 0.5 * (low + high)
        cosine = along_tendon(middle, width) / middle
        pull = fibre_force(model, activation, middle / l_opt, 0.0, 0.0) * cosine
        if compliant_force(model, mt_length, middle, l_slack, width) > pull:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@wp.func
def equilibrium_speed(
    model: int, activation: float, mt_length: float, start: float, reach: float,
    l_opt: float, l_slack: float, width: float, damping: float,
) -> float:  # fmt: skip
    """Speed v of the fibre over v_max, within +-LARGEST_SPEED, with which fibre and tendon are in equilibrium.

    It solves, with the fibre length l = start + reach v,

        (a f_l(l) f_v(v) + f_p(l) + damping v) cos(pennation) = f_t(l)      (Millard 2013, eq. 8)

    The left side minus the right increases with v, so Newton's method within a shrinking bracket finds it.

    Args:
        mt_length: of the whole unit, m. reach: m. damping: as in `fibre_force`.
    """
    high = wp.float32(LARGEST_SPEED)
    low = -high
    v = wp.float32(0.0)
    for _ in range(SPEED_STEPS):
        length = bounded_fibre_length(start + reach * v, l_opt, width)
        x = length / l_opt
        cosine = wp.max(along_tendon(length, width) / length, SMALLEST_COSINE)
        active = activation * active_force_length(model, x)
        tendon = tendon_force_slope(model, tendon_strain(mt_length, length, l_slack, width))
        fibre = force_velocity_slope(model, v, activation)
        excess = (active * fibre[0] + bounded_passive(model, x) + damping * v) * cosine - tendon[0]
        if wp.abs(excess) < FORCE_TOLERANCE:
            return v
        if excess > 0.0:
            high = v
        else:
            low = v
        slope = (active * fibre[1] + damping) * cosine + tendon[1] * reach / (cosine * l_slack)
        v = v - excess / wp.max(slope, 1.0e-6)
        if not (v > low and v < high):
            v = 0.5 * (low + high)
    return v


@wp.func
def compliant_step(
    model: int, activation: float, mt_length: float, mt_speed: float, length: float,
    l_opt: float, l_slack: float, width: float, v_max: float, damping: float, time_step: float,
) -> float:  # fmt: skip
    """Fibre length, m, after a step in which fibre and tendon stay in equilibrium.

    Two implicit stages of second order, stable however stiff the tendon (Alexander 1977, SDIRK2).

    Args:
        mt_length, mt_speed: of the whole unit at the end of the step. length: of the fibre at its start.
        v_max: l_opt/s. damping: as in `fibre_force`. time_step: h, s.
    """
    whole = time_step * v_max * l_opt
    reach = STAGE * whole
    between = mt_length - (1.0 - STAGE) * time_step * mt_speed
    first = equilibrium_speed(model, activation, between, length, reach, l_opt, l_slack, width, damping)
    start = length + (whole - reach) * first
    second = equilibrium_speed(model, activation, mt_length, start, reach, l_opt, l_slack, width, damping)
    return bounded_fibre_length(start + reach * second, l_opt, width)
