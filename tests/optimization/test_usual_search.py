"""What a search does that is asked for nothing."""

from warpmuscle.optimization.usual_search import CANDIDATES, GENERATIONS, USUAL, unlimited, usual_search
from warpmuscle.results.records import ANY_NUMBER, SearchOptions
from warpmuscle.search.islands import ENLARGED, ISLANDS

NOTHING = SearchOptions(USUAL, candidates=ANY_NUMBER)
GPU = 396  # candidates that one computes at once


def test_a_gpu_is_filled_with_islands_for_a_hundred_generations():
    chosen = usual_search(NOTHING, 86, GPU)
    assert (chosen.strategy, chosen.population, chosen.candidates) == ("islands", GPU, GENERATIONS * GPU)


def test_no_more_islands_than_five_as_more_take_longer_and_find_no_more():
    assert usual_search(NOTHING, 86, 10_000).population == ISLANDS * ENLARGED * 17  # 17: 4 + 3 ln 86


def test_a_cpu_gets_cma_of_its_own_size():
    chosen = usual_search(NOTHING, 86, 0)
    assert (chosen.strategy, chosen.population, chosen.candidates) == ("cma", None, CANDIDATES)


def test_few_candidates_are_had_in_enough_generations():
    assert usual_search(SearchOptions(USUAL, candidates=5000), 86, GPU).population == 50
    few = usual_search(SearchOptions(USUAL, candidates=1000), 86, GPU)
    assert (few.strategy, few.population, few.candidates) == ("cma", None, 1000)


def test_a_time_alone_lets_every_generation_fill_the_device():
    chosen = usual_search(SearchOptions(USUAL, candidates=ANY_NUMBER, until=40.0), 86, GPU)
    assert (chosen.strategy, chosen.population, chosen.candidates) == ("islands", GPU, ANY_NUMBER)


def test_one_parameter_is_searched_at_random():
    assert usual_search(NOTHING, 1, GPU).strategy == "random"


def test_a_strategy_that_was_asked_for_stays():
    asked = SearchOptions("cma", searches=3, candidates=ANY_NUMBER)
    assert usual_search(asked, 86, GPU).candidates == 3 * CANDIDATES
    assert usual_search(asked, 86, GPU).strategy == "cma"


def test_options_are_unlimited_without_a_number_and_a_time():
    assert unlimited(NOTHING)
    assert not unlimited(SearchOptions(USUAL, candidates=ANY_NUMBER, until=1.0))
    assert not unlimited(SearchOptions(USUAL, candidates=10))


def test_what_only_cma_takes_is_given_to_it_on_a_gpu_too():
    for asked in ({"searches": 4}, {"population": 64}, {"restarts": "bipop"}):
        chosen = usual_search(SearchOptions(USUAL, candidates=ANY_NUMBER, until=40.0, **asked), 86, GPU)
        assert chosen.strategy == "cma"
        assert chosen.population == asked.get("population")
