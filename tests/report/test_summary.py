"""The report of a result file: numbers that add up, curves and bars that show what they should."""

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.report import summary
from warpmuscle.results.records import ParameterTable, Result
from warpmuscle.results.result import read, write
from warpmuscle.scene import Objective, SearchStage


@pytest.fixture(scope="module")
def searched() -> Result:
    """Two small searches with two terms in the objective."""
    scene = msgspec.structs.replace(load("fwalk"), duration=0.3, objective=Objective(torque=1.0, speed=5.0))
    return optimize(scene, 24, 3, "cpu", search="cma", searches=2, population=6)


def test_the_weighted_terms_of_the_best_add_up_to_its_cost(searched):
    lines = summary.score(searched)
    parts = [float(line.split("=")[0]) for line in lines[1:] if "=" in line]
    assert len(parts) == 2
    np.testing.assert_allclose(sum(parts), searched.best.cost, rtol=1e-4)
    assert "speed" in "".join(lines)


def test_the_joints_that_add_most_to_a_term_are_named_and_kept_in_the_file(searched, tmp_path):
    write(tmp_path / "a.h5", searched)
    _, (torque, speed) = summary.shares(read(tmp_path / "a.h5"))
    best = searched.evaluations.terms[searched.best.index]
    assert sum(torque.parts.values()) == pytest.approx(best[0], rel=1e-6)
    largest = max(torque.parts, key=torque.parts.get)
    share = 100.0 * torque.parts[largest] / best[0]
    assert torque.largest.startswith(f"{largest} {share:.0f} %, ")
    assert torque.largest.count(",") == summary.LARGEST
    assert "others" in torque.largest
    assert speed.largest == ""
    assert torque.largest in "\n".join(summary.score(searched))


def test_report_counts_outcomes_ranks_searches_and_shows_every_parameter(searched):
    text = "\n".join(summary.report(searched))
    assert "24 candidates" in text
    assert "reached the end" in text
    assert "searches by their best" in text
    assert all(name in text for name in searched.parameters.name)


def test_stages_are_told_apart_and_the_score_is_by_the_objective_of_the_last():
    stages = [SearchStage("heat up", {"speed": 0.0}, candidates=7), SearchStage("race", {"torque": 0.5, "speed": 20.0})]
    objective = Objective(torque=1.0, speed=5.0)
    scene = msgspec.structs.replace(load("fwalk"), duration=0.1, objective=objective, stages=stages)
    result = optimize(scene, 20, 3, "cpu", search="cma", population=6)
    lines = summary.convergence(result)
    assert lines[0] == "stage 1, heat up: 7 candidates, 37 parameters"
    assert lines[3] == "stage 2, race: 13 candidates, 37 parameters"
    assert "ended: all candidates" in lines[2]
    assert f"{result.best.cost:.6g}" in lines[4]
    first, *terms = summary.score(result)
    assert "of stage 2, race" in first
    terms = [term for term in terms if "=" in term]
    np.testing.assert_allclose(sum(float(term.split("=")[0]) for term in terms), result.best.cost, rtol=1e-4)
    assert "0.5 x" in terms[0]
    assert "20 x" in terms[1]


def test_curve_falls_from_the_highest_to_the_lowest_block():
    drawn = summary.curve(np.geomspace(1e6, 1.0, 500))
    assert (drawn[0], drawn[-1], len(drawn)) == ("█", "▁", summary.CURVE)
    assert summary.curve(np.ones(3)) == "▁▁▁"


def test_bars_show_start_and_best_between_the_bounds_and_what_leans_on_one():
    table = ParameterTable(
        ("a", "b", "c"), ("N", "", ""), np.array([0.0, 1.0, 0.0]), np.array([1.0, 100.0, 1.0]), np.zeros(3),
        np.array([0.5, 10.0, 0.5]), ("linear", "log", "linear"),
    )  # fmt: skip
    first, second, third = summary.parameters(table, np.array([0.25, 10.0, 0.999]))[1:]
    assert first.index("o") < first.index("|")
    assert "|" not in second  # the best value stands on the start
    assert ("!" in first, "!" in second, "!" in third) == (False, False, True)
    middle = second[second.index("[") + 1 : second.index("]")]
    assert middle.index("o") == summary.BAR // 2


def test_a_file_without_a_search_says_so():
    table = ParameterTable((), (), *np.zeros((4, 0)), ())
    assert summary.report(Result("", "cpu", "simulate", 0, table))[-1] == "no search; 0 motions"
