"""Functions of a user's that read what only one controller has, in scenes that have another one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.model.user_functions import named_object
from warpmuscle.scene import Scene
from warpmuscle.scene.trusted_code import named_code


def check_reads(scene: Scene) -> None:
    """SceneError if a function that a scene names reads the state of a simbicon controller, and there is none.

    All that it names has been found before. What functions read that these call is not looked at.
    """
    if scene.simbicon is not None:
        return
    for key, entry in named_code(scene).items():
        for function in _functions(named_object(entry)):
            code = function.func.__code__
            if "simbicon" in code.co_names:
                place = f"{entry!r} ({code.co_filename}:{code.co_firstlineno})"
                raise SceneError(f"{place} reads `state.simbicon`, and the scene has no simbicon controller", key=key)


def _functions(declared: Any) -> Iterator[wp.Function]:
    """The Warp functions of what a module declares, or the function that it is."""
    parts = declared if isinstance(declared, tuple) else (declared,)
    yield from (part for part in parts if isinstance(part, wp.Function) and part.func is not None)
