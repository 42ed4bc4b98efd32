"""Metabolic power of a muscle by four published models, W.

All take the state of one muscle: activation and excitation 0..1; length of the fibre over l_opt; lengthening speed of
the fibre in m/s; force of the contractile element without its passive part, N; `iso`: active force-length multiplier;
`slow`: fraction of slow-twitch fibres; `mass`, kg; `negative_share`: how much of the work that a lengthening fibre
takes is given back, 0 (positive work) to 1 (net work). Forces are positive, and muscles shorten at negative speeds.
"""

import warp as wp

from warpmuscle.kernels.functions import func

UP, DOWN = 0.25, 1.2  # efficiencies of fibres that shorten, and that lengthen
EFFORT_POWER = 0.6  # of the activation in Umberger's heat rates
AEROBIC = 1.5  # scaling of his heat rates


@func
def fibre_work(force: float, speed: float, negative_share: float) -> float:
    """Mechanical power of the contractile element; of one that lengthens, the share that is given back."""
    power = -force * speed
    return wp.where(power < 0.0, negative_share * power, power)


@func
def recruited(level: float, slow: float) -> wp.vec2:
    """Activity of slow and fast fibres, the slow ones recruited first (Bhargava 2004, eq. 9 and 10)."""
    x = 0.5 * wp.PI * level
    return wp.vec2(slow * wp.sin(x), (1.0 - slow) * (1.0 - wp.cos(x)))


@func
def maintenance_by_length(length: float) -> float:
    """How the maintenance heat depends on the fibre length (Bhargava 2004, fig. 2): 0.5, 0.5..1, 1..0 to 1.5 l_opt."""
    if length <= 1.0:
        return wp.max(length, 0.5)
    return wp.max(3.0 - 2.0 * length, 0.0)


@func
def bhargava_power(
    activation: float, excitation: float, length: float, speed: float, force: float, iso: float, slow: float,
    mass: float, negative_share: float,
) -> float:  # fmt: skip
    """Activation, maintenance and shortening heat, and work (Bhargava 2004, eq. 1-17).

    OpenSim's probe takes the heat of shortening of the fibre's whole force, and no muscle's power as negative.
    """
    u = recruited(excitation, slow)
    heat = mass * (40.0 * u[0] + 133.0 * u[1])
    heat += mass * maintenance_by_length(length) * (74.0 * u[0] + 111.0 * u[1])
    if speed <= 0.0:
        heat -= 0.25 * force * speed
    return heat + fibre_work(force, speed, negative_share)


@func
def margaria_power(
    activation: float, excitation: float, length: float, speed: float, force: float, iso: float, slow: float,
    mass: float, negative_share: float,
) -> float:  # fmt: skip
    """Work alone: of fibres that shorten at 25 %, of those that lengthen at -120 % (Margaria 1968, of steep slopes).

    Force without work costs nothing. What lengthening costs is in it, so `negative_share` does not count.
    """
    power = -force * speed
    return wp.where(power > 0.0, power / UP, -power / DOWN)


@func
def bhargava_strict_power(
    activation: float, excitation: float, length: float, speed: float, force: float, iso: float, slow: float,
    mass: float, negative_share: float,
) -> float:  # fmt: skip
    """The same by the rules of OpenSim's probe: the heat is at least 1 W/kg, and the power is never negative."""
    work = fibre_work(force, speed, negative_share)
    heat = bhargava_power(activation, excitation, length, speed, force, iso, slow, mass, negative_share) - work
    return wp.max(wp.max(heat, mass) + work, 0.0)


@func
def wang_power(
    activation: float, excitation: float, length: float, speed: float, force: float, iso: float, slow: float,
    mass: float, negative_share: float,
) -> float:  # fmt: skip
    """Activation, maintenance and shortening heat, and work (Wang 2012, appendix, which counts positive work)."""
    u = recruited(excitation, slow)
    a = recruited(activation, slow)
    heat = mass * (40.0 * u[0] + 133.0 * u[1])
    heat += mass * maintenance_by_length(length) * (74.0 * a[0] + 111.0 * a[1])
    heat += 0.25 * force * wp.max(-speed, 0.0)
    return heat + fibre_work(force, speed, negative_share)


@func
def umberger_power(
    activation: float, excitation: float, length: float, speed: float, force: float, iso: float, slow: float,
    mass: float, negative_share: float, v_max: float, l_opt: float,
) -> float:  # fmt: skip
    """Heat of activation, maintenance, shortening and lengthening, and work (Umberger 2003, eq. 18).

    Lengthening heat is that of Umberger 2010, who counts positive work; OpenSim's probe has that of 2003, 4 in place of
    0.3, recruits fibres as Bhargava does, and takes no muscle's power as negative.

    Args:
        v_max: of fast fibres, l_opt/s; slow ones have 0.4 of it. l_opt: m. The heat is at least 1 W/kg.
    """
    a = wp.where(excitation > activation, excitation, 0.5 * (excitation + activation))
    base = 128.0 * (1.0 - slow) + 25.0
    v = speed / l_opt
    slow_rate = 250.0 / v_max
    moving = wp.float32(0.0)
    if v <= 0.0:
        moving = wp.min(-slow_rate * v, 100.0) * slow - (153.0 / v_max) * v * (1.0 - slow)
        moving *= a * a
    else:
        moving = 0.3 * slow_rate * v * a
    if length > 1.0:
        base = base * (0.4 + 0.6 * iso)
        moving = moving * iso
    heat = wp.float32(AEROBIC) * (wp.pow(a, EFFORT_POWER) * base + moving)
    return mass * wp.max(heat, 1.0) + fibre_work(force, speed, negative_share)
