"""What stages of a search get of what was asked for."""

from dataclasses import replace

import msgspec
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import Error
from warpmuscle.optimization.stages import plan, prolonged, stage_seed, with_population
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene import Scene, SearchStage
from warpmuscle.scene.number import Free


def staged(*candidates: float | None, **settings) -> Scene:
    """The small scene with two parameters, and stages with these numbers of candidates; settings are of the last."""
    scene = sound_scene()
    scene.controller.pd["root"].kp = Free(10.0, 5.0, 20.0)
    scene.stages = [SearchStage(str(index), candidates=count) for index, count in enumerate(candidates)]
    scene.stages[-1] = msgspec.structs.replace(scene.stages[-1], **settings)
    return scene


@pytest.mark.parametrize(
    ("own", "total", "expected"),
    [
        ([None, None, None], 100, [34, 33, 33]),
        ([40, None, None], 100, [40, 30, 30]),
        ([None, 0.5, None], 100, [25, 50, 25]),
        ([0.2, 0.3, 0.5], 101, [20, 30, 51]),
        ([10, 20], 100, [10, 20]),
        ([1e-6, None], 100, [1, 99]),
        ([98, None, None], 100, [98, 1, 1]),
        ([None, 0.999], 100, [1, 99]),
    ],
)
def test_candidates_are_a_stages_own_or_an_even_share_of_the_rest(own, total, expected):
    options, stages = plan(staged(*own), SearchOptions(candidates=total))
    assert [stage.options.candidates for stage in stages] == expected
    assert options.candidates == sum(expected)


@pytest.mark.parametrize(("own", "least"), [([99, None, None], 101), ([60, 50], 110), ([0.6, 0.6], 120)])
def test_stages_that_need_more_candidates_than_there_are_are_an_error(own, least):
    with pytest.raises(Error, match=rf"stages need {least} candidates at least; there are to be 100 in all"):
        plan(staged(*own), SearchOptions(candidates=100))


def test_settings_are_those_asked_for_unless_the_stage_has_its_own():
    asked = SearchOptions(
        "cma", searches=2, population=10, sigma=0.2, restarts="ipop", candidates=100, until=60.0, target=2.0
    )
    first, same = (stage.options for stage in plan(staged(None, None, sigma=0.1, until=5.0), asked)[1])
    assert (first.strategy, first.searches, first.population, first.sigma, first.restarts) == (
        "cma",
        2,
        10,
        0.2,
        "ipop",
    )
    assert (same.population, same.sigma, same.restarts, same.until) == (10, 0.1, "ipop", 5.0)
    assert (first.target, same.target, first.until) == (None, 2.0, None)
    own = plan(staged(None, None, strategy="random", searches=1, target=3.0), asked)[1][1].options
    assert (own.strategy, own.searches, own.population, own.restarts, own.target) == ("random", 1, None, "none", 3.0)
    assert with_population(own, 500).population == 50
    assert with_population(first, 500) == first


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"strategy": "cmb"}, "stage '1': there is no search strategy 'cmb'; the nearest are cma"),
        ({"strategy": "cma", "population": 2}, "stage '1': the population must be at least 4"),
        ({"strategy": "nlopt:LN_BOBYQA", "restarts": "ipop"}, "stage '1': .* has no restarts"),
    ],
)
def test_settings_that_are_impossible_are_found_before_the_search_begins(settings, message):
    with pytest.raises(Error, match=message):
        plan(staged(None, None, **settings), SearchOptions())


def test_more_candidates_are_for_the_last_stage():
    options, stages = plan(staged(10, None, 20), SearchOptions(candidates=60))
    longer = prolonged(stages, SearchOptions(candidates=100), 0.5)
    assert [stage.options.candidates for stage in longer] == [10, 30, 60]
    assert [stage.options.target for stage in longer] == [None, None, 0.5]
    assert prolonged(stages, options, None) == stages


def test_each_stage_has_a_seed_of_its_own():
    assert stage_seed(7, 0) == 7
    assert len({stage_seed(seed, number) for seed in range(10) for number in range(5)}) == 50


@pytest.mark.parametrize(
    ("candidates", "searches", "population"),
    [(5000, 1, 5000), (100_000, 1, 65536), (10, 3, 4), (1, 4, 1), (100_000, 3, 21846)],
)
def test_generations_of_a_random_search_are_as_large_as_a_batch_and_no_larger_than_the_search(
    candidates: int, searches: int, population: int
):
    options = SearchOptions("random", searches, candidates=candidates)
    assert with_population(options, 65536).population == population
    assert with_population(replace(options, population=7), 65536).population == 7
