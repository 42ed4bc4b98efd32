"""Optimisation: reproducible, honest about its best, and able to stop early."""

import msgspec
import numpy as np
import pytest

from warpmuscle.errors import Error
from warpmuscle.formats import load
from warpmuscle.optimize import optimize, replay
from warpmuscle.parameters import free_parameters, start_values
from warpmuscle.results import write
from warpmuscle.rollout import Rollout
from warpmuscle.status import Status


@pytest.fixture(scope="module")
def scene():
    return msgspec.structs.replace(load("fwalk"), duration=0.8)


@pytest.fixture(scope="module")
def result(scene):
    return optimize(scene, candidates=24, seed=3, device="cpu", command="test")


def test_first_candidate_is_the_scene_as_it_is(scene, result):
    np.testing.assert_array_equal(result.evaluations.params[0], start_values(scene))
    rollout = Rollout(scene, 1, "cpu")
    rollout.run()
    assert result.evaluations.cost[0] == rollout.cost()[0]


def test_candidates_lie_within_their_intervals_and_on_their_precision(result):
    table, values = result.parameters, result.evaluations.params[1:]
    assert np.all((values >= table.min) & (values <= table.max))
    steps = (values - table.min) / table.step
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-6)


def test_best_replayed_alone_has_the_cost_stored_and_no_candidate_has_less(scene, result):
    rollout = Rollout(scene, 1, "cpu")
    rollout.set_parameters(result.best.params)
    rollout.run()
    assert rollout.cost()[0] == result.best.cost == result.evaluations.cost.min()


def test_every_candidate_has_ended_with_a_finite_cost(scene, result):
    assert np.isfinite(result.evaluations.cost).all()
    assert not np.any(result.evaluations.status == Status.RUNNING)
    survived = result.evaluations.status == Status.COMPLETED
    assert np.all(result.evaluations.end_time[survived] == pytest.approx(scene.duration))
    assert result.evaluations.cost[survived].max() < result.evaluations.cost[~survived].min()


def test_same_seed_gives_the_same_file(scene, result, tmp_path):
    write(tmp_path / "a.h5", result)
    write(tmp_path / "b.h5", optimize(scene, candidates=24, seed=3, device="cpu", command="test", threads=1))
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_replay_ends_where_the_candidate_ended(scene, result):
    recording = replay(scene, result.best.params, "cpu")
    np.testing.assert_array_equal(recording.com, result.replays[0].com)


def test_interrupt_keeps_what_has_ended(scene):
    def interrupt(progress):
        if progress.done > 0:
            raise KeyboardInterrupt

    result = optimize(scene, candidates=200, seed=3, device="cpu", progress=interrupt)
    assert 0 < len(result.evaluations.cost) <= 200
    assert not np.any(result.evaluations.status == Status.RUNNING)


def test_interrupt_before_any_candidate_has_ended_is_an_error(scene):
    def interrupt(progress):
        raise KeyboardInterrupt

    with pytest.raises(Error, match="nothing to keep"):
        optimize(scene, candidates=1, seed=3, device="cpu", progress=interrupt)


def test_progress_never_runs_backwards_and_comes_to_its_end(scene):
    seen = []
    optimize(scene, candidates=30, seed=3, device="cpu", progress=seen.append)
    assert [p.done for p in seen] == sorted(p.done for p in seen)
    assert [p.fraction for p in seen] == sorted(p.fraction for p in seen)
    assert (seen[-1].done, seen[-1].fraction) == (30, 1.0)


def test_scene_without_free_parameters_is_an_error():
    with pytest.raises(Error, match="no free parameters"):
        optimize(load("iwalk"), candidates=2, device="cpu")


def test_result_names_its_parameters_with_units(scene, result):
    assert result.parameters.name == tuple(p.name for p in free_parameters(scene))
    assert dict(zip(result.parameters.name, result.parameters.unit, strict=True))["controller.pd.lHip.kp"] == "N m/rad"
