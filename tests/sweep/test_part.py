"""Which runs a part of a sweep has, and where it keeps them."""

from pathlib import Path

import pytest

from small_sweep import RUNS, small_sweep
from warpmuscle.core.errors import Error
from warpmuscle.sweep.folder import MANIFEST
from warpmuscle.sweep.part import Part, named_part, part_folders, part_of
from warpmuscle.sweep.plan import read


def test_parts_share_all_runs_evenly(tmp_path: Path):
    plan = read(small_sweep(tmp_path))
    for total in (1, 3, RUNS):
        parts = [Part(number, total).of(plan).runs for number in range(1, total + 1)]
        names = [run.name for runs in parts for run in runs]
        assert sorted(names) == sorted(run.name for run in plan.runs)
        assert max(map(len, parts)) - min(map(len, parts)) <= 1


@pytest.mark.parametrize(
    "text", ["", "3", "3/", "/4", "0/4", "5/4", "1/0", "-1/4", "1.5/4", "3/4/5", "٣/4", "1/1000001"]
)
def test_what_is_no_part_is_refused(text: str):
    with pytest.raises(Error, match="such as 3/40"):
        part_of(text)


def test_a_number_beyond_the_parts_is_told_which_there_are():
    with pytest.raises(Error, match="the first is 1 to 4 here"):
        part_of("5/4")


def test_a_part_without_runs_is_refused(tmp_path: Path):
    with pytest.raises(Error, match=f"part 9/9 has no runs; the sweep has {RUNS} runs"):
        part_of("9/9").of(read(small_sweep(tmp_path)))


def test_only_folders_of_this_output_count_as_its_parts(tmp_path: Path):
    output = tmp_path / "a[1].h5"
    for name in ("a[1].part-2-of-2.sweep", "a[1].part-02-of-2.sweep", "a1.part-1-of-2.sweep", "b.part-1-of-2.sweep"):
        (tmp_path / name).mkdir()
        (tmp_path / name / MANIFEST).write_text("{}")
    (tmp_path / "a[1].part-1-of-2.sweep").mkdir()  # nothing has begun in it
    assert list(part_folders(output)) == [Part(2, 2)]
    assert part_folders(output)[Part(2, 2)].path == Part(2, 2).folder(output).path
    assert named_part(Path("x.part-3-of-40.sweep")) == Part(3, 40)
    assert named_part(Path("x.sweep")) is None
