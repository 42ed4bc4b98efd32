"""Names of what ended instances: parts of the scene's own, and what was given from outside; see `causes.py`."""

from __future__ import annotations

from warpmuscle.core.array_types import Integers
from warpmuscle.kernels.objective.causes import (
    CONDITION,
    EFFORT,
    ENTRY,
    EXCITATION,
    FORCE,
    GIVEN_EXCITATION,
    GIVEN_TORQUE,
    TERM,
)
from warpmuscle.model.controllers.declared import declared_name
from warpmuscle.model.structure import Structure
from warpmuscle.scene import Scene

NONE = "that is not a number, or beyond all bounds"


def cause_words(numbers: Integers, scene: Scene, structure: Structure) -> tuple[str, ...]:
    """For each instance what ended it, in words, from its number; nothing where it was no such part."""
    if not numbers.any():  # as nearly always, of thousands of instances
        return ("",) * len(numbers)
    known = {int(number): _words(int(number), scene, structure) if number else "" for number in set(numbers.tolist())}
    return tuple(known[number] for number in numbers.tolist())


def _words(number: int, scene: Scene, structure: Structure) -> str:
    entry, rest = divmod(number, ENTRY)
    kind, part = divmod(rest, 8)
    joint = structure.names.joints[entry - 1] if part in (EFFORT, GIVEN_TORQUE) else ""
    muscles = structure.actuation.muscles
    if part == TERM:
        return f"the term {structure.objective.custom[kind][0]!r} gave a value {NONE}"
    if part == CONDITION:
        return f"the failing condition {structure.objective.conditions[kind][0]!r} is met"
    if part == FORCE:
        name = str(structure.forces[kind].names[entry])
        return f"the force {name!r} ({scene.forces[name].type}) gave a value {NONE}"
    if part == EFFORT:
        return f"the controller {declared_name(scene)[0]!r} gave the joint {joint!r} an effort {NONE}"
    if part == EXCITATION:
        return f"the controller {declared_name(scene)[0]!r} gave the muscle {muscles[entry]!r} an excitation {NONE}"
    if part == GIVEN_TORQUE:
        return f"the joint {joint!r} was given a torque {NONE}"
    assert part == GIVEN_EXCITATION
    return f"the muscle {muscles[entry]!r} was given an excitation that is not a number"
