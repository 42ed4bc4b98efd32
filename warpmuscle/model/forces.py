"""Forces of a scene: of which kinds they are, and on which bodies they act; among them bodies that touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.force.devices import FORCES
from warpmuscle.kernels.force.forces import ForceKind, Wrench
from warpmuscle.kernels.structs import Model, Scratch, State
from warpmuscle.model.body_contact import ShapePair, contact_kind, shape_pairs
from warpmuscle.model.extensions import BODY, check_declaration, check_fields
from warpmuscle.model.objects.arrays import ObjectPlaces, object_places, objects_kind
from warpmuscle.model.user_functions import declared
from warpmuscle.model.water.arrays import part_starts
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.checks import Checks, known
from warpmuscle.scene.validation.forces import check_leg, check_place, check_positive, check_values

FUNCTIONS: dict[str, tuple[tuple[Any, ...], Any]] = {"effort": (BODY, wp.vec3), "wrench": (BODY, Wrench)}
PHASES = {"effort": "muscles", "wrench": "inertia"}  # of a step, in which those are called; shipped ones have a test
BOTH = (wp.int32, wp.int32, wp.int32, wp.int32, Model, State, Scratch)  # of a force between two bodies
SHIPPED_FUNCTIONS = FUNCTIONS | {"pair": (BOTH, Wrench)}
SHIPPED_ONLY = ("shipped", "programs", "variables", "water", "objects", "touch")


@dataclass(frozen=True)
class ForceEntries:
    """All forces of one kind."""

    kind: ForceKind
    names: tuple[str | ShapePair, ...]  # in the scene, sorted by body, those between two twice; or what may touch
    start: tuple[int, ...] = ()  # (bodies + 1,) which of them act on each body, or on the joint that carries it
    other: tuple[int, ...] = ()  # of each between two bodies: the other one
    second: tuple[int, ...] = ()  # 1 if it acts on the second of both
    ends: tuple[tuple[int, int], ...] = ()  # both bodies of each pair that may touch
    objects: ObjectPlaces | None = None  # beside the character, where these are they

    @property
    def devices(self) -> tuple[str, ...]:
        """Those whose power recordings have, each once."""
        if not self.kind.device:
            return ()
        second = self.second or (0,) * len(self.names)
        return tuple(str(name) for name, end in zip(self.names, second, strict=True) if end == 0)


def force_kinds(scene: Scene, names: Topology) -> tuple[ForceEntries, ...]:
    """The forces of a checked scene by their kinds, in the order in which they are added.

    Raises:
        SceneError: there is no such kind, it cannot be used, or its parameters are not those of the scene.
    """
    found: dict[ForceKind, list[_Acting]] = {}
    for name, force in scene.forces.items():
        key = f"forces.{name}"
        kind = _kind(force.type, "effort" if force.joint else "wrench", f"{key}.type")
        place = "joint" if kind.effort is not None else "body"
        check_place(force, place, key, kind.pair is not None)
        if kind.of_leg:
            check_leg(scene, force.joint, f"{key}.joint")
        acts_on = getattr(force, place)
        check_values(kind.parameters, force.parameters, f"{key}.parameters", kind.programs)
        if kind.positive:
            check_positive(Checks(scene), kind.positive, force, key)
        body = names.body_of_joint(acts_on) if place == "joint" else names.bodies.index(acts_on)
        acting = found.setdefault(kind, [])
        if kind.pair is None:
            acting.append(_Acting(body, name))
        else:
            acting += _both_ways(name, body, names.bodies.index(force.other_body))
    entries = [_entries(kind, acting, names) for kind, acting in found.items()]
    return (*entries, *_touching(scene, names), *_objects(scene, names), *_water(scene, names))


def _water(scene: Scene, names: Topology) -> Iterator[ForceEntries]:
    """The water that bodies are in, where a scene has some."""
    if scene.water is not None:
        yield ForceEntries(ForceKind(water=True, shipped=True), (), part_starts(scene, names))


def _objects(scene: Scene, names: Topology) -> Iterator[ForceEntries]:
    """The objects of a scene, where it has some."""
    if scene.objects:
        yield ForceEntries(objects_kind(scene), tuple(scene.objects), objects=object_places(scene, names))


def _touching(scene: Scene, names: Topology) -> Iterator[ForceEntries]:
    """Contact of bodies with each other, where a scene has it."""
    pairs = shape_pairs(scene)
    if pairs:
        ends = tuple((names.bodies.index(pair.first), names.bodies.index(pair.second)) for pair in pairs)
        yield ForceEntries(contact_kind(scene), pairs, ends=ends)


class _Acting(NamedTuple):
    """A force on a body, and of one between two bodies, the other one and which of both this is."""

    body: int
    name: str
    other: int = 0
    second: int = 0


def _both_ways(name: str, body: int, other: int) -> list[_Acting]:
    return [_Acting(body, name, other, 0), _Acting(other, name, body, 1)]


def _entries(kind: ForceKind, acting: list[_Acting], names: Topology) -> ForceEntries:
    acting = sorted(acting, key=lambda one: one.body)
    start = [sum(one.body < i for one in acting) for i in range(len(names.bodies) + 1)]
    both = [(one.other, one.second) for one in acting] if kind.pair is not None else []
    other, second = zip(*both, strict=True) if both else ((), ())
    return ForceEntries(kind, tuple(one.name for one in acting), tuple(start), other, second)


def _kind(entry: str, alone: str, key: str) -> ForceKind:
    """The kind of forces of a name, shipped or `module:name`; `alone` is what a function by itself is of it."""
    if ":" not in entry:
        return shipped(entry)
    given = declared(entry, key, ForceKind)
    kind = given if isinstance(given, ForceKind) else ForceKind(**{alone: given})
    check_fields(kind, SHIPPED_ONLY, entry, key)
    _check(kind, FUNCTIONS, entry, key)
    return kind


@cache
def shipped(name: str) -> ForceKind:
    """A shipped kind, which is looked at as others are: whoever adds one is told what it lacks."""
    kind: ForceKind = FORCES[name]
    _check(kind, SHIPPED_FUNCTIONS, name, "FORCES of kernels/force/devices.py")
    return kind


def _check(kind: ForceKind, functions: dict[str, tuple[tuple[Any, ...], Any]], entry: str, key: str) -> None:
    """SceneError unless a kind has one function, which takes what it declares.

    Args:
        functions: those that it may have, what each takes, and returns. key: where it is named.
    """
    if sum(getattr(kind, name) is not None for name in functions) > 1:
        raise SceneError(f"{entry!r} has both functions: make two forces of it", key=key)
    check_declaration(kind, functions, entry, key, PHASES if functions is FUNCTIONS else {})
    names = [] if kind.parameters is None else list(kind.parameters.vars)
    if not isinstance(kind.positive, tuple):
        raise SceneError(f"what is positive of {entry!r} must be a tuple of names of parameters", key=key)
    for name in kind.positive:
        known(name, names, "parameter", key, f"in what is positive of {entry!r}")
    if kind.device and kind.state:
        raise SceneError(f"{entry!r} has a state, so that its power cannot be recorded: leave `device` out", key=key)
