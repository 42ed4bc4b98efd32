"""What a search does that is asked for nothing: as much at once as the device computes at once."""

from __future__ import annotations

from dataclasses import replace as changed

from warpmuscle.results.records import ANY_NUMBER, SearchOptions
from warpmuscle.search.islands import ENLARGED, ISLANDS
from warpmuscle.search.many_cma import usual_size

USUAL = "usual"  # strategy that is yet to be chosen
CANDIDATES = 5000  # of a search that nothing else ends
GENERATIONS = 100  # at least, of which a search learns enough; on a GPU, of one that nothing else ends


def unlimited(options: SearchOptions) -> bool:
    """Whether neither a number of candidates nor a time ends a search."""
    return options.candidates >= ANY_NUMBER and options.until is None


def usual_strategy(parameters: int) -> str:
    """The strategy for so many free parameters where no device is to be filled; cma needs two."""
    return "cma" if parameters > 1 else "random"


def usual_search(options: SearchOptions, parameters: int, at_once: int) -> SearchOptions:
    """The options with strategy, population and number of candidates chosen, where they are not.

    A device that computes many candidates in the time of one gets islands, as many as it computes in that time but no
    more than five: what then counts is how many generations there are in a minute. Generations are smaller where so few
    candidates are wanted that there would not be enough of them. Anything else gets CMA-ES.

    Args:
        options: of strategy `USUAL`, or another one, which stays.
        parameters: that are free.
        at_once: candidates that the device computes in the time of one; 0 for a CPU, whose time is that of each.
    """
    if options.strategy != USUAL:
        return changed(options, candidates=CANDIDATES * options.searches) if unlimited(options) else options
    least = usual_size(parameters) if parameters > 1 else 0
    wanted = options.candidates // GENERATIONS if options.candidates < ANY_NUMBER else at_once
    population = min(wanted, at_once, ISLANDS * ENLARGED * least)
    asked = options.searches > 1 or options.population is not None or options.restarts != "none"  # which suits cma
    if asked or population <= least:
        return usual_search(changed(options, strategy=usual_strategy(parameters)), parameters, at_once)
    count = GENERATIONS * population if unlimited(options) else options.candidates
    return changed(options, strategy="islands", population=population, candidates=count)
