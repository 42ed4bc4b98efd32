"""Activation dynamics as a discrete filter, exact for excitations that are constant between samples.

Cruz Ruiz et al. 2015, eq. 11 with equal constants of activation and deactivation is linear,

    C(p) / U(p) = 1 / ((1 + tau_act p) (1 + tau_ne p))                                           (eq. 14)

and so has an exact discretisation under a zero-order hold,

    (b1 z + b0) / (z^2 + a1 z + a0)                                                              (eq. 15)

With the sampling period T, A = exp(-T / tau_ne) and B = exp(-T / tau_act), the unit step's response

    y(t) = 1 - (tau_act exp(-t / tau_act) - tau_ne exp(-t / tau_ne)) / (tau_act - tau_ne)

gives b1 = y(T), the poles give a1 = -(A + B) and a0 = A B, and y(2 T) = b1 + b0 - a1 b1 gives b0:

    b1 = 1 - (tau_act B - tau_ne A) / (tau_act - tau_ne)
    b0 = A B - (tau_act A - tau_ne B) / (tau_act - tau_ne)

b0 + b1 = (1 - A) (1 - B) = 1 + a1 + a0, so the static gain is 1 and needs no correction (eq. 17).

The paper prints the same a1, a0 and b1, but b0 = A B - (A - B) / (tau_act - tau_ne): the two time constants before A
and B are missing, and a term in 1/s is subtracted from a number. With its 50 ms and 1 ms that b0 is 16.7 in place of
0.0167 at T = 10 ms, and the static gain 93 (1028 at T = 1 ms). Dividing by that gain repairs the gain but not the
shape: next to nothing is left of b1, so that the response comes almost a sample late. Its mean delay is 65.1 ms at
T = 10 ms, not 56.1 ms, and its step response is up to 0.163 too low; at T = 1 ms 52.1 ms, not 51.5 ms, and 0.011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import lfilter

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error

TAU_NE, TAU_ACT = 0.001, 0.05  # s, of the paper


@dataclass(frozen=True)
class ActivationFilter:
    """c(k) = -a1 c(k-1) - a0 c(k-2) + b1 u(k-1) + b0 u(k-2)."""

    b1: float
    b0: float
    a1: float
    a0: float

    @classmethod
    def of(cls, period: float, tau_act: float = TAU_ACT, tau_ne: float = TAU_NE) -> ActivationFilter:
        """The exact filter for a sampling period, s, and two time constants, s.

        The constants may be equal, and one of them may be 0. The difference quotient of the exponentials is taken by
        `expm1`, so that constants which nearly agree lose no digits.

        Raises:
            Error: the period or both constants are not greater than 0, or one of them is negative or not finite.
        """
        slow, fast = max(tau_act, tau_ne), min(tau_act, tau_ne)
        if not (np.isfinite([period, slow, fast]).all() and period > 0.0 and slow > 0.0 and fast >= 0.0):
            raise Error(
                f"an activation filter needs a period and a time constant greater than 0 and another not below 0, "
                f"not {period:g} s, {tau_act:g} s and {tau_ne:g} s"
            )
        decay_slow = np.exp(-period / slow)
        decay_fast = np.exp(-period / fast) if fast > 0.0 else 0.0
        # share = fast (decay_slow - decay_fast) / (slow - fast), also in the limits fast = slow and fast = 0
        share = 0.0
        if fast > 0.0:
            difference = period * (slow - fast) / (slow * fast)
            quotient = -np.expm1(-difference) / difference if difference > 0.0 else 1.0
            share = decay_slow * quotient * period / slow
        b1 = -np.expm1(-period / slow) - share
        b0 = decay_fast * (decay_slow - 1.0) + share
        return cls(float(b1), float(b0), float(-(decay_fast + decay_slow)), float(decay_fast * decay_slow))

    @property
    def static_gain(self) -> float:
        """What a constant excitation of 1 leads to."""
        return (self.b1 + self.b0) / (1.0 + self.a1 + self.a0)

    def apply(self, excitation: ArrayLike, settled: bool = False) -> Floats:
        """Activations (..., T) for excitations (..., T), sampled at the filter's period (eq. 16).

        Args:
            settled: begin as if the first excitation had lasted for ever, rather than at rest.
        """
        u = np.asarray(excitation, np.float64)
        first = u[..., :1] if settled else 0.0  # subtracted and added again, as the static gain is 1
        return np.asarray(lfilter([0.0, self.b1, self.b0], [1.0, self.a1, self.a0], u - first, axis=-1) + first)
