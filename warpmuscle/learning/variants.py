"""Bodies that differ: masses, strengths, slopes and commands of the scene, drawn once; every episode has one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.kernels import structs
from warpmuscle.learning.starts import RowTable
from warpmuscle.scene import Command, Scene
from warpmuscle.scene.joints.symmetry import side_of
from warpmuscle.scene.learning import Variation
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.perturbations import with_masses, with_strengths
from warpmuscle.simulation.rollout import Rollout

NAMES = ("slope", "mass", "strength")  # what a critic sees of a variant
SIDES = ("left", "right", "")  # of muscles, the last of those that are of none
OF_SIDES = ("left_strength", "right_strength")  # what a critic sees besides where sides differ
SEED = 0  # of what is drawn: the same variants for every batch and training
SLOPE_SCALE = 10.0  # 1/rad, of what a critic sees


class Variants:
    """The variants of a batch.

    Attributes:
        count: how many; 1 if all instances are alike. model: the batch's, with a row for each instance of what differs.
        names: of what describes them. described: (count, names) on the device.
    """

    def __init__(self, variation: Variation, rollout: Rollout) -> None:
        """Draw them and make room."""
        differ = bool(
            variation.mass or variation.strength or variation.side_strength or variation.slope or variation.commands
        )
        of_sides = OF_SIDES if variation.side_strength else ()
        self.count, self.names = 1, (*NAMES, *variation.commands, *of_sides) if differ else ()
        self.model = rollout.model
        self.described = wp.zeros((1, 1), dtype=float, device=rollout.device)
        self._table: RowTable | None = None
        if not differ:
            return
        self.count = max(variation.variants, 2)  # so that they have rows
        mass, strength, slope, sides = drawn(variation, rollout, self.count)
        commands = drawn_commands(variation, rollout.scene, self.count)
        described = [SLOPE_SCALE * slope, mass.mean(axis=1) - 1.0, strength.mean(axis=1) - 1.0]
        described += [_relative(values, rollout.scene.commands[name]) for name, values in commands.items()]
        described += [sides[:, k] - 1.0 for k in range(len(of_sides))]
        self.described = to_device(np.stack(described, axis=1), float, rollout.device)
        numeric = substitute(rollout.scene, start_values(rollout.scene), commands) if commands else rollout.numeric
        numeric = with_masses(numeric, mass)
        if numeric.character.muscles:
            numeric = with_strengths(numeric, strength)
        self._every = every = rollout.varied_model(numeric, slope)  # kept, since tables know addresses alone
        self.model = structs.Model()
        self.model.assign(every)
        targets, sources = [], []
        for outer, name, varied in differing(rollout.model, every, self.model):
            shape = (max(rollout.instances, 2), *varied.shape[1:])
            own = wp.zeros(shape, dtype=varied.dtype, device=rollout.device)
            setattr(outer, name, own)
            targets.append(own)
            sources.append(varied)
        self._table = RowTable(targets, sources, rollout.device)

    def restore(self, mask: wp.array, variant: wp.array) -> None:
        """Let the instances of a mask be of these variants, (instances,)."""
        if self._table is not None:
            self._table.restore(mask, variant)


def drawn(variation: Variation, rollout: Rollout, count: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Factors on masses (count, bodies) and strengths (count, muscles), slopes (count,), rad, and factors of `SIDES`.

    Those of sides, (count, 3), are in the strengths already.
    """
    generator = np.random.default_rng(SEED)
    names = rollout.numeric.character.muscles
    bodies, muscles = len(rollout.numeric.character.bodies), max(len(names), 1)
    mass = 1.0 + variation.mass * generator.uniform(-1.0, 1.0, (count, bodies))
    strength = 1.0 + variation.strength * generator.uniform(-1.0, 1.0, (count, muscles))
    slope = variation.slope * generator.uniform(-1.0, 1.0, count)
    sides = np.ones((count, len(SIDES)))
    if variation.side_strength:
        sides += variation.side_strength * generator.uniform(-1.0, 1.0, (count, len(SIDES)))
        strength *= sides[:, [SIDES.index(side_of(name, names)) for name in names] or [0]]
    return mass, strength, slope, sides


def drawn_commands(variation: Variation, scene: Scene, count: int) -> dict[str, Floats]:
    """Commands of the scene (count,) by name: of half of the variants drawn, of the others as the scene has them.

    Variants that are graded by one of them come in its order, that nearest to its reference first.
    """
    generator = np.random.default_rng(SEED + 1)
    found = {}
    for name in variation.commands:
        command = scene.commands[name]
        values, changed = generator.uniform(command.min, command.max, count), generator.uniform(size=count) < 0.5
        found[name] = np.where(changed, values, command.asked)
    if variation.graded:
        easy = np.argsort(np.abs(found[variation.graded] - scene.commands[variation.graded].reference), kind="stable")
        found = {name: values[easy] for name, values in found.items()}
    return found


def _relative(values: Floats, command: Command) -> Floats:
    """How far values of a command are from its reference, of its range."""
    return np.asarray((values - command.reference) / max(command.max - command.min, 1e-9))


def differing(shared: Any, varied: Any, copy: Any) -> Iterator[tuple[Any, str, wp.array]]:
    """Arrays of which the second of two structures has more rows: their owner in a third one, their name, and they."""
    for name in shared._cls.vars:
        one, many = getattr(shared, name), getattr(varied, name)
        if isinstance(one, wp.array):
            if one.shape[1:] == many.shape[1:] and len(one) == 1 < len(many):
                yield copy, name, many
        elif hasattr(one, "_cls"):
            yield from differing(one, many, getattr(copy, name))
