"""Thousands of independent muscle-actuated bipeds at once, with NVIDIA Warp.

Example:
    import warpmuscle as wm

    rollout = wm.Rollout("fwalk", instances=100)
    rollout.run()
    print(rollout.cost(), rollout.status_names())
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from warpmuscle.errors import Error, ResultError, RolloutError, SceneError

if TYPE_CHECKING:
    from warpmuscle.formats import load, save
    from warpmuscle.gait import measure
    from warpmuscle.optimization import optimize, resume
    from warpmuscle.plots import plot
    from warpmuscle.recording import Recording
    from warpmuscle.records import Result
    from warpmuscle.result_scene import best_scene
    from warpmuscle.results import read, write
    from warpmuscle.rollout import Rollout
    from warpmuscle.scene import Scene
    from warpmuscle.split import SplitRollout, make_rollout
    from warpmuscle.stages import Stages
    from warpmuscle.status import Status
    from warpmuscle.trusted import trust

    __version__: str

__all__ = [
    "Error", "Recording", "Result", "ResultError", "Rollout", "RolloutError", "Scene", "SceneError",
    "SplitRollout", "Stages", "Status", "__version__", "best_scene", "load", "make_rollout", "measure", "optimize",
    "plot", "read", "resume", "save", "trust", "write",
]  # fmt: skip

_HOMES = {
    "Recording": "recording", "Result": "records", "Rollout": "rollout", "Scene": "scene",
    "SplitRollout": "split", "Stages": "stages", "Status": "status", "best_scene": "result_scene", "load": "formats",
    "make_rollout": "split", "measure": "gait", "optimize": "optimization", "plot": "plots", "read": "results",
    "resume": "optimization", "save": "formats", "trust": "trusted", "write": "results",
}  # fmt: skip


def __dir__() -> list[str]:
    """What the package offers, also what has not been imported yet."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def __getattr__(name: str) -> Any:
    """Import what is asked for; Warp takes a while, and reading a file or a help text needs none of it."""
    if name == "__version__":
        from warpmuscle.records import version_of

        return version_of("warpmuscle")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
