"""What muscles of a scene say besides the properties that all have."""

from __future__ import annotations

from collections.abc import Mapping

from warpmuscle.scene.muscles.curves import SHAPED, SPECIAL
from warpmuscle.scene.muscles.muscle import Muscle, MuscleModel


def special_settings(muscles: Mapping[str, Muscle], model: MuscleModel) -> list[str]:
    """Keys of the scene at which muscles, or their model, have curves, tendons or times unlike the usual ones."""
    keys = [
        f"character.muscles.{name}.{field}"
        for name, muscle in muscles.items()
        for field in SPECIAL
        if getattr(muscle, field) is not None
    ]
    keys += [f"muscle_model.{field}" for field in SHAPED if getattr(model, field) is not None]
    others = [field for field in ("minimum_activation", "activation_smoothing") if getattr(model, field) != 0.0]
    return keys + [f"muscle_model.{field}" for field in others]
