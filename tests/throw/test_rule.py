"""The rule from goals to signals of new throws."""

import numpy as np
import pytest

from warpmuscle.throw.goals import fly
from warpmuscle.throw.rule import goals_about, learned, release_velocity


def test_a_ball_that_leaves_at_the_velocity_of_a_goal_lands_there():
    goals = goals_about(20, 0.0, np.random.default_rng(0))
    place = np.array([0.3, 2.2])
    velocity = release_velocity(goals, place, 9.81)
    for goal, own in zip(goals, velocity, strict=True):
        flight = fly(place, own, 9.81, float(goal[1]))
        assert float(flight.distance) == pytest.approx(goal[0], abs=1e-9)
        assert float(flight.angle) == pytest.approx(goal[2], abs=1e-9)


def test_a_rule_gives_back_what_it_learned_and_what_lies_between():
    rng = np.random.default_rng(1)
    goals = goals_about(60, 0.0, rng)
    place = np.array([0.3, 2.2])

    def signals(asked: np.ndarray) -> np.ndarray:
        return release_velocity(asked, place, 9.81) @ np.array([[0.1, -0.2, 0.0], [0.05, 0.1, 0.3]])

    rule = learned(goals, signals(goals), place, 9.81)
    asked = goals_about(20, 0.0, rng)
    np.testing.assert_allclose(rule(asked), signals(asked), atol=0.01)
