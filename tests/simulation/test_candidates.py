"""Candidates with several runs each: their runs are drawn once, and become one cost, status and end."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.scene import Robustness
from warpmuscle.scene.parameters import free_parameters, start_values
from warpmuscle.simulation.candidates import CandidateBatch
from warpmuscle.simulation.perturbations import drawn
from warpmuscle.simulation.rollout import Rollout

PUSHED = Robustness(runs=3, cost="worst", velocity_noise=0.2, push=60.0, slope=0.05, seed=4)


def robust(robustness, duration=0.6):
    return msgspec.structs.replace(load("fwalk"), duration=duration, robustness=robustness)


def candidates(scene):
    """Two: the scene as given, and one whose knees are so weak that it falls."""
    values = np.tile(start_values(scene), (2, 1))
    values[1] = [parameter.min for parameter in free_parameters(scene)]
    return values


def runs_alone(scene, values):
    """A rollout of all runs of one candidate."""
    rollout = Rollout(scene, scene.robustness.runs, "cpu")
    rollout.disturb(drawn(scene.robustness, scene.duration))
    rollout.set_parameters(values)
    rollout.run()
    return rollout


@pytest.mark.parametrize("cost", ["mean", "worst"])
def test_a_candidate_is_what_its_runs_alone_come_to(cost):
    scene = robust(msgspec.structs.replace(PUSHED, cost=cost))
    trials = CandidateBatch(scene, 2, "cpu")
    trials.set_parameters(candidates(scene))
    trials.run()
    found = trials.outcomes()
    for i, values in enumerate(candidates(scene)):
        alone = runs_alone(scene, values)
        worst = alone.cost().argmax()
        assert trials.cost()[i] == found.cost[i] == (alone.cost().max() if cost == "worst" else alone.cost().mean())
        assert found.status[i] == alone.status()[worst]
        assert found.end_time[i] == alone.end_time()[worst]
        for name, terms in alone.terms().items():
            assert found.terms[name][i] == (terms[worst] if cost == "worst" else terms.mean())


def test_one_failing_run_makes_a_candidate_fail_and_cost_more_than_its_undisturbed_run():
    scene = robust(msgspec.structs.replace(PUSHED, push=3000.0, slope=0.0), duration=2.0)
    trials = CandidateBatch(scene, 1, "cpu")
    trials.run()
    runs = trials.batch.status()
    assert runs[0] == Status.COMPLETED
    assert runs[1] != Status.COMPLETED
    assert trials.outcomes().status[0] not in (Status.COMPLETED, Status.RUNNING)
    assert trials.cost()[0] > scene.objective.failure_cost > trials.batch.cost()[0]


def test_a_candidate_has_ended_when_all_its_runs_have():
    scene = robust(msgspec.structs.replace(PUSHED, push=3000.0), duration=2.0)
    trials = CandidateBatch(scene, 1, "cpu")
    trials.run(1.9)
    assert np.any(trials.batch.status() != Status.RUNNING)
    assert not trials.ended()[0]
    trials.run()
    assert trials.ended()[0]


def test_a_robust_search_keeps_the_combined_cost_and_the_undisturbed_motion_of_its_best():
    scene = robust(PUSHED, duration=0.3)
    result = optimize(scene, 12, seed=1, device="cpu")
    alone = runs_alone(scene, result.best.params)
    assert result.best.cost == alone.cost().max() == result.evaluations.cost.min()
    undisturbed = Rollout(scene, 1, "cpu", record=[0])
    undisturbed.set_parameters(result.best.params)
    undisturbed.run()
    np.testing.assert_array_equal(result.replays[0].com, undisturbed.recording().com)
