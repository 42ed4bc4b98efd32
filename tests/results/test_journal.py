"""The journal: gives back bit for bit what is whole, drops what is torn, and says plainly why it cannot be used."""

from pathlib import Path

import numpy as np
import pytest

from same_values import assert_same
from small_disk import disk_of
from warpmuscle.core.errors import ResultError
from warpmuscle.results.journal import Journal
from warpmuscle.results.records import Evaluations


def generation(number: int, count: int = 5) -> Evaluations:
    """Candidates of a generation."""
    rng = np.random.default_rng(number)
    whole = (rng.integers(0, 8, count).astype(np.int32) for _ in range(3))
    numbers = np.full(count, number, dtype=np.int32)
    terms = np.where(rng.random((count, 2)) < 0.2, np.nan, rng.random((count, 2)))
    params, cost, end_time = rng.random((count, 3)), rng.random(count), rng.random(count)
    return Evaluations(
        params, cost, next(whole), end_time, next(whole), numbers, next(whole), terms, ("torque", "größe")
    )


def filled(path: Path, generations: int = 3) -> None:
    """A journal with so many generations."""
    with Journal(path, "run") as journal:
        for number in range(generations):
            journal.append(generation(number))


def found(path: Path) -> list[Evaluations]:
    with Journal(path, "run") as journal:
        return journal.generations()


def test_generations_come_back_bit_for_bit_and_go_on(tmp_path):
    path = tmp_path / "a.journal"
    filled(path)
    assert_same(tuple(found(path)), tuple(map(generation, range(3))))
    with Journal(path, "run") as journal:
        journal.append(generation(3))
    assert_same(tuple(found(path)), tuple(map(generation, range(4))))


def test_torn_last_record_is_dropped_and_written_over(tmp_path):
    path = tmp_path / "a.journal"
    filled(path, 2)
    whole = len(path.read_bytes())
    filled_further = tmp_path / "b.journal"
    filled(filled_further, 3)
    content = filled_further.read_bytes()
    for length in (*range(whole, whole + 20), (whole + len(content)) // 2, len(content) - 1):
        path.write_bytes(content[:length])
        with Journal(path, "run") as journal:
            assert len(journal.generations()) == 2
            journal.append(generation(2))
        assert_same(tuple(found(path)), tuple(map(generation, range(3))))


def test_damaged_last_record_is_dropped(tmp_path):
    path = tmp_path / "a.journal"
    filled(path)
    content = bytearray(path.read_bytes())
    content[-100] ^= 1
    path.write_bytes(content)
    assert len(found(path)) == 2


def test_torn_beginning_is_a_new_journal(tmp_path):
    path = tmp_path / "a.journal"
    filled(path, 0)
    content = path.read_bytes()
    for length in (0, 1, 20, 30, len(content) - 1):
        path.write_bytes(content[:length])
        assert found(path) == []
        assert path.read_bytes() == content


def test_cleared_journal_is_as_new(tmp_path):
    path = tmp_path / "a.journal"
    filled(path)
    with Journal(path, "run") as journal:
        journal.clear()
        journal.append(generation(7))
    assert_same(tuple(found(path)), (generation(7),))


def test_foreign_files_are_refused_and_left_alone(tmp_path):
    path = tmp_path / "a.journal"
    filled(path)
    content = path.read_bytes()
    with pytest.raises(ResultError, match=r"a\.journal: the journal of another search"):
        Journal(path, "other")
    assert path.read_bytes() == content
    path.write_text("dear diary")
    with pytest.raises(ResultError, match=r"a\.journal: not a journal"):
        Journal(path, "run")
    assert path.read_text() == "dear diary"


def test_two_processes_cannot_write_it(tmp_path):
    with Journal(tmp_path / "a.journal", "run"), pytest.raises(ResultError, match="another process is at work"):
        Journal(tmp_path / "a.journal", "run")


@pytest.mark.parametrize("name", ["nowhere/a.journal", "folder"])
def test_unwritable_place_is_one_clear_error(name, tmp_path):
    (tmp_path / "folder").mkdir()
    with pytest.raises(ResultError, match=r"cannot be written: (its folder does not exist|this is a folder)"):
        Journal(tmp_path / name, "run")


def test_full_disk_is_one_clear_error_and_leaves_what_is_whole(tmp_path):
    path = tmp_path / "a.journal"
    filled(path, 2)
    with disk_of(path.stat().st_size + 100), Journal(path, "run") as journal:
        with pytest.raises(ResultError, match=r"a\.journal: cannot be written: file too large"):
            journal.append(generation(2))
        assert path.stat().st_size < path.stat().st_size + 100
    assert len(found(path)) == 2
