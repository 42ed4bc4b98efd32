"""Sums of terms over steps, beside sums made in NumPy: each body, muscle and whole once, by any number of lanes."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import filled

from warpmuscle.kernels.objective.causes import KINDS, TERM, cause_of
from warpmuscle.kernels.objective.term_functions import CYCLE_TERMS, MuscleWork
from warpmuscle.kernels.objective.term_sums import (
    ObjectiveKind,
    desired_stage_of,
    effort_stage,
    muscle_functions,
    muscle_terms_of,
    objective_stage_of,
    takes_state,
)
from warpmuscle.kernels.structs import Model, ModelRef, Scratch, ScratchRef, State, StateRef

INSTANCES, BODIES, MUSCLES = 2, 6, 3


@wp.func
def of_body(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return state.coordinates[instance, body]


@wp.func
def squared(instance: int, body: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return state.coordinates[instance, body] * state.coordinates[instance, body]


@wp.func
def of_whole(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> float:
    return 1.0 + state.coordinates[instance, 0]


@wp.func
def growing(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, total: float) -> float:
    return 1.0 + 2.0 * total


@wp.func
def with_plain_state(instance: int, m: int, w: MuscleWork, model: Model, state: State) -> float:
    return state.coordinates[instance, m]


@wp.func
def pulled(instance: int, m: int, w: MuscleWork, model: ModelRef, state: StateRef) -> float:
    return w.force + state.coordinates[instance, m]


CUSTOM = (("b", of_body), ("bb", squared), ("w", of_whole), ("g", growing), ("m", pulled))
KIND = ObjectiveKind(("effort_squared", "m"), ("b", "bb"), ("w", "g"), CUSTOM)


def given(**more: Any) -> tuple[Model, State, Scratch, np.ndarray]:
    """A model, a state whose sums have begun, and a working set; and the numbers that terms see."""
    q = np.random.default_rng(7).normal(size=(INSTANCES, BODIES)).astype(np.float32)
    sums = {
        "torque_integral": np.full((INSTANCES, BODIES), 0.5), "muscle_terms": np.full((INSTANCES, 2, MUSCLES), 3.0),
        "body_terms": np.full((INSTANCES, 2, BODIES), 4.0), "instance_terms": np.full((INSTANCES, 2), 5.0),
        "cause": np.zeros(INSTANCES, np.int32),
    }  # fmt: skip
    state = filled(State, **({"coordinates": q} | sums | more))
    torque = np.float32(np.arange(3 * BODIES)).reshape(BODIES, 3)
    return filled(Model, body_count=BODIES), state, filled(Scratch, torque=torque, flags=np.zeros(2, np.int32)), q


def launched(stage: Any, lanes: int, model: Model, state: State, work: Scratch, times: int = 1) -> None:
    """A stage, by all lanes of all instances one after the other."""

    @wp.kernel(enable_backward=False, module="unique")
    def run(lanes: int, model: Model, state: State, work: Scratch):
        tid = wp.tid()
        its_model, its_state, its_work = model, state, work
        stage(tid // lanes, tid % lanes, lanes, its_model, its_state, its_work)

    for _ in range(times):
        wp.launch(run, INSTANCES * lanes, [lanes, model, state, work], device="cpu")


@pytest.mark.parametrize("lanes", [1, 4])
def test_every_body_but_the_root_and_the_whole_are_added_once(lanes: int):
    model, state, work, q = given()
    launched(objective_stage_of(KIND), lanes, model, state, work, times=2)
    bodies = np.full((INSTANCES, 2, BODIES), 4.0)
    bodies[:, 0, 1:] += 2.0 * q[:, 1:]
    bodies[:, 1, 1:] += 2.0 * q[:, 1:] ** 2
    np.testing.assert_allclose(state.body_terms.numpy(), bodies, rtol=1e-6)
    whole = 5.0 + 2.0 * (1.0 + q[:, 0].astype(float))
    grown = 3.0 * (3.0 * 5.0 + 1.0) + 1.0  # twice S + 1 + 2 S
    np.testing.assert_allclose(state.instance_terms.numpy(), np.stack([whole, np.full(INSTANCES, grown)], 1), rtol=1e-6)
    np.testing.assert_array_equal(work.flags.numpy(), 0)
    np.testing.assert_array_equal(state.cause.numpy(), 0)


def test_terms_that_see_accelerations_or_desired_torques_are_added_in_their_stages():
    apart = KIND._replace(accelerated=("bb", "w"), desired=("g",))
    model, state, work, q = given()
    launched(objective_stage_of(apart), 1, model, state, work)
    np.testing.assert_allclose(state.body_terms.numpy()[:, 0, 1:], 4.0 + q[:, 1:], rtol=1e-6)
    np.testing.assert_array_equal(state.body_terms.numpy()[:, 1], 4.0)
    np.testing.assert_array_equal(state.instance_terms.numpy(), 5.0)
    launched(objective_stage_of(apart, accelerated=True), 1, model, state, work)
    np.testing.assert_allclose(state.body_terms.numpy()[:, 1, 1:], 4.0 + q[:, 1:] ** 2, rtol=1e-6)
    np.testing.assert_allclose(state.body_terms.numpy()[:, 0, 1:], 4.0 + q[:, 1:], rtol=1e-6)
    np.testing.assert_allclose(state.instance_terms.numpy()[:, 0], 6.0 + q[:, 0], rtol=1e-6)
    np.testing.assert_array_equal(state.instance_terms.numpy()[:, 1], 5.0)
    desired = desired_stage_of(apart)

    @wp.kernel(enable_backward=False, module="unique")
    def run(model: Model, state: State, work: Scratch):
        its_model, its_state, its_work = model, state, work
        desired(wp.tid(), its_model, its_state, its_work)

    wp.launch(run, INSTANCES, [model, state, work], device="cpu")
    np.testing.assert_array_equal(state.instance_terms.numpy()[:, 1], 16.0)
    np.testing.assert_allclose(state.instance_terms.numpy()[:, 0], 6.0 + q[:, 0], rtol=1e-6)


def test_terms_of_muscles_are_added_for_each_muscle():
    model, state, work, q = given()
    functions = muscle_functions(KIND)
    assert [cause for _, cause in functions] == [0, cause_of(TERM, 4)]
    assert [takes_state(function) for function, _ in functions] == [False, True]
    assert takes_state(with_plain_state)
    terms = muscle_terms_of(functions)

    @wp.kernel(enable_backward=False, module="unique")
    def run(activation: float, model: Model, state: State, work: Scratch):
        its_model, its_state, its_work = model, state, work
        w = MuscleWork()
        w.activation = activation
        w.force = 20.0
        terms(wp.tid() // MUSCLES, wp.tid() % MUSCLES, w, its_model, its_state, its_work)

    wp.launch(run, INSTANCES * MUSCLES, [0.5, model, state, work], device="cpu")
    found = state.muscle_terms.numpy().copy()
    np.testing.assert_allclose(found[:, 0], 3.25, rtol=1e-6)
    np.testing.assert_allclose(found[:, 1], 23.0 + q[:, :MUSCLES], rtol=1e-6)
    np.testing.assert_array_equal(work.flags.numpy(), 0)
    wp.launch(run, INSTANCES * MUSCLES, [np.nan, model, state, work], device="cpu")
    np.testing.assert_array_equal(state.muscle_terms.numpy()[:, 0], found[:, 0])
    np.testing.assert_array_equal(work.flags.numpy(), [0, 1])
    np.testing.assert_array_equal(state.cause.numpy(), 0)  # no part of others is to blame


@pytest.mark.parametrize("lanes", [1, 4])
def test_feedback_torques_of_all_joints_are_added(lanes: int):
    model, state, work, _ = given()
    launched(effort_stage, lanes, model, state, work, times=3)
    torque = np.linalg.norm(np.arange(3.0 * BODIES).reshape(BODIES, 3), axis=1)
    torque[0] = 0.0  # no joint
    np.testing.assert_allclose(state.torque_integral.numpy(), np.tile(0.5 + 3.0 * torque, (INSTANCES, 1)), rtol=1e-6)
    np.testing.assert_array_equal(work.flags.numpy(), 0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -2.0e30])
def test_what_is_no_number_is_not_added_and_the_step_has_diverged(bad: float):
    q = np.ones((INSTANCES, BODIES), np.float32)
    q[0, 3] = bad
    model, state, work, _ = given(coordinates=q)
    launched(objective_stage_of(KIND._replace(body=("b",), instance=())), 1, model, state, work)
    bodies = np.full((INSTANCES, BODIES), 5.0)
    bodies[:, 0], bodies[0, 3] = 4.0, 4.0
    np.testing.assert_array_equal(state.body_terms.numpy()[:, 0], bodies)
    np.testing.assert_array_equal(work.flags.numpy(), [0, 1])
    np.testing.assert_array_equal(state.cause.numpy(), [cause_of(TERM, 0), 0])
    torque = np.ones((BODIES, 3), np.float32)
    torque[2] = bad
    work = filled(Scratch, torque=torque, flags=np.zeros(2, np.int32))
    launched(effort_stage, 1, model, state, work)
    np.testing.assert_allclose(state.torque_integral.numpy()[0], 0.5 + np.sqrt(3.0) * np.array([0, 1, 0, 1, 1, 1]))
    np.testing.assert_array_equal(work.flags.numpy(), [0, 1])


def test_terms_of_feet_ask_for_their_cycles():
    assert not ObjectiveKind(body=("b",)).follows_cycles
    assert ObjectiveKind(cycles=True).follows_cycles
    assert ObjectiveKind(instance=(sorted(CYCLE_TERMS)[0],)).follows_cycles
    assert KIND.cause("bb") == cause_of(TERM, 1) < KINDS * 8
    assert KIND.cause("effort_squared") == 0
