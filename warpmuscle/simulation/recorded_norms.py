"""Curves of recorded gait cycles, which the objective compares with in the place of published norms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import toml
from warpmuscle.gait.cycles import PERCENT, Strides, leg_angles, over_strides, strides
from warpmuscle.gait.cycles import body_weight as weight_of_body
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.gait.joint_moments import leg_moments
from warpmuscle.model.objective import RecordedNorms, counted_terms
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.scene import Scene
from warpmuscle.scene.norms import NORM_TERMS, PERCENT_OF_BIN
from warpmuscle.scene.parameters import at_start

Curves = dict[str, dict[str, Floats]]  # by name and side, of all frames


def recorded_norms(scene: Scene) -> RecordedNorms | None:
    """The curves of the recordings that a scene names; None if it names none, or its objective compares with none.

    Angles, moments over mass and forces over weight are means over all whole gait cycles of the motions that count,
    of each leg by itself; mass and weight are those of the body that was recorded.

    Raises:
        Error: a file cannot be read, has no such motion, no legs, or no whole gait cycle of a leg.
    """
    named, terms = scene.norms, NORM_TERMS & set(counted_terms(scene.objective))
    if named is None or not terms:
        return None
    # What reads files takes longer to import than most scenes to start, which compare with none.
    from warpmuscle.results.partial_motion import motion_of
    from warpmuscle.results.result import read

    path = Path(named.file)
    result = read(path)
    numbers = named.replays or list(range(len(result.replays)))
    if not numbers:
        raise RolloutError(f"{path}: holds no motion, whose curves would be norms")
    motions = [motion_of(result, str(path), number) for number in numbers]
    body = _body(result, path)
    try:
        cycles = [_cycles(motion, body, named.start) for motion in motions]
        for side in SIDES:
            if not any(of_motion[side] for of_motion in cycles):
                raise RolloutError(
                    f"{path}: {number_of(len(motions), 'motion')} without a whole gait cycle: from {named.start:g} s "
                    f"on the {side} foot lands less than twice, by the forces on it"
                )
        angle = _means(motions, cycles, [leg_angles(motion, body) for motion in motions])
        moment = None
        if "norm_moments" in terms:
            moment = _means(motions, cycles, [leg_moments(motion, body) for motion in motions])
        forces = [{"force": _vertical_forces(motion, body)} for motion in motions]
        return RecordedNorms(angle, moment, _means(motions, cycles, forces).mean(axis=0)[0])
    except RolloutError:
        raise
    except Error as error:
        text = str(error)
        raise RolloutError(text if text.startswith(str(path)) else f"{path}: {text}") from None


def _body(result: Result, path: Path) -> Scene:
    """The scene of the recorded body, without free parameters."""
    try:
        scene = toml.loads(result.scene, name="its scene")
        return at_start(scene)
    except Error as error:
        raise RolloutError(f"{path}: the body of its motions is not known: {error}") from None


def _cycles(motion: Recording, body: Scene, start: float) -> dict[str, Strides]:
    weight = weight_of_body(body)
    return {side: strides(motion, side, start, weight) for side in SIDES}


def _vertical_forces(motion: Recording, body: Scene) -> dict[str, Floats]:
    """As they were recorded, of both sides, body weights: a step compares its own force, which nobody filters."""
    return {side: motion[f"foot_force_{side}"][:, 1] / weight_of_body(body) for side in SIDES}


def _means(motions: Sequence[Recording], cycles: Sequence[dict[str, Strides]], curves: Sequence[Curves]) -> Floats:
    """Means (2, curves, BINS) of each side's curves over all of its gait cycles, at the middle of each bin."""
    found = []
    for side in SIDES:
        rows = []
        for name in curves[0]:
            parts = [
                over_strides(motion.time, own[name][side], of_motion[side])
                for motion, own, of_motion in zip(motions, curves, cycles, strict=True)
                if of_motion[side]
            ]
            mean = np.concatenate(parts).mean(axis=0)
            rows.append(np.interp(PERCENT_OF_BIN, PERCENT, mean))
        found.append(rows)
    return np.array(found)
