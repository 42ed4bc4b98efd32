"""Tables of throws: what their lines say, and the rule from goals to signals."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.throw.goals import fly

TOOLS = Path(__file__).parents[2] / "tools"


@pytest.fixture(scope="module")
def prediction() -> dict:
    return runpy.run_path(str(TOOLS / "throw_prediction.py"))


def test_a_ball_that_leaves_at_the_velocity_of_a_goal_lands_there(prediction: dict):
    goals = prediction["goals_about"](20, 0.0, np.random.default_rng(0))
    place = np.array([0.3, 2.2])
    velocity = prediction["release_velocity"](goals, place, 9.81)
    for goal, own in zip(goals, velocity, strict=True):
        flight = fly(place, own, 9.81, float(goal[1]))
        assert float(flight.distance) == pytest.approx(goal[0], abs=1e-9)
        assert float(flight.angle) == pytest.approx(goal[2], abs=1e-9)


def test_a_rule_gives_back_what_it_learned_and_what_lies_between(prediction: dict):
    rng = np.random.default_rng(1)
    goals = prediction["goals_about"](60, 0.0, rng)
    place = np.array([0.3, 2.2])

    def signals(asked: np.ndarray) -> np.ndarray:
        return prediction["release_velocity"](asked, place, 9.81) @ np.array([[0.1, -0.2, 0.0], [0.05, 0.1, 0.3]])

    rule = prediction["learned"](goals, signals(goals), place, 9.81)
    asked = prediction["goals_about"](20, 0.0, rng)
    np.testing.assert_allclose(rule(asked), signals(asked), atol=0.01)


def test_a_table_counts_throws_and_names_those_that_miss_a_bar():
    table = runpy.run_path(str(TOOLS / "throw_table.py"))
    row = {
        "number": 5, "kind": "together", "names": ["one", "two"], "held_out": [1], "good": [True, False],
        "r2": [[0.9999, 0.9995], [0.99, 0.9999]], "velocity_r2": [[0.99, 0.99], [0.96, 0.99]],
        "hand_error": [0.01, 0.03], "correlation": [0.95, 0.97], "explained": 0.9, "share": [0.4, 0.5], "cpu": 3.0,
    }  # fmt: skip
    assert "all bars  1 of  2, held out  0 of  1" in table["line"]([row])
    (text,) = table["missed"](row)
    assert "two: r2 0.9900, velocity 0.960, hand 3.0 cm, correlation 0.970" in text
