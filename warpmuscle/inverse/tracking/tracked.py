"""What tracking finds of a trial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.html_table import Tabulated
from warpmuscle.inverse.simulated_ground.ground_run import GroundRun
from warpmuscle.results.recording import Recording


@dataclass(frozen=True, repr=False)
class Tracked(Tabulated):
    """A motion that a simulation makes under excitations, W windows long, of M muscles and K coordinates.

    Attributes:
        residuals: how many coordinates at the front are those of the root.
        recorded: (W + 1, K) rad or m, what was to be followed. values: (W + 1, K), what the run came to that had its
            initial state, the excitations and `effort` alone.
        effort: (W, K) N m or N, what acted beside muscles and loads: residuals at the root, moments of coordinates that
            have no muscles, and reserves if they were to act.
        lacking: (W, K) the same and all reserves, whether they acted or not.
        start: coordinates (C,) and speeds (S,) of the simulation's state at first, as `Rollout.set_initial` takes them.
        iterations: (W,) of static optimisation; -1 where it did not converge.
        ground: how the ground carried it in place of recorded forces; None: these acted.
        motion: the run, with muscles and forces on the feet, where it was asked for.
        lost: s, when its simulation diverged; windows from there on are left out. None: it did not.
    """

    muscles: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]  # (K,) rad or m
    residuals: int
    times: Floats  # (W + 1,) s, between windows
    recorded: Floats
    values: Floats
    excitation: Floats  # (W, M) 0 to 1, over windows
    activation: Floats  # (W + 1, M)
    force: Floats  # (W, M) N, along the tendon, at the end of windows
    effort: Floats
    lacking: Floats
    iterations: Integers
    start: tuple[Floats, Floats]
    lost: float | None = None
    ground: GroundRun | None = None
    motion: Recording | None = None

    @property
    def error(self) -> Floats:
        """How far the run is from the recording (W + 1, K), rad or m; turns by the shorter way."""
        away = self.values - self.recorded
        turns = np.array([unit == "rad" for unit in self.units])
        return np.where(turns, (away + np.pi) % (2.0 * np.pi) - np.pi, away)

    @property
    def rms(self) -> Floats:
        """Root mean square of the error (K,), rad or m."""
        return np.asarray(np.sqrt(np.mean(np.square(self.error), axis=0)))

    @property
    def greatest_effort(self) -> Floats:
        """Greatest absolute value (K,) of what acted beside muscles and loads, N m or N."""
        return np.asarray(np.abs(self.effort).max(axis=0, initial=0.0))
