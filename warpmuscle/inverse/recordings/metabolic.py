"""Metabolic power of the muscles of a recorded motion, by all published formulas of the package."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ArgumentError
from warpmuscle.gait.muscle_effort import FORMULAS, has_formulas, passive_and_powers
from warpmuscle.inverse.activations import Activations
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.kernels.muscle.effort import BHARGAVA_STRICT

STRICT = "bhargava strict"  # of OpenSim's probe: heat is at least 1 W/kg, and no muscle's power is negative


def metabolic_powers(body: BodyModel, activations: Activations, work: str | None = None) -> dict[str, Floats]:
    """Metabolic power (F, M), W, of every muscle by formula: wang, umberger, bhargava, bhargava strict, margaria.

    Excitations are the activations, since static optimisation knows no other. Ligaments spend nothing. Nothing is added
    for the body at rest; masses of muscles are those of the model's specific tension.

    Args:
        work: "positive", or "net", by which lengthening fibres give back what work they take; by default that of each
            formula: positive of wang and margaria, net of the others.

    Raises:
        ArgumentError: muscles of another model, curves of their own code, or another `work`.
    """
    if work not in (None, "positive", "net"):
        raise ArgumentError(f'work is "positive", "net" or None, not {work!r}')
    if activations.muscles != body.muscles:
        raise ArgumentError("the activations are of muscles of another model")
    if not has_formulas(body.scene):
        raise ArgumentError("metabolic formulas need muscles with curves of the package")
    values = [activations.activation, activations.activation, activations.fibre_length, activations.fibre_velocity]
    found = {}
    for name, number in (FORMULAS | {STRICT: BHARGAVA_STRICT}).items():
        objective = replace(body.scene.objective, metabolic_model=name.split()[0], metabolic_work=work, basal_rate=None)
        scene = replace(body.scene, objective=objective)
        _, (power,) = passive_and_powers(scene, body.muscles, values, [number])
        found[name] = np.where(body.pulls, power, 0.0)
    return found
