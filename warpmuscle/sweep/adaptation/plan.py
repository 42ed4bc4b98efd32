"""A sweep over measured conditions: a run for each condition and seed, scaled to the body of a scene."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from msgspec.structs import replace

from warpmuscle.core.errors import Error
from warpmuscle.core.files import read_file, shown, unreadable
from warpmuscle.core.number_rows import first_number
from warpmuscle.formats.toml_layout import inline
from warpmuscle.gait.likeness import leg_length
from warpmuscle.scene import Scene
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.number import Free, Number
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.start import start_depths
from warpmuscle.sweep.adaptation.records import Record

# Bodies that carry a load, by its place; of limbs both, each with the whole load.
PLACES = {
    "pelvis": ("pelvis",), "torso": ("torso",), "femur": ("lUpperleg", "rUpperleg"),
    "tibia": ("lLowerleg", "rLowerleg"), "foot": ("lFoot", "rFoot"),
}  # fmt: skip
AT_JOINTS = {"knee": 1, "ankle": 2}  # places at the lower end of a limb's body, by the number of the joint of a leg
RADIUS = 0.1  # m, of gyration of a load
NO_LOAD = 0.001  # kg
EMPTY: Mapping[str, Any] = {}
SAID = {  # keys that no setting may have
    "duration": "give --duration",
    "objective.target_speed": "speeds are those of the conditions",
    "ground.normal": "slopes are those of the conditions",
}
MADE = "# Made by warpmuscle adaptation, which writes it anew each time.\n"


def check_not_edited(path: Path) -> None:
    """Raise Error if there is a file in place of the sweep file that is to be written, and it is somebody's own."""
    try:
        own = read_file(path).startswith(MADE.encode())
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        raise Error(f"{path}: {unreadable(error)}") from None
    if not own:
        raise Error(f"{path}: would be replaced by the sweep of these conditions; name another --output, or move it")


def sweep_text(
    records: Sequence[Record], scene: Scene, name: str, seeds: int, search: Mapping[str, float], duration: float,
    settings: Mapping[str, Any] = EMPTY,
) -> str:  # fmt: skip
    """The sweep file of some conditions; speeds are those of the same Froude number, loads the same part of the body.

    All runs have bodies for all loads, next to nothing where there is none, so that they share batches.

    Args:
        scene: that walks, with the settings. name: what the sweep calls it. search: options of the searches.
        duration: of each simulation, s. settings: other values in the scene, by key.

    Raises:
        Error: the scene has no bodies for a load, or no legs; a setting is of what the conditions say.
    """
    for key in settings:
        if key in SAID:
            raise Error(f"--set {key}: {SAID[key]}")
    plain = at_start(scene)
    leg, mass = leg_length(plain), body_mass(plain.character)
    lines = [f"scene = {json.dumps(name)}", 'keep = "best"', "", "[search]", 'strategy = "cma"']
    lines += [f"{option} = {shown(value)}" for option, value in search.items()]
    lines += ["", "[set]", f"duration = {duration!r}"]
    lines += [f"{json.dumps(key)} = {inline(value)}" for key, value in settings.items()]
    loaded = {record.place: record for record in records if record.load}
    for load in (load for record in loaded.values() for load in _loads(record, plain)):
        lines.append(f'"character.bodies.{load.name}" = {{ mass = {NO_LOAD}, inertia = {_inertia(NO_LOAD)} }}')
        lines.append(
            f'"character.joints.{load.name}" = {{ type = "fixed", parent = "{load.body}", child = "{load.name}", '
            f"position_in_parent = {inline(load.position)}, position_in_child = [0, 0, 0] }}"
        )
    lines += ["", "[grid]", f"seed = {list(range(1, seeds + 1))}"]
    for record in records:
        lines += ["", "[[run]]", f"name = {json.dumps(record.name)}"]
        lines.append(f'"objective.target_speed" = {record.speed * math.sqrt(leg / record.leg)!r}')
        if record.slope:
            lines.append(f'"ground.normal" = [0, 1, {-record.slope!r}]')
            lines += _raised(plain, scene.initial_state.root_position[1], record.slope)
        for load in _loads(record, plain) if record.load else ():
            lines.append(f'"character.bodies.{load.name}.mass" = {record.load * mass!r}')
            lines.append(f'"character.bodies.{load.name}.inertia" = {_inertia(record.load * mass)}')
    return MADE + "\n".join(lines) + "\n"


def _raised(plain: Scene, height: Number, slope: float) -> list[str]:
    """The height of the root at which the lowest body starts as deep in a slope as on level ground.

    The same pose stands with a foot in a slope, from which the ground would throw the body up.

    Args:
        plain: the scene on level ground, without free parameters. height: of its root, m.
    """
    level = start_depths(plain)
    if not level or (isinstance(height, Free) and height.value is None):
        return []
    ground = replace(plain.ground, normal=(0.0, 1.0, -slope))
    deeper = max(start_depths(replace(plain, ground=ground)).values()) - max(level.values())
    more = deeper * math.hypot(1.0, slope)  # depths are along the normal
    if isinstance(height, Free):
        ends = {name: end + more for name in ("value", "min", "max") if (end := getattr(height, name)) is not None}
        return [f'"initial_state.root_position.1" = {inline(replace(height, **ends))}']
    return [f'"initial_state.root_position.1" = {first_number(height) + more!r}']


class _Load(NamedTuple):
    """Where a load is fixed."""

    name: str  # of its body
    body: str  # that carries it
    position: list[float]  # m, in that body


def _loads(record: Record, plain: Scene) -> list[_Load]:
    """The loads of a condition, of a scene without free parameters."""
    character, place = plain.character, record.place
    if place in AT_JOINTS:
        legs = [leg_joints(plain, side) for side in (0, 1)]
        if any(len(joints) <= AT_JOINTS[place] for joints in legs):
            raise Error(f"{record.name}: the scene has no {place}s for a load on them")
        joints = [character.joints[names[AT_JOINTS[place]]] for names in legs]
        return [
            _Load(f"load_at_{place}_of_{one.child}", one.parent, [first_number(x) for x in one.position_in_parent])
            for one in joints
        ]
    bodies = PLACES.get(place)
    if bodies is None:
        known = ", ".join((*PLACES, *AT_JOINTS))
        raise Error(f"{record.name}: no place of a load is called {place!r}; there are {known}")
    missing = [body for body in bodies if body not in character.bodies]
    if missing:
        raise Error(f"{record.name}: the scene has no body {missing[0]!r} for a load on the {place}")
    return [_Load(f"load_on_{body}", body, [0, 0, 0]) for body in bodies]


def _inertia(mass: float) -> list[float]:
    return [mass * RADIUS**2] * 3
