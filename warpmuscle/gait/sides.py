"""Left and right beside each other: steps, stance, forces, angles, moments, powers, and how active muscles are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.gait.curves import FORWARDS, Curves, gait_curves, mean_of
from warpmuscle.gait.cycles import PERCENT, Strides, body_weight, over_strides, steady_strides
from warpmuscle.gait.foot_contact import SIDES, contacts_of
from warpmuscle.gait.measures import feet_of, measure, steps_of
from warpmuscle.gait.muscle_timing import side_and_muscle
from warpmuscle.gait.profile_score import profile_scores, variable_scores
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.norms import FORCE

SMALL = 1.0  # deg, of angles
PROFILE = "gait profile score"  # from people who walk
# Greatest values of curves, times a sign, between two percents of the cycle.
_GREATEST = {
    "maximum vertical force": (FORCE, 1.0, 0, 100),
    "maximum braking force": (FORWARDS, -1.0, 0, 100),
    "maximum driving force": (FORWARDS, 1.0, 0, 100),
    "hip, maximum extension": ("Hip flexion", -1.0, 20, 80),
    "knee, maximum in stance": ("Knee flexion", 1.0, 2, 45),
    "knee, maximum in swing": ("Knee flexion", 1.0, 45, 100),
    "ankle, maximum dorsiflexion in stance": ("Ankle dorsiflexion", 1.0, 8, 62),
    "hip extension moment, maximum": ("Hip moment", 1.0, 0, 50),
    "knee extension moment in loading, maximum": ("Knee moment", 1.0, 5, 30),
    "ankle moment, maximum": ("Ankle moment", 1.0, 0, 100),
    "hip power, maximum": ("Hip power", 1.0, 0, 100),
    "ankle power, maximum": ("Ankle power", 1.0, 0, 100),
    "pelvis, drop of the other side in single support": ("Pelvis obliquity", 1.0, 10, 45),
    "trunk, lean to this side in single support": ("Trunk obliquity", -1.0, 10, 45),
}


class OfSides(NamedTuple):
    """A measure of the left and of the right side."""

    unit: str
    left: float
    right: float

    @property
    def symmetry(self) -> float | None:
        """Symmetry index, %, positive where the left is greater: 100 (L - R) / (0.5 (L + R)).

        As in Herzog et al. 1989, Med. Sci. Sports Exerc. 21:110. None where the sides have different signs, or where an
        angle is so small that its index says nothing.
        """
        if self.left * self.right <= 0.0 or (self.unit == "deg" and min(abs(self.left), abs(self.right)) < SMALL):
            return None
        return 200.0 * (self.left - self.right) / (self.left + self.right)


def measures_of_sides(recording: Recording, scene: Scene) -> dict[str, OfSides]:
    """All measures of both sides that a motion has, of the steady part of the walk.

    Args:
        scene: without free parameters.

    Raises:
        Error: no legs, or no whole gait cycle.
    """
    recording = over_belts(recording, scene)
    cycles = steady_strides(recording, scene)
    curves = gait_curves(recording, scene, cycles)
    scores = profile_scores(variable_scores(curves))
    found: dict[str, OfSides] = {}
    _put(found, "step length", "m", _step_lengths(recording, scene))
    _put(found, "stance", "% of the cycle", [_stance(recording, scene, cycles, side) for side in SIDES])
    if scores:
        _put(found, PROFILE, "deg", [scores[side] for side in SIDES])
    for name, (curve, sign, low, high) in _GREATEST.items():
        if curve in curves:
            _put(found, name, curves[curve].unit, [_greatest(curves[curve], side, sign, low, high) for side in SIDES])
    for muscle, (left, right) in _activations(recording, cycles).items():
        _put(found, f"activation of {muscle}", "0 to 1", [left, right])
    return found


def _put(found: dict[str, OfSides], name: str, unit: str, values: list[float]) -> None:
    """A measure, where both sides have it."""
    if len(values) == 2 and np.isfinite(values).all():
        found[name] = OfSides(unit, values[0], values[1])


def _step_lengths(recording: Recording, scene: Scene) -> list[float]:
    steps = steps_of(recording, scene, measure(recording, *feet_of(scene)).start)
    return [float(lengths.mean()) if len(lengths := steps.of(side)) else np.nan for side in (0, 1)]


def _stance(recording: Recording, scene: Scene, cycles: dict[str, Strides], side: str) -> float:
    """Part of the cycle that the foot is on the ground, %."""
    lifted = {
        contact.touch_down: contact.lift_off
        for contact in contacts_of(recording, side, body_weight(scene))
        if contact.touch_down is not None and contact.lift_off is not None
    }
    shares = [(lifted[begin] - begin) / (end - begin) for begin, end in cycles[side] if begin in lifted]
    return 100.0 * float(np.mean(shares)) if shares else np.nan


def _greatest(curve: Curves, side: str, sign: float, low: float, high: float) -> float:
    part = sign * mean_of(curve.sides[side])[(low <= PERCENT) & (high >= PERCENT)]
    known = part[np.isfinite(part)]
    return float(known.max()) if len(known) else np.nan


def _activations(recording: Recording, cycles: dict[str, Strides]) -> dict[str, tuple[float, float]]:
    """Mean activation over the cycle of muscles that both sides have, by name, heads together."""
    means: dict[str, dict[str, list[float]]] = {}
    for index, name in enumerate(recording.muscle_names):
        side, muscle = side_and_muscle(name)
        if muscle:
            curves: Floats = over_strides(recording.time, recording.muscle_activation[:, index], cycles[side])
            means.setdefault(muscle, {}).setdefault(side, []).append(float(curves.mean()))
    return {
        muscle: (float(np.mean(of_sides["left"])), float(np.mean(of_sides["right"])))
        for muscle, of_sides in means.items()
        if len(of_sides) == 2
    }
