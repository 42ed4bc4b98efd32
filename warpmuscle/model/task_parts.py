"""Parts of one's own of what a policy learns: observations, rewards, goals, starts, ends of episodes, a curriculum."""

from __future__ import annotations

from typing import Any, NamedTuple

import warp as wp

from warpmuscle.core.errors import SceneError
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.objective.declaration import Declaration, Stage
from warpmuscle.model.part_checks import (
    IN_STEP,
    INSTANCE,
    Found,
    check_parameters,
    declared_arguments,
    found_part,
    takes,
)
from warpmuscle.model.user_functions import arguments_of, check_result, name_of, placed, signature, undeclared
from warpmuscle.scene import Scene
from warpmuscle.scene.trusted_code import check_trusted

DRAW = (*INSTANCE, Decision, wp.uint32)


class Use(NamedTuple):
    """What a part of a task may be."""

    what: str
    key: str  # of a scene, that names it
    results: tuple[Any, ...]  # that its function may return
    draws: bool = False  # whether it is given random numbers


REWARD = Use("a reward", "learning.rewards.custom", (wp.float32,))
OBSERVATION = Use("an observation", "learning.observations", (wp.float32, wp.vec3))
GOAL = Use("a goal", "learning.goals", (wp.float32, wp.vec3), draws=True)
START = Use("a start", "learning.variation.start", (None,), draws=True)
END = Use("an end of an episode", "learning.ends", (bool,))
CURRICULUM = Use("a curriculum", "learning.curriculum", (wp.float32,))
USES = (REWARD, OBSERVATION, GOAL, START, END, CURRICULUM)


def reward_parts(scene: Scene) -> dict[str, Declaration]:
    """Rewards of one's own, by `module:name`, be they summed in the step or evaluated at a decision."""
    if scene.learning is None:
        return {}
    named = [name for name in scene.learning.rewards.custom if ":" in name]
    stages: tuple[Stage, ...] = (*IN_STEP, "decision")
    return {name: found_part(name, f"learning.rewards.custom.{name}", stages) for name in named}


def rewards_of_steps(scene: Scene) -> tuple[str, ...]:
    """Names of the rewards that are terms of the objective, which a step sums up.

    Raises:
        SceneError: the scene names code that is not trusted, or that cannot be used.
    """
    check_trusted(scene)
    own = reward_parts(scene)
    names = () if scene.learning is None else tuple(scene.learning.rewards.custom)
    return tuple(name for name in names if name not in own or own[name].stage != "decision")


def task_parts(scene: Scene) -> dict[str, Found]:
    """Parts of one's own that are evaluated at decisions or where episodes begin, by the key that names them.

    Raises:
        SceneError: as `parts.custom_parts`.
    """
    task = scene.learning
    if task is None:
        return {}
    named = [
        (f"learning.rewards.custom.{n}", n, REWARD) for n, p in reward_parts(scene).items() if p.stage == "decision"
    ]
    named += [(f"learning.observations.{name}", name, OBSERVATION) for name in task.observations if ":" in name]
    named += [(f"learning.goals.{name}.draw", goal.draw, GOAL) for name, goal in task.goals.items() if goal.draw]
    named += [(f"learning.ends.{index}", entry, END) for index, entry in enumerate(task.ends)]
    named += [("learning.curriculum", task.curriculum, CURRICULUM)] if task.curriculum else []
    named += [("learning.variation.start", task.variation.start, START)] if task.variation.start else []
    return {key: _found(scene, key, entry, use) for key, entry, use in named}


def _found(scene: Scene, key: str, entry: str, use: Use) -> Found:
    """One of them, checked."""
    part = found_part(entry, key, ("decision",))
    arguments, own = arguments_of(part.function), declared_arguments(part)
    bases = {"draw": DRAW} if use.draws else {"decision": (*INSTANCE, Decision), "instance": INSTANCE}
    fitting = [base for base, wanted in bases.items() if takes(arguments, wanted, own)]
    if not fitting:
        more = "".join(f" [, {name_of(kind)}]" for kind in own)
        wanted = signature(DRAW) if use.draws else f"{signature(INSTANCE)} [, Decision]"
        found = f"{placed(part.function, entry)} takes {signature(arguments)}{undeclared(arguments, own)}"
        raise SceneError(f"{use.what} takes {wanted}{more}, but {found}", key=key)
    check_parameters(scene, entry, part, "decision")
    result = check_result(part.function, use.results, key, entry)
    return Found(entry, "decision", part, fitting[0], float if result is wp.float32 else result)
