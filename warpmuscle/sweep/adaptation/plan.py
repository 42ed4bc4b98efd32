"""A sweep over measured conditions: a run for each condition and seed, scaled to the body of a scene."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence

from warpmuscle.core.errors import Error
from warpmuscle.gait.likeness import leg_length
from warpmuscle.scene import Scene
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.sweep.adaptation.records import Record

# Bodies that carry a load, by its place; of limbs both, each with the whole load.
PLACES = {
    "pelvis": ("pelvis",), "torso": ("torso",), "femur": ("lUpperleg", "rUpperleg"),
    "tibia": ("lLowerleg", "rLowerleg"), "foot": ("lFoot", "rFoot"),
}  # fmt: skip
RADIUS = 0.1  # m, of gyration of a load


def sweep_text(
    records: Sequence[Record], scene: Scene, name: str, seeds: int, candidates: int, duration: float, sigma: float
) -> str:
    """The sweep file of some conditions; speeds are those of the same Froude number, loads the same part of the body.

    Args:
        scene: that walks. name: what the sweep calls it. duration: of each simulation, s.

    Raises:
        Error: the scene has no bodies for a load, or no legs.
    """
    plain = substitute(scene, start_values(scene))
    leg, mass = leg_length(plain), body_mass(plain.character)
    lines = [
        f"scene = {json.dumps(name)}", "", "[search]", 'strategy = "cma"', f"candidates = {candidates}",
        f"sigma = {sigma!r}", "", "[set]", f"duration = {duration!r}", "",
        "[grid]", f"seed = {list(range(1, seeds + 1))}",
    ]  # fmt: skip
    for record in records:
        lines += ["", "[[run]]", f"name = {json.dumps(record.name)}"]
        lines.append(f'"objective.target_speed" = {record.speed * math.sqrt(leg / record.leg)!r}')
        if record.slope:
            lines.append(f'"ground.normal" = [0, 1, {-record.slope!r}]')
        if record.load:
            lines += _load(record, scene, record.load * mass)
    return "\n".join(lines) + "\n"


def _load(record: Record, scene: Scene, mass: float) -> list[str]:
    """The lines that put masses, kg, on the bodies of a place."""
    bodies = PLACES.get(record.place)
    if bodies is None:
        raise Error(f"{record.name}: no place of a load is called {record.place!r}; there are {', '.join(PLACES)}")
    missing = [body for body in bodies if body not in scene.character.bodies]
    if missing:
        raise Error(f"{record.name}: the scene has no body {missing[0]!r} for a load on the {record.place}")
    inertia = [mass * RADIUS**2] * 3
    lines = []
    for body in bodies:
        load = f"load_on_{body}"
        lines.append(f'"character.bodies.{load}" = {{ mass = {mass!r}, inertia = {inertia} }}')
        lines.append(
            f'"character.joints.{load}" = {{ type = "fixed", parent = "{body}", child = "{load}", '
            "position_in_parent = [0, 0, 0], position_in_child = [0, 0, 0] }"
        )
    return lines
