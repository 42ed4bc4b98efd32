"""What functions of parts of a task are given: random numbers where they draw, and nowhere else."""

from pathlib import Path

import pytest

from importing import importable_from
from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.model.task_parts import task_parts
from warpmuscle.scene.learning import Goal, Task, Variation
from warpmuscle.scene.trusted_code import trust

NAME = "drawing_parts"
WHOLE = "instance: int, model: Model, state: State, work: Scratch"
MODULE = f"""
import warp as wp

from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.structs import Model, Scratch, State


@wp.func
def drawn({WHOLE}, decision: Decision, random: wp.uint32) -> wp.vec3:
    return wp.vec3(0.0)


@wp.func
def begun({WHOLE}, decision: Decision, random: wp.uint32):
    model.gravity[0, 0] = model.gravity[0, 0]


@wp.func
def seen({WHOLE}, decision: Decision) -> wp.vec3:
    return wp.vec3(0.0)
"""


@pytest.mark.parametrize(
    ("task", "base"),
    [
        (Task(goals={"g": Goal(draw=f"{NAME}:drawn")}), "draw"),
        (Task(variation=Variation(start=f"{NAME}:begun")), "draw"),
        (Task(goals={"g": Goal(draw=f"{NAME}:seen")}), ""),
        (Task(variation=Variation(start=f"{NAME}:seen")), ""),
    ],
    ids=["goal", "start", "goal without chance", "start without chance"],
)
def test_goals_and_starts_are_given_random_numbers(task: Task, base: str, tmp_path: Path):
    (tmp_path / f"{NAME}.py").write_text(MODULE)
    scene = arm(learning=task)
    trust(scene)
    with importable_from(tmp_path):
        if base:
            assert [found.base for found in task_parts(scene).values()] == [base]
        else:
            with pytest.raises(SceneError, match=r"takes \(int, .*, Decision, uint32\), but"):
                task_parts(scene)
