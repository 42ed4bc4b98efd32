"""Thousands of independent muscle-actuated bodies at once, with NVIDIA Warp.

Example:
    import warpmuscle as wm

    rollout = wm.Rollout("fwalk", instances=100)
    rollout.run()
    print(rollout.cost(), rollout.status_names())
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from warpmuscle.core.errors import Error, ResultError, RolloutError, SceneError

if TYPE_CHECKING:
    from warpmuscle.core.status import Status
    from warpmuscle.formats import load, save
    from warpmuscle.gait.measures import measure
    from warpmuscle.inverse.dynamics import inverse_dynamics
    from warpmuscle.inverse.kinematics import inverse_kinematics
    from warpmuscle.inverse.reactions.joint_reactions import joint_reactions
    from warpmuscle.inverse.reactions.run_reactions import run_reactions
    from warpmuscle.inverse.scaling import scale
    from warpmuscle.inverse.static_optimization import static_optimization
    from warpmuscle.inverse.tracking.track import track
    from warpmuscle.optimization.best_scene import best_scene
    from warpmuscle.optimization.evaluator import Evaluator
    from warpmuscle.plots import plot
    from warpmuscle.results.motion_files import append_motions, read_motions
    from warpmuscle.results.motions import Motions
    from warpmuscle.results.recording import Recording
    from warpmuscle.results.records import Result
    from warpmuscle.results.result import write
    from warpmuscle.results.sweeps import Sweep
    from warpmuscle.scene import Scene
    from warpmuscle.scene.trusted_code import trust
    from warpmuscle.session.conversion import convert
    from warpmuscle.session.results import optimize, read, resume
    from warpmuscle.session.runs import Run, simulate
    from warpmuscle.session.scene_table import scenes
    from warpmuscle.session.training import learn
    from warpmuscle.simulation.multi_device import MultiDeviceRollout, make_rollout
    from warpmuscle.simulation.program.solve import quadratic_program
    from warpmuscle.simulation.rollout import Rollout
    from warpmuscle.simulation.stages import Stages
    from warpmuscle.sweep.from_python import sweep
    from warpmuscle.view.notebook import show

    __version__: str

__all__ = [
    "Error", "Evaluator", "Motions", "MultiDeviceRollout", "Recording", "Result", "ResultError", "Rollout",
    "RolloutError", "Run", "Scene", "SceneError", "Stages", "Status", "Sweep", "__version__", "append_motions",
    "best_scene", "convert", "inverse_dynamics", "inverse_kinematics", "joint_reactions", "learn", "load",
    "make_rollout", "measure", "optimize", "plot", "quadratic_program", "read", "read_motions", "resume",
    "run_reactions", "save", "scale", "scenes", "show", "simulate", "static_optimization", "sweep", "track", "trust",
    "write",
]  # fmt: skip

_HOMES = {
    "append_motions": "results.motion_files", "best_scene": "optimization.best_scene",
    "convert": "session.conversion", "Evaluator": "optimization.evaluator", "inverse_dynamics": "inverse.dynamics",
    "inverse_kinematics": "inverse.kinematics", "joint_reactions": "inverse.reactions.joint_reactions",
    "learn": "session.training", "load": "formats",
    "make_rollout": "simulation.multi_device", "measure": "gait.measures", "Motions": "results.motions",
    "MultiDeviceRollout": "simulation.multi_device", "optimize": "session.results", "plot": "plots",
    "quadratic_program": "simulation.program.solve",
    "read": "session.results", "read_motions": "results.motion_files", "Recording": "results.recording",
    "Result": "results.records", "resume": "session.results", "Rollout": "simulation.rollout",
    "Run": "session.runs", "run_reactions": "inverse.reactions.run_reactions", "save": "formats",
    "scale": "inverse.scaling", "Scene": "scene.drawing.table",
    "scenes": "session.scene_table", "show": "view.notebook", "simulate": "session.runs",
    "Stages": "simulation.stages", "static_optimization": "inverse.static_optimization", "Status": "core.status",
    "Sweep": "results.sweeps", "sweep": "sweep.from_python", "track": "inverse.tracking.track",
    "trust": "scene.trusted_code", "write": "results.result",
}  # fmt: skip

_ELSEWHERE = {
    "run": "wm.simulate runs a scene",
    "open": "wm.read opens a result file, wm.load a scene or a model",
    "view": "wm.show shows a motion",
    "search": "wm.optimize searches",
    "train": "wm.learn trains a policy",
    "film": "a run's save('walk.mp4') makes a film",
    "video": "a run's save('walk.mp4') makes a film",
    "gait": "wm.measure(recording, scene) measures a gait, and a run has it as run.gait",
    "render": "wm.show shows a motion",
    "display": "wm.show shows a motion",
    "list_scenes": "wm.scenes() lists them",
    "models": "wm.scenes() lists the shipped scenes",
    "load_scene": "wm.load reads a scene or a model",
    "load_model": "wm.load reads a scene or a model",
    "from_osim": "wm.load reads a scene or a model",
    "help": "help(wm.simulate) and others of dir(wm) say what they take",
    "plots": "wm.plot draws",
    "learning": "wm.learn trains a policy",
    "gym": "import warpmuscle.gym, then gymnasium.make('warpmuscle/walk56-v0')",
    "export": "a run's save('walk.mot') writes OpenSim's files",
    "policy": "wm.simulate(scene, policy='policy.h5') acts by one, wm.learn trains one",
    "Policy": "wm.simulate(scene, policy='policy.h5') acts by one, wm.learn trains one",
    "judge": "`warpmuscle judge` of the command line is it",
    "report": "`warpmuscle report` of the command line is it",
    "ik": "wm.inverse_kinematics(model, 'walk.trc') finds coordinates from markers",
    "id": "wm.inverse_dynamics(model, coordinates, loads) finds moments",
    "so": "wm.static_optimization(model, coordinates, loads) finds muscles' activations",
    "cmc": "wm.track follows a recorded motion by muscles",
    "scene": "wm.load('walk56') reads a scene, wm.scenes() lists them",
    "Model": "wm.load reads a model, wm.simulate runs it",
    "Simulation": "wm.simulate runs a scene, wm.Rollout many at once",
    "Simulator": "wm.simulate runs a scene, wm.Rollout many at once",
    "animate": "wm.show shows a motion",
    "info": "`warpmuscle info SCENE` of the command line is it; print(wm.load(SCENE)) is shorter",
    "push": "`warpmuscle robustness` of the command line pushes, `warpmuscle view SCENE --live` by hand",
    "robustness": "`warpmuscle robustness` of the command line is it",
    "study": "`warpmuscle study` of the command line is it",
    "compare": "wm.plot([a, b], 'activation') draws several, wm.show([a, b]) shows them side by side",
    "moment_arms": "wm.plot(run, 'moment_arms') draws them",
    "step": "wm.Rollout(scene).step() does one",
    "rollout": "wm.Rollout(scene, instances=100) simulates many at once",
    "version": "wm.__version__ is it",
    **dict.fromkeys(("load_mujoco", "MjModel", "load_urdf", "OsimModel"), "wm.load reads a model, wm.simulate runs it"),
    **dict.fromkeys(
        ("viewer", "Viewer", "visualize", "launch", "launch_viewer", "gui"),
        "wm.show shows a motion, `warpmuscle view SCENE --live` runs one",
    ),
    **dict.fromkeys(("PPO", "ppo", "agent"), "wm.learn trains a policy"),
    **dict.fromkeys(("cma", "CMA", "cmaes"), "wm.optimize(scene, search='cma') searches"),
    **dict.fromkeys(("cuda", "get_device", "is_available", "gpu"), "wm.Rollout(scene).device says where it runs"),
    **dict.fromkeys(("examples", "load_example", "datasets", "data"), "wm.scenes() lists what comes with the package"),
    **dict.fromkeys(("describe", "summary"), "print(wm.load(SCENE)) says what it contains"),
    **dict.fromkeys(("muscles", "bodies", "joints"), "wm.load(SCENE).character has them"),
    **dict.fromkeys(("reset", "state", "load_state"), "wm.Rollout(scene) has it"),
    **dict.fromkeys(("moco", "Moco"), "wm.track follows a recorded motion, wm.optimize searches for one"),
    **dict.fromkeys(("read_osim", "load_osim", "from_file", "from_xml", "from_toml", "read_model"), "wm.load reads it"),
    **dict.fromkeys(
        ("make", "env", "envs", "Env", "Environment", "Environments", "make_env", "vec_env", "VecEnv", "Gym"),
        "import warpmuscle.gym, then gymnasium.make('warpmuscle/walk56-v0')",
    ),
    **dict.fromkeys(("device", "set_device", "devices"), "device='cuda:0' of wm.simulate and others names it"),
    **dict.fromkeys(("config", "options", "settings"), "each function has its options, a scene its numbers: set={...}"),
    **dict.fromkeys(("seed", "set_seed"), "wm.optimize(scene, seed=1) and wm.learn have one"),
    **dict.fromkeys(("minimize", "fit", "solve"), "wm.optimize searches"),
    **dict.fromkeys(("figure", "draw"), "wm.plot draws"),
    **dict.fromkeys(("read_mot", "read_sto", "load_mot"), "warpmuscle.inverse.files.read_coordinates reads motions"),
    "Declaration": "from warpmuscle.kernels.objective.declaration import Declaration",
    "Free": "from warpmuscle.scene.number import Free",
    "Parameter": "wm.Rollout(scene).parameters are the free ones",
    **dict.fromkeys(("Task", "Rewards"), "from warpmuscle.learning import Task, Rewards"),
    **dict.fromkeys(("Learned", "PolicyTable"), "wm.read('policy.h5').learned is a learnt policy"),
    "Controller": "wm.load(SCENE).controller is that of a scene",
    "read_trc": "wm.inverse_kinematics(model, 'walk.trc') takes the file",
    "load_trc": "wm.inverse_kinematics(model, 'walk.trc') takes the file",
    "inverse": "wm.inverse_kinematics, wm.inverse_dynamics and wm.static_optimization are its steps",
}


class _NoFunction(ModuleType):
    """A sub-package whose name somebody may take for a function's."""

    def __call__(self, *_: Any, **__: Any) -> None:
        name = self.__name__.rpartition(".")[2]
        raise TypeError(f"wm.{name} is a package, not a function{_instead(name)}")


class _Package(ModuleType):
    """This package, whose functions are not hidden by sub-packages of the same names, once these are imported."""

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(value, ModuleType) and name in _ELSEWHERE:
            value.__class__ = _NoFunction
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __dir__() -> list[str]:
    """What the package offers, also what has not been imported yet."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def _instead(name: str) -> str:
    """What to type in place of a name that there is not, as the end of a message."""
    if name in _ELSEWHERE:
        return f"; {_ELSEWHERE[name]}"
    from difflib import get_close_matches

    if not name.startswith("_") and name in import_module("warpmuscle.core.shipped").shipped_scenes():
        return f"; wm.simulate({name!r}) runs this scene, wm.load({name!r}) reads it"
    if name[:1].isupper() and name in import_module("warpmuscle.scene").__all__:
        return f"; wm.load(SCENE) has its parts, and `from warpmuscle.scene import {name}` is their class"
    found = [] if name.startswith("_") else get_close_matches(name, __all__, n=1)
    return f"; did you mean {found[0]!r}?" if found else ""


@contextmanager
def _no_garbage_search() -> Iterator[None]:
    """Let Python look for cycles of dead objects only after what is within, such as imports, of which nothing dies.

    It would look through all that there is again and again: a quarter of the time that the imports take.
    """
    searches = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if searches:
            gc.enable()


def __getattr__(name: str) -> Any:
    """Import what is asked for; Warp takes a while, and reading a file or a help text needs none of it."""
    if name == "__version__":
        from warpmuscle.results.records import version_of

        return version_of("warpmuscle")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{_instead(name)}")
    with _no_garbage_search():
        value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
