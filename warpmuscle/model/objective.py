"""The objective of a scene: its terms by name, what a batch sums up for them, and the cost."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, structs_to_device, to_device
from warpmuscle.kernels import structs
from warpmuscle.kernels.objective.objective_terms import TERMS, Term
from warpmuscle.kernels.objective.term_functions import BODY_TERMS, INSTANCE_TERMS, MUSCLE_TERMS
from warpmuscle.kernels.objective.term_sums import ObjectiveKind
from warpmuscle.model.part_checks import Kind, known_part
from warpmuscle.model.parts import CustomParts, plain_function
from warpmuscle.scene import Objective, Scene
from warpmuscle.scene.accounting import basal_rate, negative_share
from warpmuscle.scene.ground import HELD, LIFTED, LOADED
from warpmuscle.scene.masses import TINY_MASS
from warpmuscle.scene.norms import (
    BINS,
    FORCE,
    NORM_TERMS,
    NORMS,
    PERCENT_OF_BIN,
    RUNNING_FORCE_BAND,
    moment_table,
    norm_table,
    running_force,
)
from warpmuscle.scene.parameters import greatest
from warpmuscle.scene.topology import Topology, topology

LEAST_DISTANCE = 1.0  # m, that the cost of transport counts for


def counted_terms(objective: Objective) -> tuple[str, ...]:
    """Names of the terms that weigh or are reported, in the order of `TERMS`, then custom ones; `torque` always is."""
    always = ("torque", *objective.reported)
    names = dict.fromkeys((*TERMS, *objective.custom, *objective.reported))
    return tuple(name for name in names if name in always or np.any(rows([_weight(objective, name)])))


def described(name: str) -> Term:
    """What a term is; little is known of one of a user's module that has not been imported."""
    if name in TERMS:
        return TERMS[name]
    part, usual = known_part(name) or Term(), "summed over time, a term of the scene's own"
    return Term(name, part.unit, part.description or usual, "batch", part.sign)


def weight_of(objective: Objective, name: str) -> Any:
    """Weight of a term."""
    return getattr(objective, name) if name in TERMS else objective.custom.get(name, 0.0)


def _weight(objective: Objective, name: str) -> Any:
    """Weight of a term; of a free one its greatest value, so that it counts."""
    weight = weight_of(objective, name)
    return weight if isinstance(weight, float | int | np.ndarray) else 1.0


def objective_kind(scene: Scene, has_muscles: bool, parts: CustomParts | None = None) -> ObjectiveKind:
    """The sums that a step makes for the terms of a scene.

    Args:
        parts: of the scene's own.
    """
    parts = parts or CustomParts({}, {}, {}, {})
    names = set(counted_terms(scene.objective))
    if names & {"metabolic", "cost_of_transport"}:
        names.add(f"metabolic_{scene.objective.metabolic_model}")
    own = {name: found for name, found in parts.terms.items() if name in names}

    declared = {name: term for name, term in TERMS.items() if name in names}
    declared |= {name: found.part.declaration for name, found in own.items()}

    def summed(part: Kind, table: Iterable[str]) -> tuple[str, ...]:
        kinds = ("instance", "desired") if part == "instance" else (part,)
        table = tuple(table)
        return (
            *(name for name in table if name in names),
            *(n for n, f in own.items() if f.part.kind in kinds and n not in table),
        )

    return ObjectiveKind(
        muscle=summed("muscle", MUSCLE_TERMS) if has_muscles else (),
        body=summed("body", BODY_TERMS),
        instance=summed("instance", INSTANCE_TERMS),
        custom=tuple((name, plain_function(found, scene.character)) for name, found in own.items()),
        desired=tuple(name for name, found in own.items() if found.part.kind == "desired"),
        conditions=tuple((name, plain_function(one, scene.character)) for name, one in parts.conditions.items()),
        progress=greatest(scene, scene.failure.no_progress) > 0.0,
        cycles=any(placed.part.declaration.follows_cycles for placed in parts.all),
        accelerated=tuple(name for name, term in declared.items() if term.stage == "accelerations"),
        earned=tuple(name for name, term in declared.items() if term.sign == "earned"),
    )


def term_arrays(
    kind: ObjectiveKind, instances: int, bodies: int, muscles: int, zeros: Callable[..., wp.array]
) -> dict[str, wp.array]:
    """Room for the sums of a batch, by field of `kernels.structs.State`.

    Args:
        zeros: makes an array of a shape and dtype.
    """
    shapes = {
        "muscle_terms": (instances, len(kind.muscle), max(muscles, 1)) if kind.muscle else (1, 1, 1),
        "body_terms": (instances, len(kind.body), bodies) if kind.body else (1, 1, 1),
        "instance_terms": (instances, len(kind.instance)) if kind.instance else (1, 1),
    }
    return {name: zeros(*shape, dtype=wp.float64) for name, shape in shapes.items()}


@dataclass(frozen=True)
class RecordedNorms:
    """Curves of recorded gait cycles in the place of people's, by bins of the cycle, see `scene.norms.BINS`."""

    angle: Floats  # (2, 3, bins) degrees, of the hip, knee and ankle of both legs
    moment: Floats | None  # (2, 3, bins) N m/kg, likewise; None where the objective has no use for them
    force: Floats  # (bins,) body weights, vertical, mean of both feet


def objective_fields(
    scene: Scene, names: Topology, device: Any, recorded: RecordedNorms | None = None
) -> dict[str, Any]:
    """What terms need, by field of `kernels.structs.Model`.

    Args:
        recorded: gait cycles that stand in the place of people's.
    """
    objective = scene.objective
    head = names.bodies.index(objective.head_body) if objective.head_body in names.bodies else 0
    aim = {field: rows([getattr(objective, field)]) for field in structs.Aim.vars}
    fields = {
        "head": head,
        "objective": structs_to_device(structs.Aim, aim, device),
        "negative_share": negative_share(objective),
        "contact_rule": wp.vec3(LOADED, HELD, LIFTED),
    }
    if NORM_TERMS & set(counted_terms(objective)):
        angle, scale, side = norm_table(scene, names, None if recorded is None else recorded.angle)
        moment, moment_scale = moment_table(scene, names, None if recorded is None else recorded.moment)
        running, force = objective.gait == "run", NORMS[FORCE]
        mean = running_force(PERCENT_OF_BIN) if running else force.mean(PERCENT_OF_BIN)
        mean = mean if recorded is None else recorded.force
        fields |= {
            "norm_bins": BINS,
            "norm": to_device(angle, float, device),
            "norm_scale": to_device(scale, float, device),
            "norm_side": to_device(side, int, device),
            "norm_moment": to_device(moment, float, device),
            "moment_scale": to_device(moment_scale, float, device),
            "norm_force": to_device(mean, float, device),
            "norm_force_band": RUNNING_FORCE_BAND if running else force.half_width,
        }
    return fields


def term_values(
    names: tuple[str, ...], scene: Scene, kind: ObjectiveKind, state: structs.State, end_time: Floats, distance: Floats
) -> dict[str, Floats]:
    """Values (n,) of the terms that count, of all instances; negative of those that are earned, as they lower the cost.

    Args:
        names: of the terms.
        scene: its numbers are floats or (n,) arrays.
        end_time: (n,) s. distance: (n,) m, gone by the root.
    """
    h = scene.time_step
    sums = {"torque": _summed(torque_integrals(scene, state)) * h}
    for part, array in (("muscle", state.muscle_terms), ("body", state.body_terms), ("instance", state.instance_terms)):
        summed = getattr(kind, part)
        values = array.numpy() if summed else None
        for index, name in enumerate(summed):
            assert values is not None
            sums[name] = (values[:, index] if part == "instance" else _summed(values[:, index])) * h
    sums["fall"] = scene.duration - end_time
    mass = rows([body.mass for body in scene.character.bodies.values()]).sum(axis=1)
    energy = sums.get(f"metabolic_{scene.objective.metabolic_model}", 0.0)
    sums["metabolic"] = energy + np.asarray(basal_rate(scene.objective)) * mass * end_time
    sums["cost_of_transport"] = sums["metabolic"] / (np.maximum(mass, TINY_MASS) * np.maximum(distance, LEAST_DISTANCE))
    sums |= {name: -sums[name] for name in kind.earned}
    return {name: np.asarray(sums.get(name, np.zeros_like(end_time))) for name in names}


def torque_integrals(scene: Scene, state: structs.State) -> Floats:
    """Feedback torque summed over steps as it counts, (n, bodies) N m, at the child of each joint.

    Args:
        scene: its numbers are floats or (n,) arrays.
    """
    integrals: Floats = state.torque_integral.numpy()
    factors = scene.objective.torque_by_joint
    if factors:
        integrals, names = integrals.copy(), topology(scene.character)
        for joint, factor in factors.items():
            integrals[:, names.body_of_joint(joint)] *= np.asarray(factor, dtype=np.float64)
    return integrals


def weighted(scene: Scene, terms: dict[str, Floats]) -> Floats:
    """The weighted sum (n,) of the terms, at most the cost of a failure."""
    total = sum((np.asarray(weight_of(scene.objective, name)) * value for name, value in terms.items()), 0.0)
    return np.asarray(np.minimum(total, scene.objective.failure_cost))


def _summed(values: Floats) -> Floats:
    """Sum over the last axis, one after the other: the same for any number of instances."""
    total = np.zeros(values.shape[:-1])
    for k in range(values.shape[-1]):
        total += values[..., k]
    return total
