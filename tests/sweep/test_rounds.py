"""What journals of shared batches give back: all that had ended, in order, and nothing that is torn or foreign."""

import json
from pathlib import Path

import numpy as np
import pytest

from small_disk import disk_of
from warpmuscle.core.errors import ResultError
from warpmuscle.core.status import Status
from warpmuscle.optimization.evaluation import Generation
from warpmuscle.results.journal import MAGIC, packed
from warpmuscle.sweep import rounds as rounds_module
from warpmuscle.sweep.rounds import PATTERN, Rounds, known_of, remove_known
from warpmuscle.sweep.shared_batches import Request

NAMES = ["a", "b", "c"]


def generation(number: int, rows: int, width: int = 2) -> Generation:
    """Random candidates, none of which has been evaluated."""
    rng = np.random.default_rng(number)
    return Generation(number, np.arange(rows, dtype=np.int32) % 2, rng.random((rows, width)), ("x", "y"))


def evaluate(one: Generation, rows: list[int]) -> tuple[Request, np.ndarray]:
    """These rows have ended; what would be asked for with them."""
    for row in rows:
        one.cost[row], one.end_time[row], one.status[row] = 10.0 * one.number + row, 0.5, Status.COMPLETED
        one.terms[row] = row
    return rows_of(one, 0)


def rows_of(one: Generation, job: int, rows: list[int] | None = None) -> tuple[Request, np.ndarray]:
    asked = np.arange(len(one.values)) if rows is None else np.array(rows)
    return Request(job, 0, (), one, 9, None, lambda: False), asked


def test_rows_come_back_in_their_order_whenever_they_ended(tmp_path: Path):
    first, second = generation(0, 5), generation(1, 3, width=4)
    rounds = Rounds(tmp_path, NAMES)
    evaluate(first, [4, 1])
    rounds.keep([rows_of(first, 0), rows_of(second, 2)])
    evaluate(first, [0, 2])
    evaluate(second, [1])
    rounds.keep([rows_of(first, 0, [0, 2, 3]), rows_of(second, 2)])
    other = Rounds(tmp_path, NAMES)
    evaluate(first, [3])
    other.keep([rows_of(first, 0, [3])])
    known = known_of(tmp_path)
    assert set(known) == {"a", "c"}
    found = known["a"].generations[0]
    np.testing.assert_array_equal(found.params, first.values)
    np.testing.assert_array_equal(found.cost, [0, 1, 2, 3, 4])
    np.testing.assert_array_equal(found.search, first.search)
    np.testing.assert_array_equal(found.terms[:, 0], [0, 1, 2, 3, 4])
    np.testing.assert_array_equal(known["c"].generations[1].params, second.values[[1]])
    assert not known["a"].elsewhere
    assert set(known_of(tmp_path, ["c"])) == {"c"}


def test_nothing_is_put_down_of_what_has_not_ended(tmp_path: Path):
    Rounds(tmp_path, NAMES).keep([rows_of(generation(0, 4), 0)])
    assert not list(tmp_path.iterdir())


def test_a_torn_record_is_dropped_and_those_before_it_stay(tmp_path: Path):
    one = generation(0, 4)
    rounds = Rounds(tmp_path, NAMES)
    evaluate(one, [0])
    rounds.keep([rows_of(one, 1)])
    (path,) = tmp_path.glob(PATTERN)
    whole = path.read_bytes()
    evaluate(one, [1])
    rounds.keep([rows_of(one, 1, [1])])
    for size in (len(whole), len(whole) + 7, len(path.read_bytes()) - 1):
        (tmp_path / "0.rounds").write_bytes(path.read_bytes()[:size])
        assert len(known_of(tmp_path)["b"].generations[0]) == 2
        path_of_torn = tmp_path / "torn"
        path_of_torn.mkdir(exist_ok=True)
        (path_of_torn / "0.rounds").write_bytes(path.read_bytes()[:size])
        assert len(known_of(path_of_torn)["b"].generations[0]) == 1


def test_full_disk_is_one_line_and_keeps_what_was_there(tmp_path: Path):
    one = generation(0, 40)
    rounds = Rounds(tmp_path, NAMES)
    evaluate(one, [0])
    rounds.keep([rows_of(one, 0)])
    (path,) = tmp_path.glob(PATTERN)
    evaluate(one, list(range(1, 40)))
    with disk_of(path.stat().st_size + 100), pytest.raises(ResultError, match=r"cannot be written: file too large"):
        rounds.keep([rows_of(one, 0, list(range(1, 40)))])
    assert len(known_of(tmp_path)["a"].generations[0]) == 1
    rounds.keep([rows_of(one, 0, list(range(1, 40)))])
    assert len(known_of(tmp_path)["a"].generations[0]) == 40


def test_journals_of_another_version_do_not_count_and_another_machine_is_told(tmp_path: Path, monkeypatch):
    one = generation(0, 2)
    evaluate(one, [0, 1])
    Rounds(tmp_path, NAMES).keep([rows_of(one, 0)])
    monkeypatch.setattr(rounds_module, "this_machine", lambda: {"processor": "other", "blas": "other"})
    assert known_of(tmp_path)["a"].elsewhere
    monkeypatch.setattr(rounds_module, "version_of", lambda package: "0.0.1")
    assert known_of(tmp_path) == {}


@pytest.mark.parametrize(
    "content",
    [b"", b"rubbish", MAGIC, MAGIC + b"rubbish", MAGIC + packed({"identity": np.array("x")}),
     MAGIC + packed({"origin": np.array("{")}), MAGIC + packed({"origin": np.array(json.dumps({"version": 1}))})],
)  # fmt: skip
def test_what_is_no_such_journal_is_as_none(content: bytes, tmp_path: Path):
    (tmp_path / "1.rounds").write_bytes(content)
    assert known_of(tmp_path) == {}
    remove_known(tmp_path, ["a"])
    assert not list(tmp_path.iterdir())


def test_journals_stay_while_a_run_in_them_goes_on(tmp_path: Path):
    one = generation(0, 2)
    evaluate(one, [0])
    rounds = Rounds(tmp_path, NAMES)
    rounds.keep([rows_of(one, 1)])
    remove_known(tmp_path, ["b"])
    assert len(list(tmp_path.iterdir())) == 1
    remove_known(tmp_path, ["a", "c"])
    assert not list(tmp_path.iterdir())
    rounds.clear()
    assert not list(tmp_path.iterdir())
