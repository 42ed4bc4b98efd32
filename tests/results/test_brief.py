"""Results without most of their candidates say what a study asks of them, and refuse what takes the others."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from small_result import search_result
from warpmuscle.core.errors import ResultError
from warpmuscle.optimization.best_scene import best_scene, recorded_scene
from warpmuscle.optimization.resume import resume
from warpmuscle.plots import Subject, draw
from warpmuscle.plots.convergence import generations_of
from warpmuscle.report.summary import report
from warpmuscle.results.brief import brief
from warpmuscle.results.records import Result
from warpmuscle.results.result import glance, read, write


@pytest.fixture(scope="module")
def whole() -> Result:
    return search_result("fwalk")


@pytest.fixture
def short(whole: Result, tmp_path: Path) -> Result:
    write(tmp_path / "short.h5", brief(whole))
    return read(tmp_path / "short.h5")


def test_first_and_best_candidates_are_kept_with_all_that_is_known_of_the_best(whole: Result, short: Result):
    assert short.is_brief
    assert not whole.is_brief
    assert short.evaluated == whole.evaluated == len(whole.evaluations)
    assert len(short.evaluations) == 2
    assert short.best.cost == whole.best.cost
    for name in ("params", "cost", "status", "end_time", "search", "generation", "stage", "terms"):
        kept, all_of_them = getattr(short.evaluations, name), getattr(whole.evaluations, name)
        np.testing.assert_array_equal(kept[short.best.index], all_of_them[whole.best.index])
        np.testing.assert_array_equal(kept[0], all_of_them[0])
    np.testing.assert_array_equal(short.searched.history.best, whole.searched.history.best)
    np.testing.assert_array_equal(short.replays[0].com, whole.replays[0].com)
    assert recorded_scene(short) == recorded_scene(whole)
    assert brief(short) is short


def test_what_is_said_of_it_counts_all_candidates(whole: Result, short: Result, tmp_path: Path):
    count = f"{whole.evaluated} candidates"
    assert count in repr(short)
    assert any(line.startswith(f"{count}, of which") for line in report(short))
    assert f"after {count}" in best_scene(short)[1]
    found = glance(tmp_path / "short.h5")
    assert (found.evaluated, len(found.cost), found.ended) == (whole.evaluated, 2, whole.searched.ended)
    at, least = generations_of(short)
    assert at[-1] == whole.evaluated
    assert least.min() == whole.searched.history.best.min()


def test_what_takes_the_others_is_refused_in_a_line(short: Result, tmp_path: Path):
    with pytest.raises(ResultError, match=r"short\.h5: holds only the best of its [0-9]+ candidates: it cannot go on"):
        resume(tmp_path / "short.h5", 5)
    with pytest.raises(ResultError, match=r"only the best of its [0-9]+ candidates: the most robust"):
        best_scene(short, among=3)


def test_a_file_that_holds_more_than_there_were_is_damaged(whole: Result, tmp_path: Path):
    searched = dataclasses.replace(brief(whole).searched, evaluated=1)
    write(tmp_path / "wrong.h5", dataclasses.replace(brief(whole), searched=searched))
    with pytest.raises(ResultError, match=r"1 candidate in all, but /evaluations has 2"):
        read(tmp_path / "wrong.h5")


def test_its_convergence_is_drawn_by_generations_with_every_least_cost_in_sight(short: Result):
    history = short.searched.history
    fell = dataclasses.replace(history, median=np.full(len(history.best), 1e6))  # most of each generation
    short = dataclasses.replace(short, searched=dataclasses.replace(short.searched, history=fell))
    figure = draw(Subject(short), "convergence")
    axes = figure.axes[0]
    bottom, top = axes.get_ylim()
    least = np.minimum.accumulate(short.searched.history.best)
    assert bottom < least.min() <= least.max() < top
    assert top - bottom < 2.0 * max(np.ptp(short.searched.history.best), 0.1 * least.min()) + 1e-6
    (line,) = [one for one in axes.lines if one.get_label() == "least so far"]
    np.testing.assert_array_equal(line.get_ydata(), least)
    assert line.get_xdata()[-1] == short.evaluated
