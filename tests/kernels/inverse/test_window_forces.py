"""What muscles come to over a window: against the whole step where nothing moves, and activation in float64."""

import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.core.errors import ArgumentError
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.coordinates import States
from warpmuscle.inverse.tracking.driven_body import DrivenBody
from warpmuscle.inverse.tracking.look_ahead import LookAhead
from warpmuscle.scene import Body, MuscleModel

MODEL = MuscleModel(curves="thelen", tendon="compliant", activation="scaled", rise_time=0.01, fall_time=0.04)


def held_arm() -> BodyModel:
    """An arm that is too heavy to move."""
    scene = arm(muscle_model=MODEL, gravity=1e-9)
    scene.character.bodies["tip"] = Body(1e6, (1e6, 1e6, 1e6))
    return BodyModel(scene, "cpu")


def still(body: BodyModel, count: int) -> States:
    values = np.repeat(body.map.default[None], count, axis=0)
    return body.map.states(values, np.zeros_like(values), np.zeros_like(values))


def test_forces_are_those_of_the_step_where_nothing_moves():
    body = held_arm()
    states = still(body, 3)
    driven = DrivenBody(body, 3, 0.01, [], 1.0)
    initial = np.array([[0.1, 0.5], [0.3, 0.2], [0.9, 0.05]])
    driven.start(states, initial)
    ahead = LookAhead(driven)
    excitation = np.array([[1.0, 0.0], [0.2, 0.6], [0.0, 0.3]])
    for _ in range(3):  # the first window begins with fibres that have not begun
        ahead.begin(states, states)
        told = ahead.reach(excitation)
        driven.run(excitation)
        assert told.force == pytest.approx(driven.force(), rel=1e-4)
        assert told.activation == pytest.approx(driven.activation(), rel=1e-5)
        excitation = excitation[::-1]


def test_activation_follows_its_equation():
    body = held_arm()
    driven = DrivenBody(body, 1, 0.02, [], 1.0)
    a = np.array([[0.2, 0.7]])
    driven.start(still(body, 1), a)
    ahead = LookAhead(driven)
    ahead.begin(still(body, 1), still(body, 1))
    u = np.array([[0.8, 0.1]])
    got = ahead.reach(u).activation
    steps = 20000
    for _ in range(steps):  # Thelen 2003, equations 1 and 2
        time = np.where(u > a, 0.01 * (0.5 + 1.5 * a), 0.04 / (0.5 + 1.5 * a))
        a = a + driven.window / steps * (u - a) / time
    assert got == pytest.approx(a, abs=0.01)  # of steps of 0.5 ms


def test_a_lengthening_path_stretches_the_tendon():
    body = held_arm()
    driven = DrivenBody(body, 1, 0.01, [], 1.0)
    driven.start(still(body, 1), np.array([[0.3, 0.3]]))
    ahead = LookAhead(driven)
    values = body.map.default[None] + 0.05
    turned = body.map.states(values, np.zeros_like(values), np.zeros_like(values))
    ahead.begin(still(body, 1), still(body, 1))
    same = ahead.reach(np.array([[0.3, 0.3]])).force
    ahead.begin(still(body, 1), turned)
    longer = (ahead.lengths(turned).numpy() - ahead.lengths(still(body, 1)).numpy())[0] > 0.0
    other = ahead.reach(np.array([[0.3, 0.3]])).force
    assert ((other > same)[0] == longer).all()


def test_muscles_that_do_not_remember_are_refused():
    body = BodyModel(arm(muscle_model=MuscleModel(ideal=True)), "cpu")
    with pytest.raises(ArgumentError, match="Hill-type muscles"):
        LookAhead(DrivenBody(body, 1, 0.01, [], 1.0))
