"""Journals of runs that have ended spare opening their files, and count only where they tell of these very files."""

import os
from pathlib import Path

import numpy as np
import pytest

from small_sweep import assert_same_file
from warpmuscle.sweep import gather as gather_module
from warpmuscle.sweep.finished import PATTERN, FinishedRuns
from warpmuscle.sweep.folder import Folder
from warpmuscle.sweep.gather import gather
from warpmuscle.sweep.run import sweep

TEXT = """
scene = "fwalk"
[set]
duration = 0.05
[search]
strategy = "random"
population = 3
candidates = 5
[grid]
seed = [1, 2, 3]
objective.torque = [1, 2]
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("done")
    (folder / "a.toml").write_text(TEXT)
    sweep(folder / "a.toml", folder / "a.h5", device="cpu", command="test")
    return folder / "a.h5"


def gathered(done: Path, output: Path) -> Path:
    folder = Folder.of(done)
    manifest = folder.manifest()
    gather(folder, manifest, folder.states(manifest), output, "test")
    return output


def test_what_is_gathered_is_the_same_with_and_without_them(done, tmp_path, monkeypatch):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gather_module.hdf5, "opened_bytes", None)  # no file is opened
        with_them = gathered(done, tmp_path / "with.h5")
    for path in Folder.of(done).path.glob(PATTERN):
        monkeypatch.setattr(FinishedRuns, "table", lambda *arguments: None)
        assert path.stat().st_size > 0
    assert_same_file(gathered(done, tmp_path / "without.h5"), with_them)


def test_a_file_that_has_been_touched_is_opened(done):
    folder = Folder.of(done)
    name = folder.manifest().runs[2].name
    stamp = folder.result(name).stat()
    finished = FinishedRuns(folder.path)
    known = finished.table(name, stamp.st_size, stamp.st_mtime_ns)
    assert known is not None
    assert known.best is not None
    assert known.best[1] == known.columns["cost"].min()
    assert finished.state(name, (stamp.st_size, stamp.st_mtime_ns)) == (known.ended, 5, known.best[1])
    assert finished.table(name, stamp.st_size, stamp.st_mtime_ns + 1) is None
    assert finished.state(name, (stamp.st_size + 1, stamp.st_mtime_ns)) is None
    assert finished.state(name, None) is None
    assert finished.table("another", stamp.st_size, stamp.st_mtime_ns) is None


@pytest.mark.parametrize("size", [0, 5, 100, -1])
def test_torn_and_damaged_journals_are_as_none(size: int, done, tmp_path: Path):
    folder = Folder.of(done)
    (path,) = folder.path.glob(PATTERN)
    content = bytearray(path.read_bytes())
    damaged = content[:size] if size >= 0 else content[:400] + bytes(100) + content[500:]
    (tmp_path / "0.finished").write_bytes(damaged)
    os.mkfifo(tmp_path / "1.finished") if hasattr(os, "mkfifo") else None
    name = folder.manifest().runs[0].name
    stamp = folder.result(name).stat()
    assert FinishedRuns(tmp_path).table(name, stamp.st_size, stamp.st_mtime_ns) is None


def test_numbers_that_are_torn_are_read_from_the_file(done, tmp_path: Path):
    folder = Folder.of(done)
    (path,) = folder.path.glob(PATTERN)
    (tmp_path / "0.finished").write_bytes(path.read_bytes()[:-20])
    run = folder.manifest().runs[0]
    stamp = folder.result(run.name).stat()
    found = FinishedRuns(tmp_path)
    assert found.state(run.name, (stamp.st_size, stamp.st_mtime_ns)) is not None
    assert found.table(run.name, stamp.st_size, stamp.st_mtime_ns) is None
    assert np.isfinite(found.state(run.name, (stamp.st_size, stamp.st_mtime_ns))[2])
