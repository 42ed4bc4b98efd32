"""Checks of what a search is about: objective, limits of failure, disturbed runs, and the stages that change them."""

from __future__ import annotations

import fnmatch

import msgspec
import numpy as np

from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.scene import Failure, Objective, Robustness, Scene, SearchStage
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.norms import LEG_ANGLES, NORM_TERMS
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.stage_scene import freed
from warpmuscle.scene.validation.checks import Checks, join, known, near


def check_objective(checks: Checks, key: str, objective: Objective) -> None:
    """What the weights weigh exists."""
    scene = checks.checked
    for joint in objective.torque_by_joint:
        known(joint, scene.character.joints, "joint", f"{key}.torque_by_joint.{joint}")
    if objective.metabolic_model == "margaria" and objective.metabolic_work == "net":
        message = "Margaria's formula itself says what lengthening fibres cost; leave this out"
        raise SceneError(message, key=f"{key}.metabolic_work")
    if objective.head:
        known(objective.head_body, scene.character.bodies, "body", f"{key}.head_body")
    for name in ("tracking", *sorted(NORM_TERMS), "step_width", "stride_speed"):
        if checks.interval(getattr(objective, name))[1] > 0.0:
            check_needs(scene, name, f"{key}.{name}")
    for index, name in enumerate(objective.reported):
        if ":" not in name:
            known(name, TERMS, "term", f"{key}.reported.{index}")
            check_needs(scene, name, f"{key}.reported.{index}")


def sign_warnings(scene: Scene) -> list[SceneError]:
    """Negative weights of terms of one's own: errors that are not raised, so that a reader can give them a place."""
    found = []
    for name, weight in scene.objective.custom.items():
        lowest = (weight.value if weight.min is None else weight.min) if isinstance(weight, Free) else weight
        if lowest is not None and np.any(np.asarray(lowest) < 0.0):
            message = (
                'a negative weight turns the sign round: declare sign="earned", or "cost", and give a positive weight'
            )
            found.append(SceneError(message, key=f"objective.custom.{name}"))
    return found


def check_needs(scene: Scene, term: str, key: str) -> None:
    """SceneError unless a scene has what a shipped term compares with."""
    if term == "tracking" and scene.tracking is None:
        raise SceneError("there is no gait to track: name one in [tracking]", key=key)
    if term in NORM_TERMS:
        _check_legs(scene, key)
    if term == "norm_moments" and scene.objective.gait == "run" and scene.norms is None:
        raise SceneError("there are norms of joint moments for walking only, but objective.gait is a run", key=key)
    if term in ("step_width", "stride_speed") and scene.feet is None:
        what = "steps have a width" if term == "step_width" else "strides have a speed"
        raise SceneError(f"there are no feet whose {what}", key=key)


def _check_legs(scene: Scene, key: str) -> None:
    """There is something to compare with human legs: two feet, on legs of three joints at least."""
    if scene.feet is None:
        raise SceneError("there are no feet whose steps could be compared with human walking", key=key)
    for side, foot in enumerate(scene.feet):
        joints = leg_joints(scene, side)
        if len(joints) < len(LEG_ANGLES):
            raise SceneError(
                f"{foot!r} has no hip, knee and ankle: {number_of(len(joints), 'joint')} on the way to it", key=key
            )


def check_robustness(key: str, robustness: Robustness) -> None:
    """At least one run; masses stay above nothing."""
    if robustness.runs < 1:
        raise SceneError(f"must be 1 at least, is {robustness.runs}", key=f"{key}.runs")
    if robustness.mass >= 1.0:
        raise SceneError(f"must be less than 1, is {robustness.mass:g}", key=f"{key}.mass")


def check_stages(checks: Checks) -> None:
    """Stages have names of their own, free something, and change what there is to something possible."""
    names: list[str] = []
    for index, stage in enumerate(checks.checked.stages):
        key = f"stages.{index}"
        if not stage.name.strip():
            raise SceneError("a stage needs a name", key=f"{key}.name")
        if stage.name in names:
            raise SceneError(f"stage {names.index(stage.name)} is called {stage.name!r} already", key=f"{key}.name")
        names.append(stage.name)
        _check_stage(checks, key, stage)


def _check_stage(checks: Checks, key: str, stage: SearchStage) -> None:
    scene = checks.checked
    to_type(dict(stage.objective), Objective, f"{key}.objective")  # names and kinds of its fields
    to_type(dict(stage.failure), Failure, f"{key}.failure")
    to_type(dict(stage.robustness), Robustness, f"{key}.robustness")
    objective = msgspec.structs.replace(scene.objective, **stage.objective)
    robustness = msgspec.structs.replace(scene.robustness, **stage.robustness)
    checks.ranges(f"{key}.objective", objective)
    checks.ranges(f"{key}.failure", msgspec.structs.replace(scene.failure, **stage.failure))
    checks.ranges(f"{key}.robustness", robustness)
    check_objective(checks, f"{key}.objective", objective)
    check_robustness(f"{key}.robustness", robustness)
    if stage.duration is not None and stage.duration < scene.time_step:
        raise SceneError(f"is shorter than the time step {scene.time_step:g}", key=join(key, "duration"))
    if stage.candidates is not None and stage.candidates > 1.0 and not float(stage.candidates).is_integer():
        raise SceneError(f"{stage.candidates:g} is neither a whole number nor a part below 1", key=f"{key}.candidates")
    _check_patterns(checks, key, stage)


def _check_patterns(checks: Checks, key: str, stage: SearchStage) -> None:
    """Every pattern means something; a scene without free parameters has nothing that they could mean."""
    names = [parameter.name for parameter in free_parameters(checks.checked)]
    for index, pattern in enumerate(stage.free if names else ()):
        if not any(fnmatch.fnmatchcase(name, pattern) for name in names):
            raise SceneError(
                f"no free parameter matches {pattern!r}{near(pattern, _patterns(names))}", key=f"{key}.free.{index}"
            )
    if names and not freed(checks.checked, stage):
        raise SceneError("everything that this stage frees is also set by it; free something else", key=f"{key}.free")


def _patterns(names: list[str]) -> list[str]:
    """The names, and patterns for what begins alike."""
    parts = [name.split(".") for name in names]
    prefixes = (".".join(part[:depth]) for part in parts for depth in range(1, len(part)))
    return list(dict.fromkeys([*names, *(f"{prefix}.*" for prefix in prefixes)]))
