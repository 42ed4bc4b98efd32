"""Batches that a GPU has ready serve a few candidates less: what these come to does not depend on it."""

import msgspec
import numpy as np

from warpmuscle.formats import load
from warpmuscle.optimization.evaluation import BatchEvaluator, Generation
from warpmuscle.optimization.progress import Progress, Tracker
from warpmuscle.optimization.unit_cube import from_unit
from warpmuscle.scene.parameters import free_parameters

SCENE = msgspec.structs.replace(load("fwalk"), duration=0.3)
VALUES = from_unit(free_parameters(SCENE), np.random.default_rng(0).uniform(size=(21, len(free_parameters(SCENE)))))
SIZES = (21, 20, 12, 21)


def evaluated(at_once: int) -> tuple[list[Generation], list[int], list[Progress]]:
    """Generations of these sizes, sizes of batches that were made for them, and what was told of them."""
    evaluator, made, told = BatchEvaluator(SCENE, "cpu", 1), [], []
    evaluator.at_once = at_once
    make = evaluator._made
    evaluator._made = lambda count: (made.append(count), make(count))[1]
    generations = []
    tracker = Tracker(sum(SIZES), None, told.append)
    for count in SIZES:
        generation = Generation(0, np.zeros(count, dtype=np.int32), VALUES[:count].copy(), evaluator.term_names)
        evaluator.evaluate(generation, count, tracker, lambda: False)
        generations.append(generation)
    return generations, made, told


def test_a_larger_batch_gives_the_same_and_is_not_made_again():
    on_cpu, on_gpu = evaluated(0), evaluated(10)
    assert on_cpu[1] == [21, 20, 12, 21]
    assert on_gpu[1] == [21, 12]
    assert evaluated(100)[1] == [21]  # what runs at once takes the time of one
    for one, other in zip(on_cpu[0], on_gpu[0], strict=True):
        for name in ("values", "cost", "status", "end_time", "terms"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert on_gpu[2][-1].done == sum(SIZES)
    assert on_gpu[2][-1].simulated == on_cpu[2][-1].simulated
    assert max(progress.done for progress in on_gpu[2]) == sum(SIZES)
