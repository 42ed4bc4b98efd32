"""When the file of a search is written anew: not so often that it takes much of the time, however large it is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from small_result import search_result
from warpmuscle.core.errors import OccupiedError, ResultError
from warpmuscle.results import checkpoint
from warpmuscle.results.checkpoint import Checkpoint
from warpmuscle.results.journal import journal_path
from warpmuscle.results.records import TABLE, Evaluations


@pytest.mark.parametrize(
    ("candidates", "waited", "written"),
    [(100, 1.0, False), (100, 3.0, True), (100_000, 3.0, False), (100_000, 60.0, True)],
)
def test_a_large_file_is_written_less_often(
    candidates: int, waited: float, written: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Until then the journal has what was evaluated; 100 000 candidates of 72 parameters take a second."""
    result = search_result()
    assert result.evaluations is not None
    generation = replace(result.evaluations.rows(np.arange(1)), params=np.zeros((1, 72)))
    now = [100.0]
    monkeypatch.setattr(checkpoint.time, "monotonic", lambda: now[0])
    with Checkpoint.begin(tmp_path / "a.h5", result) as kept:
        kept._journal.append = lambda generation: None
        results = []
        monkeypatch.setattr(Checkpoint, "_write_all", lambda self, result: results.append(result))
        now[0] += waited
        kept.put(generation, candidates, lambda: result)
    assert bool(results) == written


def test_a_search_that_runs_is_not_called_interrupted(tmp_path: Path):
    path = tmp_path / "a.h5"
    with Checkpoint.begin(path, search_result()):
        with pytest.raises(OccupiedError, match="another process is at work"):
            Checkpoint.begin(path, search_result())
        before = path.read_bytes()
    assert path.read_bytes() == before
    with pytest.raises(ResultError, match="an interrupted search; continue it with --resume"):
        Checkpoint.begin(path, search_result())


@pytest.mark.parametrize("why", [KeyboardInterrupt, ResultError])
def test_what_ends_a_search_before_its_file_is_there_leaves_nothing_to_go_on_with(tmp_path: Path, monkeypatch, why):
    def stopped(path: Path, result: object) -> None:
        raise why

    monkeypatch.setattr(checkpoint, "write", stopped)
    with pytest.raises(why):
        Checkpoint.begin(tmp_path / "a.h5", search_result())
    assert [*tmp_path.iterdir()] == []


def test_a_generation_that_could_not_be_written_is_told_of_with_the_next_one(tmp_path: Path):
    result = search_result()
    assert result.evaluations is not None
    with Checkpoint.begin(tmp_path / "a.h5", result) as kept:

        def full(generation: object) -> None:
            raise ResultError("no space left")

        kept._journal.append = full
        kept.put(result.evaluations, 1, lambda: result)
        with pytest.raises(ResultError, match=r"no space left; what was evaluated is kept: --resume .*a.h5 continues"):
            kept.put(result.evaluations, 2, lambda: result)


def repeated(candidates: int, generation: int, columns: int) -> Evaluations:
    """So many candidates of one generation."""
    evaluations = search_result().evaluations
    assert evaluations is not None
    rows = evaluations.rows(np.arange(candidates) % len(evaluations))
    params = np.random.default_rng(generation).uniform(size=(candidates, columns))
    return replace(rows, params=params, generation=np.full(candidates, generation, dtype=np.int32))


def test_a_million_candidates_are_mostly_in_the_file_and_little_time_goes_into_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A thousand generations of a thousand, of a third of a second each: what is only in the journal, and the time."""
    result, now, parameters = search_result(), [100.0], 40
    generation = repeated(1, 0, parameters)
    monkeypatch.setattr(checkpoint.time, "monotonic", lambda: now[0])
    held, most, spent = [0], 0, [0.0]

    def write(self: Checkpoint, count: int) -> None:
        took = count * parameters * 8 / checkpoint.SPEED
        spent[0] += took
        held[0], self._count, self._duration, self._written = 0, count, took, now[0]

    with Checkpoint.begin(tmp_path / "a.h5", result) as kept:
        kept._journal.append = lambda generation: None
        monkeypatch.setattr(Checkpoint, "_write_all", write)
        for number in range(1, 1001):
            now[0] += 1.0 / 3.0
            held[0] += 1000
            kept.put(generation, 1000 * number, lambda number=number: 1000 * number)
            kept._wait()
            most = max(most, held[0])
    assert most < 350_000
    assert spent[0] < 0.05 * (now[0] - 100.0)


def test_a_journal_has_some_bytes_more_than_the_numbers_of_its_candidates(tmp_path: Path):
    result, parameters = search_result(), 10
    with Checkpoint.begin(tmp_path / "a.h5", result) as kept:
        empty = journal_path(tmp_path / "a.h5").stat().st_size
        for number in range(5):
            generation = repeated(5000, number, parameters)
            kept.put(generation, 5000 * number, lambda: result)
        kept._wait()
        size = journal_path(tmp_path / "a.h5").stat().st_size - empty
        assert size / 5 < sum(getattr(generation, name).nbytes for name in TABLE) + 4000
        kept.finish(result)
    assert not journal_path(tmp_path / "a.h5").exists()
