"""Observations and actions of a body's mirror image: which number becomes which, with which sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.learning import senses as kernels
from warpmuscle.learning.senses import About, Number
from warpmuscle.learning.variants import OF_SIDES
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.joints.symmetry import TURN, VECTOR, check_muscles, counterpart, joint_image
from warpmuscle.simulation.rollout import Rollout


class Image(NamedTuple):
    """The image of a row of numbers: those at `place`, times `sign`, plus `shift`, three arrays of its length."""

    place: Integers
    sign: Floats
    shift: Floats

    def of(self, values: Floats) -> Floats:
        """Of numbers (..., N)."""
        return np.asarray(values[..., self.place] * self.sign + self.shift)


class Images(NamedTuple):
    """Of what a policy and a critic observe, and of actions."""

    observation: Image
    critic: Image
    action: Image


class BodySymmetry:
    """Which coordinates, speeds and muscles of a batch are each other's image, with their signs."""

    def __init__(self, rollout: Rollout) -> None:
        """Find them; raises SceneError for a scene that is not its own mirror image."""
        character = rollout.numeric.character
        self.coordinates: dict[str, tuple[str, float]] = {}
        self.speeds: dict[str, tuple[str, float]] = {}
        for name in rollout.names.joints:
            image, kind = joint_image(character, name), joint_type(character.joints[name])
            for table, words, signs in (
                (self.coordinates, kind.coordinates, image.coordinates),
                (self.speeds, kind.speeds, image.speeds),
            ):
                for word, sign in zip(words, signs, strict=True):
                    table[_named(name, word)] = (_named(image.name, word), float(sign))
        muscles = character.muscles
        self.muscles = {name: (counterpart(name, muscles) or name, 1.0) for name in muscles}
        check_muscles(character)


def _named(joint: str, word: str) -> str:
    return f"{joint}.{word}" if word else joint


Found = tuple[int, float, float]  # place of its kind, sign, shift
Rule = Callable[[int], Found]


def observed_image(numbers: Sequence[Number], about: About, body: BodySymmetry, action: Image) -> Image:
    """The image of observed numbers, of which some may be actions.

    Raises:
        SceneError: the image of one of them is not observed.
    """
    rules = _rules(about, body, action)
    where = {(number.kind, number.place, number.ago): k for k, number in enumerate(numbers)}
    found = []
    for number in numbers:
        if number.kind not in rules:
            raise SceneError(f"nobody knows the mirror image of {number.name!r}", key="learning.symmetric")
        place, sign, shift = rules[number.kind](number.place)
        if (number.kind, place, number.ago) not in where:
            raise SceneError(f"the mirror image of {number.name!r} is not observed", key="learning.symmetric")
        found.append((where[number.kind, place, number.ago], sign, shift * number.scale))
    return image_of(found)


def action_image(kind: str, names: Sequence[str], middle: Floats, scale: float, body: BodySymmetry) -> Image:
    """The image of actions.

    Args:
        kind: as of `Task.actions`. names: of the numbers. middle: (A,) of targets, what an action of 0 means; else 0.
        scale: of targets.

    Raises:
        SceneError: the image of one of them is none of them.
    """
    known = {"excitation": body.muscles, "synergies": {name: (counterpart(name, names) or name, 1.0) for name in names}}
    table = known.get(kind, body.speeds)
    found = []
    for number, name in enumerate(names):
        other, sign = table[name]
        if other not in names:
            raise SceneError(f"the mirror image of {name!r} does not act", key="learning.symmetric")
        place = names.index(other)
        found.append((place, sign, (sign * float(middle[place]) - float(middle[number])) / scale))
    return image_of(found)


def image_of(found: Sequence[Found]) -> Image:
    """From place, sign and shift of every number."""
    place, sign, shift = zip(*found, strict=True)
    return Image(np.array(place, dtype=np.int64), np.array(sign, dtype=float), np.array(shift, dtype=float))


def _rules(about: About, body: BodySymmetry, action: Image) -> Mapping[int, Rule]:
    """By the kind of a number: from its place to that of its image."""
    rollout = about.rollout
    muscles = rollout.structure.actuation.muscles
    coordinates, speeds = rollout.coordinate_names, rollout.speed_names

    def same(place: int) -> Found:
        return place, 1.0, 0.0

    def along(signs: Floats) -> Rule:
        return lambda place: (place, float(signs[place]), 0.0)

    def named(names: Sequence[str], table: Mapping[str, tuple[str, float]]) -> Rule:
        def rule(place: int) -> Found:
            other, sign = table[names[place]]
            return (names.index(other) if other in names else -1), sign, 0.0

        return rule

    def foot(place: int) -> Found:
        return (place + 3) % 6, float(VECTOR[place % 3]), 0.0

    def acted(place: int) -> Found:
        return int(action.place[place]), float(action.sign[place]), float(action.shift[place])

    def varied(place: int) -> Found:
        if about.varied[place] in OF_SIDES:
            return place + 1 - 2 * OF_SIDES.index(about.varied[place]), 1.0, 0.0
        return place, 1.0, 0.0

    signs = {"speed": ("speed", 1.0), "turning_rate": ("turning_rate", -1.0)} | body.coordinates
    fibre = named(muscles, body.muscles)
    return {
        kernels.HEIGHT: same, kernels.UP: along(VECTOR), kernels.VELOCITY: along(VECTOR),
        kernels.ANGULAR_VELOCITY: along(TURN), kernels.HEAD_UP: along(VECTOR),
        kernels.HEAD_ANGULAR_VELOCITY: along(TURN), kernels.FOOT_FORCE: foot,
        kernels.COORDINATE: named(coordinates, body.coordinates), kernels.JOINT_SPEED: named(speeds, body.speeds),
        kernels.ACTIVATION: fibre, kernels.FIBRE_LENGTH: fibre, kernels.FIBRE_VELOCITY: fibre,
        kernels.FIBRE_FORCE: fibre, kernels.COMMAND: named(about.commands, signs),
        kernels.COURSE: along(np.array([-1.0, 1.0, -1.0])), kernels.ACTION: acted,
        kernels.PHASE: same, kernels.STANCE: lambda place: (place, -1.0, 1.0), kernels.PUSH_FORCE: along(VECTOR),
        kernels.GROUND: lambda place: (place + 2 - 2 * (place % 3), 1.0, 0.0), kernels.VARIED: varied,
        kernels.FOOTING: lambda place: (place + 1 - 2 * (place % 2), 1.0, 0.0),
        kernels.LATER: same, kernels.NOISIER: same,
        kernels.CLOCK: along(-np.ones(2)),  # half a cycle later
    }  # fmt: skip
