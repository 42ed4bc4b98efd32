"""Where episodes start, and what is wanted in them."""

from itertools import pairwise
from threading import Event

import msgspec
import numpy as np
import pytest
import warp as wp

from patience import PATIENCE
from warpmuscle import Rollout
from warpmuscle.core.arrays import instance_zeros
from warpmuscle.formats import load
from warpmuscle.learning import EpisodeBatch, Task, Variation
from warpmuscle.learning.imitation import choice
from warpmuscle.learning.starts import RowTable
from warpmuscle.simulation.stepper import Stepper


def test_episodes_start_in_states_of_the_gait_that_the_scene_makes():
    scene = msgspec.structs.replace(load("reflex_planar"), duration=0.8)
    variation = Variation(velocity_noise=0.0, start_states=3, start_after=0.5)
    batch = EpisodeBatch(scene, 12, "cpu", Task(variation=variation, episode_time=0.02), threads=1)
    rollout = Rollout(scene, 1, "cpu", threads=1)
    start = rollout.state.coordinates.numpy()[0].copy()
    gap = (rollout.steps - 500) // 3
    states = []
    for steps in (500, gap, gap):
        rollout.step(steps)
        coordinates = rollout.state.coordinates.numpy()[0].copy()
        coordinates[1] = start[1]
        states.append((coordinates, rollout.state.speeds.numpy()[0].copy()))
    row = batch.episodes.start_row.numpy()
    assert set(row) == {0, 1, 2}
    got = batch.rollout.state
    for instance, which in enumerate(row):
        coordinates, speeds = states[which]
        np.testing.assert_allclose(got.coordinates.numpy()[instance], coordinates, atol=1e-4)
        np.testing.assert_allclose(got.speeds.numpy()[instance], speeds, atol=2e-2)
    assert (got.muscles.sensed.numpy()[:, :, 0] > 0.0).all()


@pytest.mark.usefixtures("unoptimized_test")
def test_a_start_of_the_gait_has_come_from_where_it_would_have_walked_to_get_there():
    scene = msgspec.structs.replace(load("reflex_planar"), duration=0.6)
    scene.failure = msgspec.structs.replace(scene.failure, no_progress=0.3, no_progress_window=0.2)
    scene.objective = msgspec.structs.replace(scene.objective, step_width=1.0)  # which remembers where feet landed
    task = Task(variation=Variation(velocity_noise=0.0, start_states=1, start_after=0.5), episode_time=0.4)
    batch = EpisodeBatch(scene, 1, "cpu", task, threads=1)
    walked = Rollout(scene, 1, "cpu", threads=1)
    walked.step(500)
    start, state = walked.state, batch.rollout.state
    assert state.coordinates.numpy()[0, 1] == 0.0
    assert start.coordinates.numpy()[0, 1] > 0.1
    for remembered in (lambda one: one.passed.numpy()[0, 2], lambda one: one.foot_cycle.numpy()["landing"][0, :, 2]):
        gone = [one.coordinates.numpy()[0, 1] - remembered(one) for one in (state, start)]
        np.testing.assert_allclose(gone[0], gone[1], atol=1e-5)


def test_the_kernels_of_policy_and_controller_are_made_ready_side_by_side(monkeypatch):
    makes_gait, load_kernel, waited = Event(), Stepper.load, []
    controller_gait = choice.controller_gait

    def while_the_other_begins(stepper: Stepper) -> None:
        waited.append(makes_gait.wait(PATIENCE))
        load_kernel(stepper)

    monkeypatch.setattr(Stepper, "load", while_the_other_begins)
    monkeypatch.setattr(choice, "controller_gait", lambda *given: (makes_gait.set(), controller_gait(*given))[1])
    scene = msgspec.structs.replace(load("reflex_planar"), duration=0.8)
    variation = Variation(start_states=1, start_after=0.1)
    EpisodeBatch(scene, 1, "cpu", Task(variation=variation, episode_time=0.02), threads=1)
    assert waited == [True]


def test_velocity_noise_has_the_deviation_that_is_asked_for_and_differs_between_episodes():
    noise = Variation(velocity_noise=0.2)
    batch = EpisodeBatch("reflex_planar", 500, "cpu", Task(variation=noise, episode_time=0.01), threads=1)
    still = Rollout("reflex_planar", 1, "cpu", threads=1).state.speeds.numpy()[0]
    first = batch.rollout.state.speeds.numpy()[:, :2] - still[:2]
    assert first.std(axis=0) == pytest.approx(0.2, rel=0.12)
    assert np.abs(first.mean(axis=0)).max() < 0.03
    batch.step()
    second = batch.rollout.state.speeds.numpy()[:, :2] - still[:2]
    assert (batch.episodes.number.numpy() == 2).all()
    assert abs(np.corrcoef(first[:, 0], second[:, 0])[0, 1]) < 0.2
    assert np.array_equal(batch.rollout.state.speeds.numpy()[:, 2:], np.tile(still[2:], (500, 1)))


def test_commands_lie_in_their_intervals_and_change_when_it_is_time():
    task = Task(speed=(0.8, 1.6), command_time=0.02, episode_time=1.0)
    batch = EpisodeBatch("reflex_planar", 50, "cpu", task, threads=1)
    seen = []
    for _ in range(6):
        seen.append(batch.episodes.command.numpy()[:, 0].copy())
        batch.step()
    changed = [not np.array_equal(a, b) for a, b in pairwise(seen)]
    assert changed == [False, False, True, False, True]
    every = np.concatenate(seen)
    assert every.min() >= 0.8
    assert every.max() <= 1.6
    assert np.ptp(every) > 0.6


def test_who_is_to_turn_is_wanted_elsewhere_by_and_by_and_has_not_failed_by_turning():
    task = Task(turning_rate=(0.5, 0.5))
    batch = EpisodeBatch("walk56", 1, "cpu", task, threads=1)
    assert batch.scene.failure.heading == 0.0
    before = batch.episodes.heading.numpy()[0]
    for _ in range(10):
        batch.step()
    assert batch.episodes.heading.numpy()[0] - before == pytest.approx(0.05, rel=1e-4)


@pytest.mark.long
def test_some_episodes_of_a_gait_begin_at_the_initial_state():
    task = Task(variation=Variation(velocity_noise=0.0, start_states=16, start_after=1.0))
    batch = EpisodeBatch("reflex_walk", 40, "cpu", task, threads=1)
    alone = EpisodeBatch("reflex_walk", 1, "cpu", Task(variation=Variation(velocity_noise=0.0)), threads=1)
    start = alone.rollout.state.coordinates.numpy()[0]
    same = np.all(batch.rollout.state.coordinates.numpy() == start, axis=1)
    np.testing.assert_array_equal(same, batch.episodes.start_row.numpy() >= 16)
    assert 0 < same.sum() < 15


@pytest.mark.parametrize("side_by_side", [False, True])
def test_rows_are_restored_to_the_instances_of_a_mask_whichever_way_they_lie(side_by_side: bool):
    n, random = 6, np.random.default_rng(4)
    shapes = {(n, 7): float, (n, 2, 3): wp.float64, (n, 5): wp.vec3, (n,): int}
    targets = [instance_zeros(shape, dtype, "cpu", side_by_side) for shape, dtype in shapes.items()]
    sources = [instance_zeros((3, *shape[1:]), dtype, "cpu") for shape, dtype in shapes.items()]
    for source in sources:
        source.assign(random.integers(1, 100, source.numpy().shape).astype(source.numpy().dtype))
    mask, row = np.array([1, 0, 1, 1, 0, 0], dtype=bool), np.array([0, 1, 2, 0, 1, 2], dtype=np.int32)
    RowTable(targets, sources, "cpu").restore(wp.array(mask, device="cpu"), wp.array(row, device="cpu"))
    for target, source in zip(targets, sources, strict=True):
        expected = np.where(mask.reshape(-1, *[1] * (source.numpy().ndim - 1)), source.numpy()[row], 0)
        np.testing.assert_array_equal(target.numpy(), expected)
