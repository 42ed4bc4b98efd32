"""Bodies that push each other where they touch: which of their shapes, and the parameters of each pair of capsules."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.contact.body_contact import body_contact_of
from warpmuscle.kernels.force.forces import ForceKind
from warpmuscle.model.collisions import FASTEST, CapsuleRows, capsule_of, steps_between_tests
from warpmuscle.model.joints import has_turned_axes
from warpmuscle.scene import Scene
from warpmuscle.scene.body_contact.pairs import touching_pairs
from warpmuscle.scene.parameters import at_start, greatest


class ShapePair(NamedTuple):
    """Two shapes that push each other: numbers of shapes among those of their bodies."""

    first: str
    first_shape: int
    second: str
    second_shape: int


def shape_pairs(scene: Scene) -> tuple[ShapePair, ...]:
    """The pairs of shapes that push each other in a checked scene, free parameters at their start values.

    Raises:
        SceneError: there is contact of bodies, but no two of them could touch.
    """
    contact = scene.body_contact
    if contact is None or greatest(scene, contact.stiffness) <= 0.0:
        return ()
    bodies = scene.character.bodies
    pairs = tuple(
        ShapePair(a, i, b, j)
        for a, b in touching_pairs(at_start(scene))
        for i, j in product(range(len(bodies[a].shapes)), range(len(bodies[b].shapes)))
    )
    if not pairs:
        raise SceneError("this is not a biped whose bodies have shapes: name `pairs`", key="body_contact")
    return pairs


def contact_kind(scene: Scene) -> ForceKind:
    """The kind of force between bodies of a scene that touch."""
    kind: ForceKind = body_contact_of(any(map(has_turned_axes, scene.character.bodies.values())))
    return kind


def contact_parameters(scene: Scene, pair: ShapePair) -> Mapping[str, Any]:
    """Values of `kernels.contact.body_contact.CapsulePair` for a pair of shapes, floats or (rows,) arrays.

    Args:
        scene: its numbers are floats, or (n,) arrays with one value an instance.
    """
    bodies, contact = scene.character.bodies, scene.body_contact
    assert contact is not None
    one = capsule_of(bodies[pair.first].shapes[pair.first_shape])
    other = capsule_of(bodies[pair.second].shapes[pair.second_shape])
    margin = max(FASTEST * (steps_between_tests(scene.time_step) - 1) * scene.time_step, 1e-6)
    lengths = (np.linalg.norm(half, axis=1) for _, half, _ in (one, other))
    return {
        **_capsule("first", one),
        **_capsule("second", other),
        "margin": margin,
        "reach": sum(lengths) + one[2] + other[2] + margin,
        "stiffness": contact.stiffness,
        "damping": contact.damping,
        "tangential_damping": contact.tangential_damping,
        "friction": contact.friction,
    }


def _capsule(which: str, capsule: CapsuleRows) -> dict[str, Any]:
    middle, half, radius = capsule
    values = {f"{which}_{axis}": middle[:, k] for k, axis in enumerate("xyz")}
    values |= {f"{which}_half_{axis}": half[:, k] for k, axis in enumerate("xyz")}
    values[f"{which}_radius"] = radius
    return {name: _single(array) for name, array in values.items()}


def _single(array: Any) -> Any:
    return float(array[0]) if len(array) == 1 else array
