"""Synergies of excitations that static optimisation computes from motions, where nobody recorded EMG."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene.parameters import start_values
from warpmuscle.synergy.factorization import factorize, reconstruct
from warpmuscle.synergy.static_optimization import StaticOptimization
from warpmuscle.throw.arm import Arm, needed_torques
from warpmuscle.throw.missing_torque import Lack, lacking
from warpmuscle.throw.motion import ArmMotions
from warpmuscle.throw.signals import Synergies, computed_activation, to_excitation

COMPUTED = "computed"
ALONE = 2  # muscles a joint, up to which none shares its work with others
PURE = 0.05  # most of other muscles' weights, in parts of its own, in a synergy that is one muscle alone


def computed_synergies(
    arm: Arm, motions: ArmMotions, strong: Arm, count: int, seed: int = 0
) -> tuple[Synergies, list[Lack]]:
    """Synergies of computed excitations, and what the muscles that these were computed with lack.

    Args:
        strong: the same arm with the muscles that activations are computed with; not those that the fit starts from.
        count: N.
    """
    activation, excitation, found = computed_excitation(strong, motions)
    lacks = lacking(strong, motions, found, strong.unknowns(start_values(strong.scene)))
    acting = arm.acting
    if count > len(acting):
        raise Error(
            f"{number_of(count, 'synergy')} are more than the {number_of(len(acting), 'muscle')} that move "
            f"{', '.join(arm.driven)}"
        )
    return factorized(arm, motions, excitation, activation[:, 0], count, COMPUTED, seed), lacks


def computed_excitation(strong: Arm, motions: ArmMotions) -> tuple[Floats, Floats, StaticOptimization]:
    """Activations and excitations (n, T, M) by static optimisation."""
    activation, found = computed_activation(strong, motions, strong.unknowns(start_values(strong.scene)))
    return activation, to_excitation(strong, activation), found


def factorized(
    arm: Arm, motions: ArmMotions, excitation: Floats, start: Floats, count: int, source: str, seed: int = 0
) -> Synergies:
    """Synergies of excitations (n, T, M) of the muscles that act, whose activations start at (n, M)."""
    acting, inside = arm.acting, motions.valid > 0.0
    given = excitation[:, :, acting][inside]
    scale = torque_scale(arm, motions)
    sparse = sparsest(factorize(given * scale, count, seed=seed).weights / scale[:, None])
    sparse /= sparse.max(axis=0)
    coefficients = reconstruct(given * scale, sparse * scale[:, None])
    weights = np.zeros((len(arm.muscles), count))
    weights[acting] = sparse
    signals = np.zeros((*motions.valid.shape, count))
    signals[inside] = coefficients.T
    first = reconstruct(start[:, acting] * scale, sparse * scale[:, None]).T
    explained = 1.0 - float(np.sum((given - (sparse @ coefficients).T) ** 2) / np.sum(given**2))
    return Synergies(weights, np.clip(signals, 0.0, 1.0), np.clip(first, 0.0, 1.0), explained, source)


def torque_scale(arm: Arm, motions: ArmMotions) -> Floats:
    """What an excitation counts in the factorisation: (muscles that act,), 1 with up to two muscles a joint.

    Where more muscles share a joint, errors count by the torque that they make, in parts of what the joint needs: else
    synergies explain strong muscles well and leave the wrist, whose muscles hardly act, to chance.
    """
    if len(arm.acting) <= ALONE * len(arm.driven):
        return np.ones(len(arm.acting))
    inside = motions.valid > 0.0
    angle, speed = (part[inside] for part in motions.angles[:2])
    table = arm.muscle_table(arm.unknowns(start_values(arm.scene))[None])
    torque = table.torques(1.0, angle, speed)[0] - table.torques(0.0, angle, speed)[0]
    spread = needed_torques(arm, motions)[inside].std(axis=0)
    part = (torque / np.maximum(spread, 1e-6))[:, :, arm.free]
    scale = np.sqrt(np.mean(np.sum(part**2, axis=2), axis=0))[arm.acting]
    return np.asarray(scale / scale.max())


def sparsest(weights: Floats) -> Floats:
    """Weights (M, N) without those that other synergies can take over.

    Where a synergy is one muscle alone, what other synergies hold of that muscle can as well be in its own signal: all
    such factorisations account for the same. Only the one with the fewest ties leaves signals free to change alone.
    """
    weights = weights.copy()
    main = weights.argmax(axis=0)
    for k, muscle in enumerate(main):
        others = np.arange(weights.shape[1]) != k
        if np.sum(weights[:, k]) - weights[muscle, k] <= PURE * weights[muscle, k]:
            weights[muscle, others & (main != muscle)] = 0.0
    return weights
