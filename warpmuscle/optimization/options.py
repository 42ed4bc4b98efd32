"""What a search may be asked for, checked before it begins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace as changed
from typing import Any

from warpmuscle.core.arguments import as_integer, as_number, as_text, check_function
from warpmuscle.core.errors import Error
from warpmuscle.core.limits import check_size
from warpmuscle.optimization.evaluation import GenerationEvaluator
from warpmuscle.optimization.progress import Progress
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import Parameter, free_parameters
from warpmuscle.simulation.batch_input import checked_threads
from warpmuscle.simulation.devices import find_devices

GREATEST_SEED = 2**63 - 1  # that a result file can hold
Tell = Callable[[Progress], None]
MakeBatches = Callable[[Scene], GenerationEvaluator]


def required_parameters(scene: Scene) -> list[Parameter]:
    """The free parameters; Error if there is none."""
    parameters = free_parameters(scene)
    if not parameters:
        raise Error(
            "this scene has no free parameters: write a number in it as { value = .., min = .., max = .., step = .. }"
        )
    return parameters


def check_options(options: SearchOptions) -> SearchOptions:
    """Options as numbers of Python; raise Error for what no strategy has to know."""
    found: dict[str, Any] = {
        "strategy": as_text(options.strategy, "search"),
        "restarts": as_text(options.restarts, "restarts"),
        "candidates": as_integer(options.candidates, "candidates"),
        "searches": as_integer(options.searches, "searches"),
    }
    if options.population is not None:
        found["population"] = as_integer(options.population, "population")
    for name in ("sigma", "until"):
        if (value := getattr(options, name)) is not None:
            found[name] = as_number(value, name, above=0.0)
    check_size("candidates", found["candidates"])
    if options.target is not None:
        found["target"] = as_number(options.target, "target")
    return changed(options, **found)


def check_other_arguments(device: Any, threads: Any, command: Any, progress: Any, batches: Any) -> None:
    """Raise Error for what no option of a search is."""
    if batches is None:
        find_devices(device)
    checked_threads(threads)
    as_text(command, "command")
    check_function(progress, "progress")
    check_function(batches, "batches")
