"""Metabolic power of muscles by the published formulas, in float64."""

import numpy as np


def recruited(level: np.ndarray, slow: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return slow * np.sin(np.pi / 2 * level), (1.0 - slow) * (1.0 - np.cos(np.pi / 2 * level))


def maintenance(length: np.ndarray) -> np.ndarray:
    return np.interp(length, [0.5, 1.0, 1.5], [0.5, 1.0, 0.0])


def work(speed: np.ndarray, force: np.ndarray, net: bool) -> np.ndarray:
    """Power of the contractile element: -F v, of which positive work has only the part of shortening fibres."""
    return -force * speed if net else np.maximum(-force * speed, 0.0)


def bhargava(activation, excitation, length, speed, force, iso, slow, mass, net) -> np.ndarray:
    """Bhargava 2004, eq. 1-17: heats of activation, maintenance, shortening, and work."""
    u_slow, u_fast = recruited(excitation, slow)
    heat = mass * (40.0 * u_slow + 133.0 * u_fast + maintenance(length) * (74.0 * u_slow + 111.0 * u_fast))
    return heat + np.where(speed <= 0.0, -0.25 * force * speed, 0.0) + work(speed, force, net)


def wang(activation, excitation, length, speed, force, iso, slow, mass, net) -> np.ndarray:
    """Wang 2012, appendix: maintenance by the activation, no heat of lengthening."""
    u_slow, u_fast = recruited(excitation, slow)
    a_slow, a_fast = recruited(activation, slow)
    heat = mass * (40.0 * u_slow + 133.0 * u_fast + maintenance(length) * (74.0 * a_slow + 111.0 * a_fast))
    return heat + np.where(speed < 0.0, -0.25 * force * speed, 0.0) + work(speed, force, net)


def margaria(activation, excitation, length, speed, force, iso, slow, mass, net) -> np.ndarray:
    """Margaria 1968 (Int Z angew Physiol 25:339): work at 25 % and -120 %, whatever else is counted."""
    return np.where(speed < 0.0, -force * speed / 0.25, force * speed / 1.2)


def umberger(activation, excitation, length, speed, force, iso, slow, mass, net, v_max, l_opt) -> np.ndarray:
    """Umberger 2003, eq. 18, with the lengthening heat of Umberger 2010."""
    a = np.where(excitation > activation, excitation, (excitation + activation) / 2)
    v = speed / l_opt
    kept = np.where(length <= 1.0, 1.0, 0.4 + 0.6 * iso)
    activation_maintenance = 1.5 * a**0.6 * (128.0 * (1.0 - slow) + 25.0) * kept
    alpha_slow, alpha_fast = 100.0 / (v_max / 2.5), 153.0 / v_max
    shortening = np.minimum(-alpha_slow * v, 100.0) * slow - alpha_fast * v * (1.0 - slow)
    moving = np.where(v <= 0.0, 1.5 * a**2 * shortening, 1.5 * a * 0.3 * alpha_slow * v)
    moving = np.where(length <= 1.0, moving, moving * iso)
    return mass * np.maximum(activation_maintenance + moving, 1.0) + work(speed, force, net)
