"""Muscles with their impairments."""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from warpmuscle.scene.impairments.part import FACTORS, Impairment
from warpmuscle.scene.muscles.muscle import Muscle, MuscleModel, given

if TYPE_CHECKING:
    from warpmuscle.scene.scene import Scene


COMMON = ("v_max", "rise_time", "fall_time", "tendon_strain", "passive_strain")  # that all muscles may share


def impaired_number(muscle: Muscle, model: MuscleModel, field: str) -> Any:
    """The number of a muscle that a factor multiplies: its own, or that of all muscles; None if there is none."""
    return given(muscle, model, field) if field in COMMON else getattr(muscle, field)


def impaired_muscles(impairment: Impairment, muscles: Iterable[str]) -> list[str]:
    """The names that an impairment means, each once, in the order of the muscles."""
    return [name for name in muscles if any(fnmatchcase(name, pattern) for pattern in impairment.muscles)]


def in_words(scene: Scene) -> list[str]:
    """The impairments of a scene, each with its muscles and those of its factors that are not 1."""
    found = []
    for name, impairment in scene.impairments.items():
        factors = {field: getattr(impairment, field) for field in FACTORS}
        changes = [
            f"{field} x {f'{factor:.4g}' if isinstance(factor, int | float) else 'a free or commanded number'}"
            for field, factor in factors.items()
            if factor != 1.0
        ]
        if changes:
            muscles = impaired_muscles(impairment, scene.character.muscles)
            found.append(f"{name}: {', '.join(changes)} of {', '.join(muscles) or 'no muscle'}")
    return found


def impaired(scene: Scene) -> Scene:
    """A scene whose muscles have their impairments in their numbers, and which has none besides.

    Args:
        scene: its numbers are floats, or (n,) arrays with one value an instance; it is not changed.
    """
    if not scene.impairments:
        return scene
    muscles = dict(scene.character.muscles)
    for impairment in scene.impairments.values():
        factors = {name: getattr(impairment, name) for name in FACTORS}
        factors = {name: factor for name, factor in factors.items() if not (isinstance(factor, float) and factor == 1)}
        for name in impaired_muscles(impairment, muscles):
            muscle = muscles[name]
            changed = {
                field: factor * impaired_number(muscle, scene.muscle_model, field) for field, factor in factors.items()
            }
            muscles[name] = replace(muscle, **changed)
    return replace(scene, character=replace(scene.character, muscles=muscles), impairments={})
