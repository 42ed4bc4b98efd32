"""Kernels are found in Warp's cache by hashes that an earlier process has left there, and are the same kernels."""

import json
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
import warp as wp

from patience import PATIENCE
from warpmuscle.kernels import known_kernels
from warpmuscle.kernels.functions import LateFunction
from warpmuscle.kernels.known_kernels import Hashes, Postponed, known_kernel
from warpmuscle.kernels.muscle.effort import muscle_effort_of
from warpmuscle.kernels.recording.record import NOTHING, RecordKind, frame_of
from warpmuscle.kernels.step import step_kernel
from warpmuscle.kernels.step_parts import StepKind

# A walk of a moment in a process of its own, and what it parsed for that.
WALK = """
import sys
from warpmuscle.core.warp_start import start_warp
from warpmuscle.kernels import functions, known_kernels

start_warp()
if "remember" in sys.argv:
    known_kernels.remember()
parsed, parse = [], functions.LateFunction._parse
functions.LateFunction._parse = lambda self: (parsed.append(self.func.__name__), parse(self))
import warpmuscle as wm

run = wm.Rollout("fwalk", 2, "cpu", threads=1)
name = run._launcher.kernel().kernel.module.name
run.run(0.05)
print(name, len(parsed), run.state.coordinates.numpy().tobytes().hex())
"""
OTHER = 1


@pytest.fixture
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    monkeypatch.setattr(known_kernels, "_remembering", False)
    muscle_effort_of()  # as it is without
    known_kernels.remember()
    return tmp_path


def walked(*words: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-c", WALK, *words], capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    return done.stdout.split()


def test_a_walk_by_hashes_of_an_earlier_process_is_the_same_to_the_bit_and_parses_next_to_nothing():
    name, parsed, coordinates = walked()
    walked("remember")  # which leaves the hashes, unless an earlier run of this test has
    assert int(parsed) > 80
    again = walked("remember")
    assert again[::2] == [name, coordinates]
    assert int(again[1]) < int(parsed) / 3


def test_hashes_are_left_once_and_taken_over(folder: Path, monkeypatch: pytest.MonkeyPatch):
    usual = muscle_effort_of()
    assert not list(folder.iterdir())
    made = muscle_effort_of.__wrapped__()
    (file,) = folder.iterdir()
    kept = json.loads(file.read_text())
    assert bytes.fromhex(kept["kernel"]) == usual.hash == made.hash
    assert kept["dimensions"] == usual.adj.kernel_dim == 2
    assert usual.module.name.endswith(kept["module"][:8])
    file.write_text(json.dumps(kept | {"module": "ab" * known_kernels.BYTES}))
    assert muscle_effort_of.__wrapped__().module.name.endswith("_abababab")
    monkeypatch.setattr(known_kernels, "_remembering", False)
    assert muscle_effort_of.__wrapped__().module.name == usual.module.name


@pytest.mark.parametrize(
    "kept",
    [
        "", "[]", '{"module": "ab"}', '{"module": 3, "kernel": "", "dimensions": 2}',
        '{"module": "%s", "kernel": "%s", "dimensions": 9}' % ((64 * "a",) * 2),
        '{"module": "%s", "kernel": "ab", "dimensions": 2}' % (64 * "a"),
    ],
)  # fmt: skip
def test_hashes_that_are_damaged_are_found_anew(folder: Path, kept: str):
    usual = muscle_effort_of()
    muscle_effort_of.__wrapped__()
    (file,) = folder.iterdir()
    good = file.read_text()
    file.write_text(kept)
    assert muscle_effort_of.__wrapped__().module.name == usual.module.name
    assert file.read_text() == good


def test_a_folder_that_takes_nothing_is_left_alone(folder: Path):
    folder.rmdir()
    folder.write_text("a file")
    known_kernels._write(folder / "hashes.json", Hashes(b"", b"", 1))
    assert folder.read_text() == "a file"


def test_other_sources_or_kinds_are_other_kernels(folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    kinds = [StepKind(), StepKind(collisions=True), StepKind(recorded=NOTHING), StepKind(recorded=RecordKind(False))]
    files = {known_kernels._file("step_many", 4, 1, kind) for kind in kinds}
    assert len(files) == len(kinds)
    assert None not in files
    assert known_kernels._file("step_many", 4, 1, StepKind()) in files
    assert known_kernels._file("step_many", 4, True, StepKind()) not in files
    sources = tmp_path / "sources"
    (sources / "room").mkdir(parents=True)
    (sources / "room" / "law.py").write_text("GAIN = 1.0")
    monkeypatch.setattr(known_kernels, "FOLDER", sources)
    before = known_kernels._file("step_many", StepKind())
    (sources / "room" / "law.py").write_text("GAIN = 2.0")
    after = known_kernels._file("step_many", StepKind())
    (sources / "room" / "law.py").rename(sources / "room" / "lore.py")
    assert len({before, after, known_kernels._file("step_many", StepKind())}) == 3


def closing_over(number: object) -> Callable[[], object]:
    def own() -> object:
        return number

    own.__module__ = "warpmuscle.kernels.step"
    return own


def test_closures_are_told_apart_and_what_others_wrote_is_not_known():
    words = known_kernels._in_words
    assert words(closing_over(1)) != words(closing_over(2))
    assert words(closing_over(1)) == words(cache(closing_over(1)))
    assert words(closing_over(frame_of)) != words(closing_over(None))
    assert isinstance(frame_of, LateFunction)
    for one in (test_other_sources_or_kinds_are_other_kernels, closing_over(object()), object(), Path, {"a": 1}):
        with pytest.raises(known_kernels._Unknown):
            words(one)
    assert known_kernels._file("step_many", closing_over(object())) is None


def test_a_kernel_with_functions_of_users_leaves_nothing(folder: Path):
    @known_kernel(test_a_kernel_with_functions_of_users_leaves_nothing, enable_backward=False)
    def shipped(of: wp.array[float]):
        of[wp.tid()] = float(wp.static(OTHER))

    assert shipped.hash
    assert not list(folder.iterdir())


def test_a_command_that_runs_other_code_forgets(folder: Path):
    known_kernels.forget()
    muscle_effort_of.__wrapped__()
    assert not list(folder.iterdir())


def test_a_postponed_function_is_made_when_it_is_asked_for():
    made = []

    def make() -> object:
        made.append(1)
        return frame_of

    one = Postponed("one", make)
    assert one.__name__ == "one"
    assert not made
    assert one.key == frame_of.key
    assert one.adj is frame_of.adj
    assert made == [1]
    with pytest.raises(AttributeError, match="nothing"):
        one.nothing  # noqa: B018


def test_a_step_that_has_to_be_compiled_after_all_has_all_its_functions(folder: Path):
    kind = StepKind(recorded=NOTHING)
    first = step_kernel.__wrapped__(4, 1, 1, kind)
    again = step_kernel.__wrapped__(4, 1, 1, kind)
    assert (first.module.name, first.hash) == (again.module.name, again.hash)
    assert len(list(folder.iterdir())) == 1
