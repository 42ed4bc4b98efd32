"""What a search asks for where a scene weighs nothing: a gait at its speed; nothing else is touched."""

from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from small_result import walk_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.usual_objective import with_usual_objective
from warpmuscle.scene import Objective, Scene, SearchStage
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import pinned, start_values

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


def silent(name: str = "walk56", **changes) -> Scene:
    """A shipped scene that weighs nothing."""
    return msgspec.structs.replace(load(name), objective=Objective(target_speed=1.25), **changes)


@pytest.mark.parametrize(("name", "effort"), [("walk56", "cost_of_transport"), ("fwalk", "torque")])
def test_a_walk_that_weighs_nothing_is_asked_for_its_speed_at_little_effort(name: str, effort: str):
    asked = with_usual_objective(silent(name)).objective
    weights = {"speed": 200.0, "heading": 30.0, effort: 20.0 if effort == "cost_of_transport" else 0.02}
    assert asked == Objective(target_speed=1.25, **weights)


@pytest.mark.parametrize(
    "made",
    [
        walk_scene,
        lambda: msgspec.structs.replace(load("walk56"), objective=Objective(head=Free(0.0, 0.0, 1.0))),
        lambda: msgspec.structs.replace(load("walk56"), objective=Objective(custom={"mine:term": 2.0})),
        lambda: silent(stages=[SearchStage("walk", objective={"speed": 1.0})]),
    ],
    ids=["weights", "free", "custom", "stage"],
)
def test_what_a_scene_asks_for_is_left_to_it(made: Callable[[], Scene]):
    scene = made()
    assert with_usual_objective(scene) is scene


def test_the_published_study_asks_for_torque_by_its_own_name():
    for name in ("fwalk", "bwalk", "iwalk", "fjog", "bigbird_walk", "walk56", "walk44_legacy"):
        objective = load(name).objective
        assert objective == Objective(torque=1.0, gait=objective.gait)


def test_what_does_not_walk_has_to_say_what_it_is_for():
    with pytest.raises(SceneError, match="objective: nothing says what a search is for: weigh terms"):
        with_usual_objective(load("throw"))


def test_a_search_keeps_the_objective_that_it_was_for():
    walk = silent("fwalk", duration=0.1)
    few = pinned(walk, start_values(walk), {"controller.pd.lHip.kp", "controller.pd.lKnee.kp"})
    result = optimize(few, 4, device="cpu", search="random", population=4)
    assert recorded_scene(result).objective.speed == 200.0
    assert set(result.evaluations.term_names) == {"torque", "speed", "heading"}
    assert np.all(result.evaluations.cost > 0.0)
