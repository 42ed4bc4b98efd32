"""Scenes that differ in numbers alone as one scene of a batch, whose instances have bodies of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import is_number
from warpmuscle.kernels.moved import of_former_names
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import at_start, leaves, rebuilt


def batch_scene(scenes: Sequence[Scene]) -> Scene:
    """One scene of numbers, with (n,) arrays where n scenes differ: what `Rollout.change` takes.

    Free parameters count with their start values.

    Raises:
        SceneError: there are none, or they differ in more than numbers; times of the whole simulation may not differ.
    """
    if not scenes:
        raise SceneError("there are no scenes to put together")
    plain = [dict(leaves(at_start(scene))) for scene in scenes]
    first = plain[0]
    differing: dict[str, Any] = {}
    for number, other in enumerate(plain[1:], start=1):
        if other.keys() != first.keys():
            key = min(other.keys() ^ first.keys())
            raise SceneError(f"scene {number} differs from the first one in more than numbers", key=key)
        for path, leaf in other.items():
            if path in ("name", "description") or _same(leaf, first[path]):
                continue
            if not is_number(leaf) or not is_number(first[path]) or path in ("duration", "time_step", "control_rate"):
                raise SceneError(f"scene {number} differs from the first one in more than numbers", key=path)
            differing[path] = None
    for path in differing:
        differing[path] = np.array([one[path] for one in plain], dtype=np.float64)
    return rebuilt(at_start(scenes[0]), lambda path, leaf: differing.get(path, leaf))


def _same(one: Any, other: Any) -> bool:
    return type(one) is type(other) and bool(one == other)


if not TYPE_CHECKING:
    __getattr__ = of_former_names(__name__, {"together": "batch_scene"})  # of before
