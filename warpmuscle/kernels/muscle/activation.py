"""Excitation to activation: neural delay and activation dynamics.

Activations and excitations are 0..1; times are in seconds, rates in 1/s.
"""

import warp as wp

from warpmuscle.kernels.functions import func

THELEN_TIMES = (0.015, 0.05)  # activation and deactivation time constants, s, of OpenSim's Thelen2003Muscle
STEEPNESS = 0.1  # of OpenSim's DeGrooteFregly2016Muscle
MILLARD_TIMES = (0.01, 0.04)  # the same of its Millard2012EquilibriumMuscle


@func
def activation_step(activation: float, excitation: float, rate: float, time_step: float) -> float:
    """Activation after one step of a' = rate (u - a), forward Euler (Bergmann 2017, eq. 10), kept within 0..1.

    Args:
        rate: of activation and deactivation, 1/s (100 in the source). Stable for rate * time_step <= 1.
    """
    return wp.clamp(activation + rate * time_step * (excitation - activation), 0.0, 1.0)


@func
def activation_rate(activation: float, excitation: float, rise_time: float, fall_time: float) -> float:
    """Rate 1/tau of a' = (u - a)/tau, 1/s (Thelen 2003, eq. 1 and 2; Millard 2013 takes the same with other constants).

    Args:
        rise_time: time constant of activation, s. fall_time: of deactivation, s.
    """
    scale = 0.5 + 1.5 * activation
    return wp.where(excitation > activation, 1.0 / (rise_time * scale), scale / fall_time)


@func
def smoothed_rate(activation: float, excitation: float, rise_time: float, fall_time: float, smoothing: float) -> float:
    """The same with a time constant that goes smoothly from one to the other, 1/s, as MuJoCo has it (`tausmooth`).

    tau = tau_fall + (tau_rise - tau_fall) s((u - a)/w + 1/2), with s(x) = x^3 (6 x^2 - 15 x + 10) within 0..1.

    Args:
        smoothing: w, the interval of u - a over which it changes, above 0.
    """
    scale = 0.5 + 1.5 * activation
    x = wp.clamp((excitation - activation) / smoothing + 0.5, 0.0, 1.0)
    part = x * x * x * (x * (6.0 * x - 15.0) + 10.0)
    return 1.0 / wp.lerp(fall_time / scale, rise_time * scale, part)


@func
def blended_rate(activation: float, excitation: float, rise_time: float, fall_time: float) -> float:
    """The rate of De Groote 2016 (eq. 1), 1/s, with the steepness b that OpenSim's DeGrooteFregly2016Muscle has.

    1/tau = (1/2 + f)/(tau_rise z) + (1/2 - f) z/tau_fall with z = 1/2 + 3/2 a, f = tanh(b (u - a))/2. The article's b
    is 10, with which the rate goes from one to the other; OpenSim's, 0.1, leaves nearly the mean of both.
    """
    scale = 0.5 + 1.5 * activation
    f = 0.5 * wp.tanh(STEEPNESS * (excitation - activation))
    return (0.5 + f) / (rise_time * scale) + (0.5 - f) * scale / fall_time


@func
def excited_rate(excitation: float, rise_time: float, fall_time: float) -> float:
    """Rate c1 u + c2 of a' = (c1 u + c2)(u - a), 1/s: 1/rise_time at full excitation, 1/fall_time at none.

    As in the integrators of Hyfydy (its User Manual 1.0.2, muscle activation dynamics).
    """
    return excitation / rise_time + (1.0 - excitation) / fall_time


@func
def excited_rise_rate(activation: float, excitation: float, rise_time: float, fall_time: float) -> float:
    """The same while the activation rises, and c2 while it falls, 1/s: OpenSim's Schutte1993Muscle_Deprecated."""
    return excited_rate(wp.where(excitation >= activation, excitation, 0.0), rise_time, fall_time)


@func
def activation_relaxed(activation: float, excitation: float, rate: float, time_step: float) -> float:
    """Activation after one step of a' = rate (u - a) at constant rate: exact, so stable for steps of any length."""
    return excitation + (activation - excitation) * wp.exp(-rate * time_step)


@func
def neural_step(activation: float, neural: float, excitation: float, rest: float, neural_rest: float, mix: float):
    """Activation a and neural signal e after a step of e' = (u - e)/tau_ne, a' = (e - a)/tau (Cruz Ruiz 2015, eq. 11).

    Exact for an excitation u that does not change within the step:

        a = u + (a - u) A + (e - u) tau_ne/(tau_ne - tau) (E - A),    A = exp(-h/tau), E = exp(-h/tau_ne)

    Args:
        rest: A. neural_rest: E. mix: tau_ne/(tau_ne - tau) (E - A).
    """
    a = excitation + (activation - excitation) * rest + (neural - excitation) * mix
    return wp.vec2(a, excitation + (neural - excitation) * neural_rest)


@func
def delayed_slot(step: int, delay_steps: int, capacity: int) -> int:
    """Slot of a ring buffer that was written `delay_steps` steps ago.

    The first value ever written stands for the time before it: until the delay has passed, that is slot 0.

    Args:
        capacity: of the ring, a power of two greater than the delay; step s is written to slot s & (capacity - 1).
    """
    return wp.max(step - delay_steps, 0) & (capacity - 1)
