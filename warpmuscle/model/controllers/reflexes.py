"""Reflexes of a scene as a kernel wants them: those of all simulated muscles in flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import warp as wp

from warpmuscle.core.arrays import records_to_device, rows, starts, structs_to_device, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import reflex_structs, structs
from warpmuscle.scene import Reflex, Scene
from warpmuscle.scene.reflexes import OF_MUSCLES
from warpmuscle.scene.topology import Topology

SIDES = {"l": structs.LEFT, "r": structs.RIGHT}  # by the first letter of a name
SIDE_NAMES = {"l": "left", "r": "right"}
SIGNAL = {
    "constant": reflex_structs.CONSTANT, "force": reflex_structs.FORCE, "length": reflex_structs.LENGTH,
    "velocity": reflex_structs.VELOCITY, "lean": reflex_structs.LEAN, "lean_at_lift": reflex_structs.LEAN_AT_LIFT,
    "angle": reflex_structs.ANGLE, "load": reflex_structs.LOAD, "other_load": reflex_structs.OTHER_LOAD,
}  # fmt: skip
PART = {"all": reflex_structs.ALL, "positive": reflex_structs.POSITIVE, "negative": reflex_structs.NEGATIVE}
MOVING = {"either": reflex_structs.EITHER, "rising": reflex_structs.RISING, "falling": reflex_structs.FALLING}
DURING = {
    "always": reflex_structs.ALWAYS, "stance": reflex_structs.STANCE, "swing": reflex_structs.SWING,
    "trailing": reflex_structs.TRAILING,
}  # fmt: skip
TIMES = {
    "once": reflex_structs.ONCE, "load": reflex_structs.BY_LOAD, "other_load": reflex_structs.BY_OTHER_LOAD
}  # fmt: skip


def reflexes_of(scene: Scene, muscle: str) -> dict[str, Reflex]:
    """Reflexes of a muscle, by their names; none if its controller has none for it."""
    controller = scene.simbicon
    if controller is None or controller.reflexes is None or muscle[:1] not in SIDES:
        return {}
    own = controller.reflexes.muscles.get(muscle[1:], {})
    return {name: reflex for name, reflex in own.items() if reflex.side in ("both", SIDE_NAMES[muscle[0]])}


def has_reflexes(scene: Scene, muscles: Sequence[str]) -> bool:
    """Whether any of these muscles has a reflex."""
    return any(reflexes_of(scene, muscle) for muscle in muscles)


def reflexes_struct(scene: Scene, names: Topology, muscles: Sequence[str], device: Any) -> structs.Reflexes:
    """The device structure of the reflexes of the simulated muscles; an empty one if there are none.

    Raises:
        SceneError: a reflex senses a muscle that is not simulated.
    """
    s = structs.Reflexes()
    controller = scene.simbicon
    if controller is None or controller.reflexes is None or not has_reflexes(scene, muscles):
        return s
    own = [reflexes_of(scene, muscle) for muscle in muscles]
    places = starts(len(reflexes) for reflexes in own)
    s.trunk = names.bodies.index(controller.reflexes.trunk)
    s.span = records_to_device(
        reflex_structs.ReflexSpan, device, first=places[:-1], end=places[1:],
        side=[SIDES.get(muscle[0], structs.LEFT) for muscle in muscles],
    )  # fmt: skip
    every = [
        (muscle, name, reflex)
        for muscle, reflexes in zip(muscles, own, strict=True)
        for name, reflex in reflexes.items()
    ]
    terms = [reflex for _, _, reflex in every]
    s.plan = records_to_device(
        reflex_structs.ReflexPlan, device,
        signal=[SIGNAL[reflex.signal] for reflex in terms],
        source=[_source(muscle, name, reflex, names, muscles) for muscle, name, reflex in every],
        part=[PART[reflex.part] for reflex in terms], moving=[MOVING[reflex.moving] for reflex in terms],
        during=[DURING[reflex.during] for reflex in terms], times=[TIMES[reflex.times] for reflex in terms],
    )  # fmt: skip
    columns = {field: rows([getattr(reflex, field) for reflex in terms]) for field in reflex_structs.ReflexRow.vars}
    s.row = structs_to_device(reflex_structs.ReflexRow, columns, device)
    least = 0.0 if controller.reflexes.besides else controller.reflexes.least
    s.bounds = to_device(rows([[controller.reflexes.stance_load, least]]), wp.vec2, device)
    return s


def _source(muscle: str, name: str, reflex: Reflex, names: Topology, muscles: Sequence[str]) -> int:
    """Number of the muscle, or of the body on the joint, that a reflex of this name senses."""
    sensed = muscle[0] + reflex.of if reflex.of else muscle
    if reflex.signal == "angle":
        return names.body_of_joint(sensed)
    if reflex.signal in OF_MUSCLES and sensed not in muscles:
        raise SceneError(
            f"{sensed} acts on no joint that muscles drive, so there is nothing to sense",
            key=f"controller.reflexes.muscles.{muscle[1:]}.{name}.of",
        )
    return muscles.index(sensed) if reflex.signal in OF_MUSCLES else 0
