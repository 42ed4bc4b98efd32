"""Footholds on stairs: a whole sole finds ground there, at one height, and no two stairs are taken at once."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels.control.walking import footholds
from warpmuscle.kernels.control.walking.parameters import HEEL, LEG, STATE, TOE
from warpmuscle.kernels.structs import Model
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Scene, Sphere, Terrain
from warpmuscle.scene.terrain.tiles import Stairs
from warpmuscle.simulation.rollout import Rollout

RISE, TREAD, START, COUNT = 0.17, 0.34, 0.5, 4
HEEL_AT, TOE_AT, LENGTH = -0.05, 0.15, 0.95  # m: ends of a sole from its ankle, and a leg


@wp.kernel(enable_backward=False)
def ask(model: Model, z: wp.array[float], memory: wp.array2d[float], climb: float, found: wp.array[wp.vec2]):
    i = wp.tid()
    m = model
    wanted = wp.vec3(0.0, 0.0, z[i])
    forwards = wp.vec3(0.0, 0.0, 1.0)
    found[i] = footholds.best_shift(0, wanted, forwards, 0.0, climb, m, memory[i])


def shifts(z: np.ndarray, climb: float) -> np.ndarray:
    """How far feet that are wanted at these places are put ahead of them, and of where they are needed, m."""
    ground = Ground(terrain=Terrain([Stairs(RISE, TREAD, COUNT, start=START, returns=False)]))
    ball = Character("ball", {"ball": Body(1.0, (0.01, 0.01, 0.01), [Sphere((0.0, 0.0, 0.0), 0.05)])})
    fails = Failure(com_height=0.0, heading=0.0)
    model = Rollout(Scene("b", ball, initial_state=InitialState((0.0, 1.0, 0.0)), ground=ground, failure=fails)).model
    memory = np.zeros((len(z), STATE), dtype=np.float32)
    memory[:, int(HEEL)], memory[:, int(TOE)], memory[:, int(LEG)] = HEEL_AT, TOE_AT, LENGTH
    found = wp.zeros(len(z), dtype=wp.vec2, device="cpu")
    given = wp.array(z.astype(np.float32), device="cpu")
    wp.launch(ask, len(z), [model, given, wp.array(memory, device="cpu"), climb, found], device="cpu")
    return found.numpy().astype(float)


def height_at(z: np.ndarray) -> np.ndarray:
    """Of the stairs, whose risers begin 2 cm before their edges, m, in float64."""
    edges = START + TREAD * np.arange(COUNT)
    corners = np.stack([edges - 0.02, edges], axis=1).ravel()
    return np.interp(z, corners, np.repeat(RISE * np.arange(COUNT + 1), 2)[1:-1])


def test_a_whole_sole_finds_ground_of_one_height_within_one_stair():
    wanted = np.linspace(0.1, 0.75, 60)
    found = shifts(wanted, 0.2)
    at = wanted + found[:, 0]
    sole = at[:, None] + np.linspace(HEEL_AT, TOE_AT, 21)
    assert np.ptp(height_at(sole), axis=1).max() < 1e-6
    assert height_at(at).max() == pytest.approx(RISE)  # one stair at most, since the other foot is before the first one
    np.testing.assert_allclose(found[:, 1], found[:, 0] + 0.2 * height_at(at), atol=1e-5)


def test_on_level_ground_a_foot_is_put_where_it_is_wanted():
    np.testing.assert_allclose(shifts(np.linspace(-2.0, -0.5, 20), 0.2), 0.0, atol=1e-6)


def test_a_place_costs_more_the_further_the_more_uneven_and_the_later_it_is_changed():
    shift, uneven = np.array([0.0, 0.1, -0.1, 0.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
    moved, phase = np.array([0.0, 0.0, 0.0, 0.0, 0.1, 0.1, -0.1]), np.array([0.0, 0.0, 0.0, 0.0, 0.2, 0.9, 0.9])
    cost = evaluate(footholds.foothold_cost, shift, uneven, 0.0, moved, phase)
    assert cost[0] == 0.0
    assert cost[1] == pytest.approx(0.1)
    assert cost[2] == pytest.approx(float(footholds.BACKWARDS) * 0.1)
    assert cost[3] == pytest.approx(float(footholds.UNEVEN) * (0.05 - float(footholds.TOLERATED)))
    assert 0.0 < cost[4] < cost[5]
    assert cost[6] == cost[5]  # back as much as ahead


def test_what_a_foothold_may_cost_is_what_the_shipped_numbers_were_searched_with():
    tuned = {"UNEASY": 3.0, "BACKWARDS": 3.0, "HIGHEST": 0.22, "STEADY": 0.7, "STEEPEST": 0.35}
    assert {name: float(getattr(footholds, name)) for name in tuned} == tuned
