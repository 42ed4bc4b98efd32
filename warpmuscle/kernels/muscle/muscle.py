"""Musculotendon units: pennation, rigid and compliant tendons, forces.

Lengths in m, speeds in m/s (positive when lengthening), forces of fibre and tendon over f_max unless they are said to
be in N. `width` is l_opt sin(pennation at l_opt), m: the distance of the aponeuroses, which stays constant (Millard
2013, eq. 3), so that a fibre of length l reaches sqrt(l^2 - width^2) along the tendon. `model` chooses the curves.
"""

import warp as wp

from warpmuscle.kernels.curve.curve_functions import gaussian_active, hyperbolic_velocity
from warpmuscle.kernels.curve.curves import (
    active_force_length,
    force_velocity,
    force_velocity_slope,
    passive_force_length,
    tendon_force_slope,
    tendon_force_strain,
)
from warpmuscle.kernels.curve.lee_curves import lee_passive
from warpmuscle.kernels.functions import func, gradient_of

SHORTEST_FIBRE = 0.05  # of l_opt
SMALLEST_COSINE = 0.1  # of the pennation
LARGEST_PASSIVE = 1.5  # of f_max
LARGEST_SPEED = 1.0  # of v_max
FASTEST_STRETCH = (
    10.0  # of v_max: a fibre with a compliant tendon gives way to a faster pull than that of LARGEST_SPEED
)
SMOOTHEST_SPEED = 1.0  # of v_max, beyond which a step moves a fibre by h v: it gives way to a path that jumps
UNSETTLED = -1.0  # m, of a fibre that is to come into equilibrium with its tendon in this step
FIBRE_DAMPING = 0.1  # beta of Millard 2013, of f_max at v_max
EQUILIBRIUM_STEPS = 40
SPEED_STEPS = 12
FORCE_TOLERANCE = 0.02  # of f_max
SPEED_TOLERANCE = 0.02  # of v_max
PASSIVE_STIFFNESS = 7.0  # about the slope of the passive force over itself
SLOPE_STEP = 2.0e-3  # of l_opt, to either side: the slopes of curves that gradients take
GRADIENT_SOLUTIONS = 4  # each from the one before: slopes change fast about a speed within a step's tolerances
SLACK_SLOPE = 1.0e-6  # of a tendon that just falls slack, so that its end of the fibre follows the path


@func
def bounded_fibre_length(length: float, l_opt: float, width: float) -> float:
    """The length, or the shortest that the fibre may have, m."""
    shortest = wp.max(SHORTEST_FIBRE * l_opt, width * wp.static((1.0 - SMALLEST_COSINE**2) ** -0.5))
    return wp.max(length, shortest)


@func
def along_tendon(length: float, width: float) -> float:
    """Length of the fibre along the tendon, m: l cos(pennation)."""
    if width > 0.0:
        return wp.sqrt(wp.max((length - width) * (length + width), 0.0))
    return length


@func
def pennation_cosine(length: float, width: float) -> float:
    """Cosine of the pennation of a fibre."""
    if width > 0.0:
        return along_tendon(length, width) / length
    return 1.0


@func
def rigid_fibre_length(mt_length: float, l_opt: float, l_slack: float, width: float) -> float:
    """Fibre length with a rigid tendon, m, from the length of the whole musculotendon unit."""
    reach = wp.max(mt_length - l_slack, 0.0)
    if width > 0.0:
        reach = wp.sqrt(reach * reach + width * width)
    return bounded_fibre_length(reach, l_opt, width)


@func
def rigid_fibre_speed(mt_speed: float, length: float, width: float) -> float:
    """Lengthening speed of the fibre with a rigid tendon, m/s: the unit's times the cosine of the pennation."""
    return mt_speed * pennation_cosine(length, width)


@func
def switched_fibre_length(mt_length: float, l_opt: float, l_slack: float) -> float:
    """Fibre length, m, with a tendon rigid up to l_opt and infinitely compliant beyond it (Bergmann 2017, 4.1.1)."""
    return wp.where(mt_length - l_opt < l_slack, mt_length - l_slack, l_opt)


@func
def switched_fibre_speed(mt_length: float, mt_speed: float, l_opt: float, l_slack: float) -> float:
    """Lengthening speed of the fibre of `switched_fibre_length`, m/s."""
    return wp.where(mt_length - l_opt < l_slack, mt_speed, 0.0)


@func
def legacy_force(f_max: float, activation: float, length: float, speed: float, l_opt: float) -> float:
    """Force in N as the program of Bergmann 2017 computed it: unbounded, the passive term not times f_max.

    Args:
        length: of `switched_fibre_length`, m. speed: its backward difference over a step, m/s; v_max is 10 l_opt/s.
    """
    x = length / l_opt
    active = activation * gaussian_active(x, 0.5) * hyperbolic_velocity(speed / (10.0 * l_opt), 0.3, 1.8)[0]
    return f_max * active + lee_passive(x)


@func
def bounded_passive(model: int, length: float) -> float:
    """Passive fibre force, at most LARGEST_PASSIVE, at a length over l_opt."""
    return wp.min(passive_force_length(model, length), LARGEST_PASSIVE)


@func
def fibre_force(model: int, activation: float, length: float, speed: float, damping: float) -> float:
    """Force along the fibre, never negative: a f_l f_v + f_p + damping v (Millard 2013, eq. 8).

    Args:
        length: over l_opt. speed: over v_max, taken within +-LARGEST_SPEED. damping: force at v_max over f_max.
    """
    v = wp.clamp(speed, -LARGEST_SPEED, LARGEST_SPEED)
    active = activation * active_force_length(model, length) * force_velocity(model, v, activation)
    return wp.max(active + bounded_passive(model, length) + damping * v, 0.0)


@func
def fibre_damping(model: int, activation: float, length: float, speed: float, damping: float) -> float:
    """Derivative of `fibre_force` by speed, over f_max and v_max; 0 where the force is at a bound."""
    if wp.abs(speed) > LARGEST_SPEED:
        return 0.0
    active = activation * active_force_length(model, length)
    curve = force_velocity_slope(model, speed, activation)
    if active * curve[0] + bounded_passive(model, length) + damping * speed <= 0.0:
        return 0.0
    return active * curve[1] + damping


@func
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
    return force * pennation_cosine(length, width)


@func
def tendon_strain(mt_length: float, length: float, l_slack: float, width: float) -> float:
    """Strain of the tendon of a unit whose fibre has a length."""
    return (mt_length - l_slack - along_tendon(length, width)) / l_slack


@func
def compliant_force(model: int, mt_length: float, length: float, l_slack: float, width: float) -> float:
    """Force of a unit with a compliant tendon: that of its tendon."""
    return tendon_force_strain(model, tendon_strain(mt_length, length, l_slack, width))


@func
def slopes_by_length(model: int, length: float) -> wp.vec2:
    """Derivatives of the active and of the passive force by the length over l_opt, by central differences.

    So they hold for any curve, also for those that users give; within some 1e-4 of f_max.
    """
    ahead = length + SLOPE_STEP
    behind = length - SLOPE_STEP
    active = active_force_length(model, ahead) - active_force_length(model, behind)
    passive = bounded_passive(model, ahead) - bounded_passive(model, behind)
    return wp.vec2(active, passive) / (ahead - behind)


@wp.struct
class BalanceSlopes:
    """Derivatives of the balance G of a fibre and its tendon: the fibre's force along the tendon, less the tendon's."""

    length: float  # 1/m, by the fibre's length, and so on
    mt_length: float
    l_opt: float
    l_slack: float
    width: float


@func
def balance_slopes(
    model: int, active: float, force: float, mt_length: float, length: float,
    l_opt: float, l_slack: float, width: float,
) -> BalanceSlopes:  # fmt: skip
    """The slopes at a fibre length.

    Args:
        active: what the active force at this length is multiplied with. force: of the fibre, along itself.
    """
    x = length / l_opt
    cosine = wp.max(pennation_cosine(length, width), SMALLEST_COSINE)
    by_length = slopes_by_length(model, x)
    by_x = (active * by_length[0] + by_length[1]) * cosine
    strain = tendon_strain(mt_length, length, l_slack, width)
    stiffness = wp.max(tendon_force_slope(model, strain)[1], SLACK_SLOPE) / l_slack
    turned = width / (length * cosine)  # tangent of the pennation
    g = BalanceSlopes()
    g.length = by_x / l_opt + force * turned * width / (length * length) + stiffness / cosine
    g.mt_length = -stiffness
    g.l_opt = -by_x * x / l_opt
    g.l_slack = stiffness * (1.0 + strain)
    g.width = -force * turned / length - stiffness * turned
    return g


@func
def bound_slopes(l_opt: float, width: float) -> wp.vec2:
    """Derivatives of the shortest length of a fibre, see `bounded_fibre_length`, by l_opt and by the width."""
    by_width = wp.static((1.0 - SMALLEST_COSINE**2) ** -0.5)
    if width * by_width > SHORTEST_FIBRE * l_opt:
        return wp.vec2(0.0, by_width)
    return wp.vec2(SHORTEST_FIBRE, 0.0)


@func
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


@gradient_of(fibre_equilibrium)
def fibre_equilibrium_gradient(
    model: int, activation: float, mt_length: float, l_opt: float, l_slack: float, width: float, adj_ret: float
):
    """Derivatives by the implicit function theorem, dl/dp = -(dG/dp)/(dG/dl); those of the bound where it is reached.

    A reverse sweep through the bisection would find 0, since its halves do not depend on anything.
    """
    length = fibre_equilibrium(model, activation, mt_length, l_opt, l_slack, width)
    if length <= bounded_fibre_length(0.0, l_opt, width) * 1.00001:
        bound = bound_slopes(l_opt, width)
        wp.adjoint[l_opt] += bound[0] * adj_ret
        wp.adjoint[width] += bound[1] * adj_ret
    else:
        x = length / l_opt
        multiplier = force_velocity(model, 0.0, activation)
        full = active_force_length(model, x) * multiplier
        force = activation * full + bounded_passive(model, x)
        g = balance_slopes(model, activation * multiplier, force, mt_length, length, l_opt, l_slack, width)
        share = -adj_ret / g.length
        wp.adjoint[activation] += full * pennation_cosine(length, width) * share
        wp.adjoint[mt_length] += g.mt_length * share
        wp.adjoint[l_opt] += g.l_opt * share
        wp.adjoint[l_slack] += g.l_slack * share
        wp.adjoint[width] += g.width * share


@func
def stepped_length(start: float, reach: float, v: float) -> float:
    """Fibre length, m, after a step in which its speed is v, of v_max: see `compliant_step`."""
    return start + reach * (v + 0.5 * (v - wp.clamp(v, -SMOOTHEST_SPEED, SMOOTHEST_SPEED)))


@func
def equilibrium_speed(
    model: int, activation: float, mt_length: float, start: float, reach: float, guess: float,
    l_opt: float, l_slack: float, width: float, damping: float,
) -> float:  # fmt: skip
    """Speed v of the fibre over v_max, -LARGEST_SPEED..FASTEST_STRETCH, with which fibre and tendon are in equilibrium.

    It solves, with the fibre length l = start + reach v, where |v| is at most SMOOTHEST_SPEED (see `compliant_step`),

        (a f_l(l) f_v(v) + f_p(l) + damping v) cos(pennation) = f_t(l)      (Millard 2013, eq. 8)

    The left side minus the right, the excess, increases with v, so Newton's method within a shrinking bracket finds
    it. A step from a small excess is the last, if small itself: where a slack tendon becomes taut it may be far off.

    Args:
        mt_length: of the whole unit, m. reach: m. guess: of v, within its range. damping: as in `fibre_force`.
    """
    low = wp.float32(-2.0 * LARGEST_SPEED)
    high = wp.float32(2.0 * FASTEST_STRETCH)
    v = wp.float32(guess)
    per_optimum = 1.0 / l_opt
    per_slack = 1.0 / l_slack
    for _ in range(SPEED_STEPS):
        length = bounded_fibre_length(stepped_length(start, reach, v), l_opt, width)
        x = length * per_optimum
        cosine = wp.max(pennation_cosine(length, width), SMALLEST_COSINE)
        active = activation * active_force_length(model, x)
        passive = bounded_passive(model, x)
        strain = (mt_length - l_slack - along_tendon(length, width)) * per_slack
        tendon = tendon_force_slope(model, strain)
        fibre = force_velocity_slope(model, v, activation)
        excess = (active * fibre[0] + passive + damping * v) * cosine - tendon[0]
        if excess > 0.0:
            high = v
        else:
            low = v
        stiffness = PASSIVE_STIFFNESS * passive * cosine * per_optimum + tendon[1] * per_slack / cosine
        way = wp.where(wp.abs(v) > SMOOTHEST_SPEED, 1.5 * reach, reach)
        slope = (active * fibre[1] + damping) * cosine + stiffness * way
        better = wp.clamp(v - excess / wp.max(slope, 1.0e-6), -LARGEST_SPEED, FASTEST_STRETCH)
        change = wp.abs(better - v)
        if (wp.abs(excess) < FORCE_TOLERANCE and change < SPEED_TOLERANCE) or change == 0.0:
            return better
        v = wp.where(better > low and better < high, better, 0.5 * (low + high))
    return v


@gradient_of(equilibrium_speed)
def equilibrium_speed_gradient(
    model: int, activation: float, mt_length: float, start: float, reach: float, guess: float,
    l_opt: float, l_slack: float, width: float, damping: float, adj_ret: float,
):  # fmt: skip
    """Derivatives by the implicit function theorem, as of `fibre_equilibrium`; 0 at a bound, and by the guess."""
    v = wp.float32(guess)
    for _ in range(GRADIENT_SOLUTIONS):
        v = equilibrium_speed(model, activation, mt_length, start, reach, v, l_opt, l_slack, width, damping)
    if v > -LARGEST_SPEED and v < FASTEST_STRETCH:
        free = stepped_length(start, reach, v)
        way = wp.where(wp.abs(v) > SMOOTHEST_SPEED, 1.5 * reach, reach)
        length = bounded_fibre_length(free, l_opt, width)
        x = length / l_opt
        cosine = wp.max(pennation_cosine(length, width), SMALLEST_COSINE)
        fibre = force_velocity_slope(model, v, activation)
        level = wp.max(activation, SLOPE_STEP)
        rise = force_velocity(model, v, level + SLOPE_STEP) - force_velocity(model, v, level - SLOPE_STEP)
        full = active_force_length(model, x)
        force = activation * full * fibre[0] + bounded_passive(model, x) + damping * v
        g = balance_slopes(model, activation * fibre[0], force, mt_length, length, l_opt, l_slack, width)
        along = wp.vec2(g.length, 0.0)  # by the length that is free, and by that of the bound
        if length > free:
            along = wp.vec2(0.0, g.length)
        share = -adj_ret / ((activation * full * fibre[1] + damping) * cosine + along[0] * way)
        bound = bound_slopes(l_opt, width) * along[1]
        by_activation = fibre[0] + activation * rise / wp.static(2.0 * SLOPE_STEP)
        wp.adjoint[activation] += full * by_activation * cosine * share
        wp.adjoint[mt_length] += g.mt_length * share
        wp.adjoint[start] += along[0] * share
        wp.adjoint[reach] += along[0] * (free - start) / reach * share
        wp.adjoint[l_opt] += (g.l_opt + bound[0]) * share
        wp.adjoint[l_slack] += g.l_slack * share
        wp.adjoint[width] += (g.width + bound[1]) * share
        wp.adjoint[damping] += v * cosine * share


@func
def compliant_step(
    model: int, activation: float, mt_length: float, length: float, previous_length: float,
    l_opt: float, l_slack: float, width: float, v_max: float, damping: float, time_step: float,
) -> float:  # fmt: skip
    """Fibre length, m, after a step in which fibre and tendon come to equilibrium at its end.

    The backward differentiation formula of second order, stable however stiff the tendon (Curtiss 1952):

        l_{n+1} = 4/3 l_n - 1/3 l_{n-1} + 2/3 h v_{n+1}

    Of this speed, what is beyond SMOOTHEST_SPEED counts whole in place of 2/3, and not in the next step: where a path
    jumps, steps together move the fibre by the sum of h v, so that damping takes up the impulse that it should,
    however long they are.

    Args:
        mt_length: of the whole unit at the end of the step. length, previous_length: of the fibre at the start of this
            step and of the one before; equal in the first step. v_max: l_opt/s. damping: as in `fibre_force`.
        time_step: h, s.
    """
    whole = time_step * v_max * l_opt
    moved = length - previous_length
    start = length + wp.clamp(moved, -whole, whole) / 3.0  # what gave way to a sudden pull does not swing on
    reach = 2.0 / 3.0 * whole
    guess = wp.clamp(moved / whole, -LARGEST_SPEED, FASTEST_STRETCH)
    v = equilibrium_speed(model, activation, mt_length, start, reach, guess, l_opt, l_slack, width, damping)
    return bounded_fibre_length(stepped_length(start, reach, v), l_opt, width)
