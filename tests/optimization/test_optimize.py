"""Optimisation: reproducible, honest about its best, and able to stop early. For going on later see test_resume."""

import signal

import msgspec
import numpy as np
import pytest

from patience import ticking
from same_values import assert_same
from small_scene import sound_scene
from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.optimization import evaluation, progress
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.replay import Replayer
from warpmuscle.optimization.resume import resume
from warpmuscle.optimization.unit_cube import from_unit, to_unit
from warpmuscle.results.result import write
from warpmuscle.scene import SearchStage
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import Parameter, free_parameters, start_values, substitute
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture(scope="module")
def scene():
    return msgspec.structs.replace(load("fwalk"), duration=0.8)


@pytest.fixture(scope="module")
def result(scene):
    return optimize(scene, candidates=24, seed=3, device="cpu", search="random", command="test")


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
    write(
        tmp_path / "b.h5",
        optimize(scene, candidates=24, seed=3, device="cpu", search="random", command="test", threads=1),
    )
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_replay_ends_where_the_candidate_ended(scene, result):
    recording, _ = Replayer(scene, "cpu").replay(result.best.params)
    np.testing.assert_array_equal(recording.com, result.replays[0].com)


def test_motion_recorded_in_the_batch_is_that_of_a_replay(scene, result, tmp_path, monkeypatch):
    monkeypatch.setattr(evaluation, "_recordable", lambda trials: 24)  # as on a GPU
    monkeypatch.setattr(Replayer, "replay", None)
    recorded = optimize(scene, candidates=24, seed=3, device="cpu", search="random", command="test")
    write(tmp_path / "a.h5", result)
    write(tmp_path / "b.h5", recorded)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_motion_is_not_recorded_where_a_batch_has_no_room_or_there_are_several(scene, monkeypatch):
    recordings = []
    monkeypatch.setattr(evaluation, "_recordable", lambda trials: 24)
    monkeypatch.setattr(
        evaluation.BatchEvaluator, "motion", lambda batches, values: recordings.append(batches._recorded)
    )
    for candidates, population in ((25, None), (24, 6), (24, None)):
        optimize(scene, candidates, 3, "cpu", search="random", population=population)
    assert recordings == [False, False, True]


def test_search_is_cma_unless_it_says_otherwise_or_has_one_parameter(scene):
    short = msgspec.structs.replace(scene, duration=0.02)
    assert optimize(short, 8, device="cpu").searched.options.strategy == "cma"
    alone = substitute(short, start_values(short))
    alone.controller.pd["lHip"].kp = Free(300.0, 150.0, 600.0)
    assert optimize(alone, 2, device="cpu").searched.options.strategy == "random"


def test_device_that_computes_many_at_once_gets_islands_that_fill_it_and_a_resumed_search_keeps_them(
    scene, tmp_path, monkeypatch
):
    """As on a GPU; the number is in the file, so that it holds on another device, too."""
    short, file = msgspec.structs.replace(scene, duration=0.02), tmp_path / "a.h5"
    monkeypatch.setattr(Rollout, "at_once", 96)
    monkeypatch.setattr(progress, "time", ticking(0.01))
    first = optimize(short, until=0.3, device="cpu", output=file)
    assert first.searched.options.strategy == "islands"
    assert first.searched.options.population == 96
    assert (first.evaluations.search[:97] == np.r_[-1, np.zeros(96)]).all()
    monkeypatch.setattr(Rollout, "at_once", 0)
    more = resume(file, device="cpu", until=0.3)
    assert more.searched.options.strategy == "islands"
    assert more.searched.options.population == 96
    known = len(first.evaluations.cost)
    assert len(more.evaluations.cost) > known
    np.testing.assert_array_equal(more.evaluations.params[:known], first.evaluations.params)


def test_interrupt_keeps_what_has_ended(scene):
    def interrupt(progress):
        if progress.done > 0:
            raise KeyboardInterrupt

    result = optimize(scene, candidates=200, seed=3, device="cpu", progress=interrupt)
    assert 0 < len(result.evaluations.cost) <= 200
    assert not np.any(result.evaluations.status == Status.RUNNING)


class CtrlC:
    """One that comes while this is taken apart, where Python swallows what is raised."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("stages", [False, True])
def test_an_interruption_is_heeded_wherever_it_comes(scene, stages, hears_ctrl_c):
    came = []

    def interrupt(progress):
        if progress.done > 0 and not came:
            came.append(progress.done)
            CtrlC()

    parts = [SearchStage("first", candidates=100), SearchStage("second")] if stages else []
    searched = msgspec.structs.replace(scene, stages=parts)
    result = optimize(searched, candidates=200, seed=3, device="cpu", progress=interrupt)
    assert result.searched.ended == "interrupted"
    assert 0 < len(result.evaluations.cost) < 100
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


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


@pytest.mark.parametrize("search", ["random", "cma", "nlopt:LN_COBYLA"])
def test_result_depends_on_neither_threads_nor_batches(search, scene, monkeypatch):
    options = {"search": search, "searches": 2, "population": None if search.startswith("nlopt") else 7}
    short = msgspec.structs.replace(scene, duration=0.1)
    whole = optimize(short, 40, seed=2, device="cpu", threads=2, **options)
    monkeypatch.setattr(evaluation, "CPU_BATCH", 5)
    assert_same(optimize(short, 40, seed=2, device="cpu", threads=1, **options), whole)


@pytest.fixture(scope="module")
def evolved(scene):
    short = msgspec.structs.replace(scene, duration=0.3)
    return optimize(short, 121, seed=1, device="cpu", search="cma", searches=2, population=10, sigma=0.2)


def test_each_search_asks_for_its_population_in_each_generation_and_improves(evolved):
    found, history = evolved.evaluations, evolved.searched.history
    for search in (0, 1):
        mine = found.search == search
        np.testing.assert_array_equal(found.generation[mine], np.repeat(np.arange(6), 10))
        best = history.best[history.search == search]
        np.testing.assert_array_equal(best, found.cost[mine].reshape(6, 10).min(axis=1))
        assert history.median[history.search == search][-1] < history.median[history.search == search][0]
    assert np.all(history.sigma > 0.0)
    assert [set(state) >= {"mean", "sigma", "C"} for state in evolved.searched.states] == [True, True]


def test_scene_as_given_is_always_among_the_candidates(evolved):
    found = evolved.evaluations
    np.testing.assert_array_equal(found.params[0], evolved.parameters.value)
    assert (found.search[0], np.sum(found.search == -1)) == (-1, 1)
    assert evolved.best.cost == found.cost.min() <= found.cost[0]


def test_budget_is_kept_to_the_candidate(scene):
    short = msgspec.structs.replace(scene, duration=0.1)
    result = optimize(short, 25, device="cpu", search="cma", population=10)
    assert len(result.evaluations) == 25
    np.testing.assert_array_equal(result.searched.history.generation, [0, 1])
    assert result.searched.ended == "all candidates have been evaluated"


def test_target_and_time_end_it_and_are_said_to(scene):
    short = msgspec.structs.replace(scene, duration=0.1)
    options = {"device": "cpu", "search": "cma", "population": 10}
    given = optimize(short, 1, device="cpu").best.cost
    result = optimize(short, 10_000, target=0.97 * given, **options)
    assert result.best.cost <= 0.97 * given
    assert result.best.index >= len(result.evaluations) - 11
    assert result.searched.ended == "the target is reached"
    result = optimize(short, None, until=0.5, **options)
    assert not result.searched.options.limited
    assert 0 < len(result.evaluations) < 100_000
    assert result.searched.ended == "the time is up"


def test_something_is_evaluated_however_little_time_there_is(scene, tmp_path):
    """Else a short search on a slow machine would have nothing to keep."""
    short, file = msgspec.structs.replace(scene, duration=0.02), tmp_path / "a.h5"
    first = optimize(short, until=1e-9, device="cpu", output=file)
    more = resume(file, device="cpu", until=1e-9)
    assert 0 < len(first.evaluations) < len(more.evaluations)
    assert first.searched.ended == more.searched.ended == "the time is up"


def test_terms_of_the_objective_are_kept_with_each_candidate(scene, result):
    found = result.evaluations
    assert found.term_names == tuple(Rollout(scene, 1, "cpu").terms())
    survived = found.status == Status.COMPLETED
    torque = found.terms[:, found.term_names.index("torque")]
    np.testing.assert_allclose(found.cost[survived], torque[survived], rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"candidates": 0}, "candidates must be a positive whole number"),
        ({"searches": 0}, "searches must be a positive whole number"),
        ({"until": 0.0}, "until must be a finite number greater than 0"),
        ({"target": np.nan}, "target must be a finite number"),
        ({"search": "cmb"}, "nearest are cma"),
        ({"search": "cma", "population": 1}, "population must be at least"),
    ],
)
def test_impossible_options_are_clear_errors(options, message, scene):
    with pytest.raises(Error, match=message):
        optimize(scene, device="cpu", **options)


def test_unit_cube_is_linear_or_logarithmic_and_rounded_to_steps():
    parameters = [
        Parameter("a", 2.0, 1.0, 3.0, 0.0, ""),
        Parameter("b", 10.0, 1.0, 100.0, 0.0, "", "log"),
        Parameter("c", 10.0, 1.0, 100.0, 0.5, "", "log"),
        Parameter("d", 5.0, 5.0, 5.0, 0.0, "", "log"),
    ]
    unit = np.array([[0.0] * 4, [0.5] * 4, [0.25] * 4, [1.0] * 4])
    np.testing.assert_allclose(
        from_unit(parameters, unit),
        [[1.0, 1.0, 1.0, 5.0], [2.0, 10.0, 10.0, 5.0], [1.5, np.sqrt(10.0), 3.0, 5.0], [3.0, 100.0, 100.0, 5.0]],
        rtol=1e-14,
    )
    np.testing.assert_allclose(to_unit(parameters, np.array([2.0, 10.0, 10.0, 5.0])), 0.5, rtol=1e-15)
    random = np.random.default_rng(0).random((50, 4))
    np.testing.assert_allclose(to_unit(parameters, from_unit(parameters, random))[:, :2], random[:, :2], atol=1e-15)


def test_logarithmic_scale_needs_a_positive_interval_of_its_own():
    assert Free(2.0, 1.0, 4.0, scale="log").scale == "log"
    for members, message in (
        ({"value": 1.0, "min": 0.0, "max": 2.0, "scale": "log"}, "positive min, not 0"),
        ({"value": 1.0, "min": 0.0, "max": 2.0, "scale": "cubic"}, "scale must be one of linear, log"),
        ({"same_as": "a.b", "scale": "log"}, "from that parameter, like scale"),
    ):
        with pytest.raises(ValueError, match=message):
            Free(**members)


def test_scale_of_a_parameter_is_searched_stored_and_written(scene):
    short = msgspec.structs.replace(scene, duration=0.1)
    text = toml.dumps(short)
    assert text.count("kp = { value = 300, min = 150, max = 600, step = 5 }") > 0
    short = toml.loads(text.replace("min = 150, max = 600, step = 5 }", 'min = 0.3, max = 3000, scale = "log" }', 1))
    result = optimize(short, 200, device="cpu", search="random")
    index = result.parameters.scale.index("log")
    assert result.parameters.scale.count("log") == 1
    assert 5.0 < np.median(result.evaluations.params[:, index]) < 200.0
    assert toml.loads(result.scene) == short


@pytest.mark.usefixtures("unoptimized_test")
def test_free_weight_that_starts_at_zero_is_a_term_in_every_batch():
    small = sound_scene()
    small.duration, small.objective.speed = 0.05, Free(0.0, 0.0, 1.0)
    found = optimize(small, 6, device="cpu", search="random", population=2).evaluations
    assert found.term_names == ("torque", "speed")
    assert np.all(found.terms[:, 1] > 0.0)


def test_scene_without_free_parameters_is_an_error():
    with pytest.raises(Error, match="no free parameters"):
        optimize(load("iwalk"), candidates=2, device="cpu")


def test_result_names_its_parameters_with_units(scene, result):
    assert result.parameters.name == tuple(p.name for p in free_parameters(scene))
    assert dict(zip(result.parameters.name, result.parameters.unit, strict=True))["controller.pd.lHip.kp"] == "N m/rad"
