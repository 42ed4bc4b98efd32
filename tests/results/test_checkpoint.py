"""When the file of a search is written anew: not so often that it takes much of the time, however large it is."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from small_result import search_result
from warpmuscle.core.errors import OccupiedError, ResultError
from warpmuscle.results import checkpoint
from warpmuscle.results.checkpoint import Checkpoint


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
