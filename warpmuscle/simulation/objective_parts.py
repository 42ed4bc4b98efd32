"""What single joints and muscles add to the terms of an objective."""

from __future__ import annotations

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows
from warpmuscle.kernels import structs
from warpmuscle.kernels.objective.term_sums import ObjectiveKind
from warpmuscle.model.objective import torque_integrals
from warpmuscle.scene import Scene
from warpmuscle.scene.accounting import basal_rate
from warpmuscle.scene.topology import Topology

BASAL = "basal rate"  # what a term of metabolic energy has besides its muscles
Parts = dict[str, float]  # by name of the joint, body or muscle, in units of the term


def term_parts(
    terms: dict[str, Floats], scene: Scene, kind: ObjectiveKind, state: structs.State, names: Topology,
    muscles: tuple[str, ...], instance: int, end_time: float,
) -> dict[str, Parts]:  # fmt: skip
    """Parts of the terms of an instance that are sums over joints or muscles; they add up to the term.

    Args:
        terms: values (n,) of all terms. scene: its numbers are floats or (n,) arrays.
        muscles: names of those that are simulated. end_time: s, that the instance came to.
    """
    h = scene.time_step
    joints = (names.bodies[0], *names.joints)  # what a body's number stands for
    sums = {"torque": dict(zip(joints, h * torque_integrals(scene, state)[instance], strict=True))}
    for part, array, owners in (("body", state.body_terms, joints), ("muscle", state.muscle_terms, muscles)):
        for index, name in enumerate(getattr(kind, part)):
            sums[name] = dict(zip(owners, h * array.numpy()[instance, index], strict=True))
    sums |= {name: {owner: -v for owner, v in sums[name].items()} for name in kind.earned if name in sums}
    energy = sums.get(f"metabolic_{scene.objective.metabolic_model}")
    if energy is not None:
        mass = rows([body.mass for body in scene.character.bodies.values()]).sum(axis=1)
        basal = float(_of_instance(np.asarray(basal_rate(scene.objective)) * mass, instance)) * end_time
        sums["metabolic"] = energy | {BASAL: basal}
        total = sum(sums["metabolic"].values())
        for name in ("cost_of_transport",) if "cost_of_transport" in terms and total > 0.0 else ():
            scale = float(terms[name][instance]) / total
            sums[name] = {owner: scale * value for owner, value in sums["metabolic"].items()}
    parts_of = {name: {o: float(v) for o, v in sums[name].items() if v != 0.0} for name in terms if name in sums}
    return {name: parts for name, parts in parts_of.items() if np.isfinite(list(parts.values())).all() and parts}


def _of_instance(values: Floats, instance: int) -> Floats:
    """The value of an instance, of (1,) or (n,) of them."""
    return np.asarray(values[instance % len(values)])
