"""How the chain of a model changes with the size of its bodies and the places of its markers on them.

All lengths of a chain are linear in the factors of its bodies, and turns do not depend on them. So one chain for each
factor, made of the model with that one changed, tells all derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.pose import rotate
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build import build
from warpmuscle.formats.osim.placement import vector
from warpmuscle.formats.osim.records import Model
from warpmuscle.formats.osim.scale import scaled_model
from warpmuscle.inverse.chain import Chain, evaluate, plain_chain
from warpmuscle.scene.joints.symmetry import counterpart

AXES = 3


@dataclass(frozen=True)
class Sizes:
    """Factors of bodies, and how far markers are from where the model has them."""

    factors: Floats  # (G, 3) along x, y and z of the bodies of each group
    offsets: Floats  # (K, 3) m, in the axes of the marker's frame, before the model is scaled by nothing else


class SizedChain:
    """A model whose bodies may have another size, without muscles and forces.

    Args:
        markers: names of those that count. symmetric: whether left and right have the same factors.
    """

    def __init__(self, model: Model, markers: list[str], symmetric: bool) -> None:
        self.model = replace(model, muscles=[], forces=[], surfaces={}, contacts={}, lost=[], lost_shapes={})
        self.markers = markers
        self.groups = grouped([body.name for body in model.bodies], symmetric)
        usual = self.chain(self.usual)
        self.derivatives = [self._change(usual, self._moved(group, axis)) for group, axis in self._factors()]
        self._frames = self._marker_frames(usual)

    @property
    def usual(self) -> Sizes:
        """The model as it is."""
        return Sizes(np.ones((len(self.groups), AXES)), np.zeros((len(self.markers), AXES)))

    def factors(self, sizes: Sizes) -> dict[str, Floats]:
        """Factors by body."""
        return {name: sizes.factors[k] for k, group in enumerate(self.groups) for name in group}

    def sized(self, model: Model, sizes: Sizes, mass: float | None = None, keep: bool = False) -> Model:
        """A model with bodies of these sizes, and markers so far from where they then are."""
        found = scaled_model(model, self.factors(sizes), mass, keep)
        offsets = dict(zip(self.markers, sizes.offsets, strict=True))
        found.markers = [
            replace(one, location=vector(np.asarray(one.location) + offsets.get(one.name, 0.0)))
            for one in found.markers
        ]
        return found

    def chain(self, sizes: Sizes) -> Chain:
        """The chain of the model with bodies of these sizes."""
        return plain_chain(build(self.sized(self.model, sizes), Notes()))

    def by_factor(self, poses: tuple[Floats, Floats], values: Floats) -> Floats:
        """Velocities (F, K, 3, G * 3) of the markers by a unit of each factor, at coordinates (F, C)."""
        turns = poses[0]
        count = len(self.derivatives)
        elements = self._usual_elements
        origin = np.zeros((len(values), len(elements), AXES, count))
        for k, one in enumerate(elements):
            offset = np.stack([change[0][k] for change in self.derivatives], axis=1)  # (3, P)
            if one.parent >= 0:
                origin[:, k] = origin[:, one.parent] + _matrices(turns[:, one.parent]) @ offset
            else:
                origin[:, k] = offset
            if not one.turns:
                q = values[:, one.coordinate] if one.coordinate >= 0 else np.zeros(len(values))
                amount = np.stack([evaluate(change[1][k], q)[0] for change in self.derivatives], axis=1)
                axis = np.broadcast_to(one.axis, (len(values), 3))
                axis = rotate(turns[:, one.parent], axis) if one.parent >= 0 else axis
                origin[:, k] += axis[:, :, None] * amount[:, None]
        found = np.zeros((len(values), len(self.markers), AXES, count))
        for m, element in enumerate(self._marker_elements):
            point = np.stack([change[2][m] for change in self.derivatives], axis=1)
            found[:, m] = point if element < 0 else origin[:, element] + _matrices(turns[:, element]) @ point
        return found

    def by_offset(self, poses: tuple[Floats, Floats]) -> Floats:
        """Axes (F, K, 3, 3) along which each marker moves with its own offsets, ground axes of scenes."""
        frames = len(poses[0])
        found = np.empty((frames, len(self.markers), AXES, AXES))
        for m, element in enumerate(self._marker_elements):
            found[:, m] = self._frames[m] if element < 0 else _matrices(poses[0][:, element]) @ self._frames[m]
        return found

    def _factors(self) -> list[tuple[int, int]]:
        return [(group, axis) for group in range(len(self.groups)) for axis in range(AXES)]

    def _moved(self, group: int, axis: int) -> Chain:
        sizes = self.usual
        sizes.factors[group, axis] += 1.0
        return self.chain(sizes)

    def _change(self, usual: Chain, moved: Chain):  # type: ignore[no-untyped-def]
        """What a unit of a factor changes: offsets of elements, functions of shifts, points of markers."""
        self._usual_elements = usual.elements
        self._marker_elements = [usual.markers[name].element for name in self.markers]
        pairs = list(zip(usual.elements, moved.elements, strict=True))
        offsets = [b.offset - a.offset for a, b in pairs]
        functions = [(a.function[0], b.function[1] - a.function[1]) for a, b in pairs]
        points = [moved.markers[name].point - usual.markers[name].point for name in self.markers]
        return offsets, functions, points

    def _marker_frames(self, usual: Chain) -> list[Floats]:
        """Axes (3, 3) of the frame of each marker, as columns in those of its element."""
        columns = []
        for axis in range(AXES):
            sizes = self.usual
            sizes.offsets[:, axis] += 1.0
            moved = self.chain(sizes)
            columns.append([moved.markers[name].point - usual.markers[name].point for name in self.markers])
        return [np.stack([column[m] for column in columns], axis=1) for m in range(len(self.markers))]


def grouped(bodies: list[str], symmetric: bool) -> list[list[str]]:
    """Bodies that have the same factors: each alone, or with its counterpart on the other side."""
    groups: list[list[str]] = []
    for name in bodies:
        other = counterpart(name, bodies) if symmetric else ""
        if any(name in group for group in groups):
            continue
        groups.append([name, other] if other else [name])
    return groups


def _matrices(turns: Floats) -> Floats:
    """Rotations (F, 3, 3) of quaternions (F, 4)."""
    return np.stack([rotate(turns, np.broadcast_to(unit, (len(turns), 3))) for unit in np.eye(3)], axis=2)
