"""What gaits withstand, as a table: pushes of several impulses, and slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.plain_text import rounded
from warpmuscle.results.records import installed_versions
from warpmuscle.studies.robustness import PushTrials, SlopeTrial, push_trials, slope_trials
from warpmuscle.studies.walkers import Walker


@dataclass(frozen=True)
class Trials:
    """How a gait came through pushes and slopes."""

    name: str
    pushes: PushTrials
    slopes: list[SlopeTrial]


def tried(
    name: str, walker: Walker, impulses: Sequence[float], pushes: int, seed: int, slope: float, duration: float
) -> Trials:  # fmt: skip
    """Push a gait, and let it walk up and down.

    Args:
        impulses: N s. pushes: at each of them. slope: degrees. duration: s, on a slope.

    Raises:
        Error: no pushes, or an impulse that is not a positive number.
    """
    inclines = np.radians([-slope, slope]).tolist()
    walked = slope_trials(walker, inclines, duration)  # first, so that a duration that cannot be costs no pushes
    return Trials(name, push_trials(walker, impulses, pushes, seed=seed), walked)


def table(trials: Sequence[Trials], slope: float, duration: float) -> list[tuple[str, ...]]:
    """A row a gait: the impulse that half of the pushes leave upright, the share at each, speeds on slopes."""
    levels = " ".join(f"{level:g}" for level in trials[0].pushes.impulses[1:])
    slopes = (f"{sign * slope:+g} deg, {duration:g} s" for sign in (-1, 1))
    head = ("", "half survive, N s", "5 to 95 %", f"survive {levels} N s, %", *slopes)
    return [head, *(_row(one) for one in trials)]


def _row(trials: Trials) -> tuple[str, ...]:
    survived = " ".join(f"{100.0 * part:.0f}" for part in trials.pushes.survived.mean(axis=1)[1:])
    return (trials.name, *_push_cells(trials.pushes), survived, *(_slope_cell(trial) for trial in trials.slopes))


def _push_cells(trials: PushTrials) -> tuple[str, str]:
    """The impulse that half survive, and its range, as words."""
    greatest = float(trials.impulses[-1])
    if trials.half == 0.0:
        return "falls without a push", ""
    low, high = ("more" if np.isinf(end) else f"{end:.0f}" for end in trials.range)
    return f"more than {greatest:g}" if np.isinf(trials.half) else f"{trials.half:.0f}", f"{low} to {high}"


def _slope_cell(trial: SlopeTrial) -> str:
    """How it went on a slope, as words."""
    return f"{rounded(trial.speed, 2)} m/s" if trial.survived else f"falls at {trial.end_time:.1f} s"


def numbers(trials: Sequence[Trials], seed: int) -> dict[str, Any]:
    """All numbers; what is infinite is None."""
    return {"versions": installed_versions(), "seed": seed, "gaits": [_numbers(one) for one in trials]}


def _numbers(trials: Trials) -> dict[str, Any]:
    pushes = trials.pushes
    half, low, high = (None if np.isinf(value) else float(value) for value in (pushes.half, *pushes.range))
    return {
        "name": trials.name,
        "half_impulse": half,
        "half_impulse_range": [low, high],
        "impulses": pushes.impulses.tolist(),
        "survived": pushes.survived.sum(axis=1).tolist(),
        "pushes": pushes.survived.shape[1],
        "slopes": [
            {"slope_deg": float(np.degrees(trial.slope)), "survived": trial.survived, "end_time": trial.end_time,
             "speed": trial.speed}
            for trial in trials.slopes
        ],
    }  # fmt: skip
