"""Balls fly as stones do, and what they miss is told."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from warpmuscle.core.errors import Error
from warpmuscle.throw.goals import Flight, Goal, fly, misfit, tamed


def test_a_ball_lands_where_the_equations_of_motion_bring_it():
    position, velocity, height = np.array([0.3, 2.1]), np.array([4.0, 3.0]), 0.5

    def landed(_, state):
        return state[1] - height

    landed.terminal, landed.direction = True, -1
    path = solve_ivp(
        lambda _, s: [s[2], s[3], 0.0, -9.81], (0.0, 5.0), [*position, *velocity], events=landed, rtol=1e-9
    )
    flight = fly(position[None], velocity[None], 9.81, height)
    assert flight.distance[0] == pytest.approx(path.y_events[0][0, 0], abs=1e-6)
    assert flight.duration[0] == pytest.approx(path.t_events[0][0], abs=1e-6)
    assert (flight.speed[0], flight.angle[0]) == (5.0, pytest.approx(np.arctan2(3.0, 4.0)))


def test_a_ball_that_stays_below_its_target_lands_nowhere_and_says_by_how_much():
    flight = fly(np.array([[0.0, 1.0]]), np.array([[3.0, 2.0]]), 9.81, 1.5)
    assert np.isnan(flight.distance[0])
    assert flight.short[0] == pytest.approx(0.5 - 2.0**2 / (2.0 * 9.81))
    assert flight.misses(Goal(distance=1.0, height=1.5)) == {"distance": np.inf}
    higher = fly(np.array([[0.0, 1.0]]), np.array([[3.0, 2.5]]), 9.81, 1.5)
    goal = Goal(distance=1.0, height=1.5)
    assert misfit(higher, goal)[0] < misfit(flight, goal)[0]


def test_each_part_of_a_goal_is_missed_by_itself():
    flight = fly(np.array([[0.3, 2.0]]), np.array([[4.0, 3.0]]), 9.81, 0.0)
    landing, duration = float(flight.distance[0]), float(flight.duration[0])
    assert flight.misses(Goal(landing, speed=5.0, angle=np.arctan2(3.0, 4.0), duration=duration)) == {}
    assert set(flight.misses(Goal(landing + 0.06, speed=5.2, duration=duration + 0.03))) == {
        "distance", "speed", "duration",
    }  # fmt: skip
    assert misfit(flight, Goal(landing))[0] == pytest.approx(0.0)
    assert misfit(flight, Goal(landing + 0.02))[0] == pytest.approx(1.0)


def test_far_misses_count_ever_slower_and_always_more():
    error = np.array([1.0, 49.0, 51.0, 500.0, 5000.0])
    counted = tamed(error)
    assert counted[:2].tolist() == [1.0, 49.0**2]
    assert np.all(np.diff(counted) > 0.0)
    assert counted[-1] < 2e-3 * error[-1] ** 2


def test_flights_of_many_frames_at_once_are_those_of_each():
    rng = np.random.default_rng(0)
    position, velocity = rng.random((3, 4, 2)) + 1.0, rng.random((3, 4, 2)) * 4.0
    together = fly(position, velocity, 9.81, 0.2)
    single = fly(position[1, 2], velocity[1, 2], 9.81, 0.2)
    assert together.distance[1, 2] == single.distance
    assert isinstance(together, Flight)


@pytest.mark.parametrize(
    ("values", "says"),
    [({}, "needs a goal"), ({"distance": -1.0}, "distance"), ({"speed": np.nan}, "speed"),
     ({"duration": 0.0}, "time of a throw"), ({"angle": np.radians(120.0)}, "angle"),
     ({"distance": 2.0, "height": np.inf}, "height")],
)  # fmt: skip
def test_goals_that_make_no_sense_are_refused(values, says):
    with pytest.raises(Error, match=says):
        Goal(**values)
