"""What the builder of models and the room for states ask of a controller."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import warp as wp

from warpmuscle.kernels.control.control import ControllerKind
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import Topology

Zeros = Callable[..., wp.array]  # makes an array of a shape and dtype


def _no_fields(scene: Scene, names: Topology, device: Any) -> Mapping[str, Any]:
    return {}


def _no_arrays(scene: Scene, instances: int, names: Topology, zeros: Zeros) -> Mapping[str, wp.array]:
    return {}


def _no_start(scene: Scene) -> Mapping[str, int]:
    return {}


class Entry(NamedTuple):
    """A controller, or what is added to one.

    Attributes:
        name: what it is called. applies: whether a scene has it, (scene, simulated muscles).
        compiled: (what is compiled in of those before it in the table, scene) -> the same with it.
        fields: (scene of numbers, names, device) -> its part of the model, by place in `kernels.structs.Model`.
        state: (scene, instances, names, zeros) -> arrays, by place in `kernels.structs.State`.
        start: (scene) -> what these start from, where it is not 0.
        recorded: places in `kernels.structs.Record` that it writes.
    """

    name: str
    applies: Callable[[Scene, Sequence[str]], bool]
    compiled: Callable[[ControllerKind, Scene], ControllerKind]
    fields: Callable[[Scene, Topology, Any], Mapping[str, Any]] = _no_fields
    state: Callable[[Scene, int, Topology, Zeros], Mapping[str, wp.array]] = _no_arrays
    start: Callable[[Scene], Mapping[str, int]] = _no_start
    recorded: tuple[str, ...] = ()
