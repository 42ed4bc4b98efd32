"""Parts of a sweep, each run by itself, become the file that one process would have made."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import command_line
from child_signals import running
from patience import PATIENCE, until
from small_sweep import RUNS, assert_same_file, small_sweep
from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.sweep.folder import MANIFEST, Folder, Manifest
from warpmuscle.sweep.join import join
from warpmuscle.sweep.part import Part
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.plan.digest import digest
from warpmuscle.sweep.run import sweep
from warpmuscle.sweep.status import sweep_status


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """Output of one process."""
    folder = tmp_path_factory.mktemp("whole")
    sweep(small_sweep(folder), folder / "small.h5", device="cpu", command="test")
    return folder / "small.h5"


@pytest.fixture(scope="module")
def parts(tmp_path_factory) -> Path:
    """A folder with the sweep file and three parts."""
    folder = tmp_path_factory.mktemp("parts")
    file = small_sweep(folder)
    for number in (1, 2, 3):
        sweep(file, folder / "small.h5", device="cpu", command="test", part=f"{number}/3")
    assert not (folder / "small.h5").exists()
    return folder


def test_parts_become_the_file_of_one_process(parts: Path, whole: Path):
    assert sweep_status(parts / "small.toml").ended == RUNS
    output = parts / "small.h5"
    assert join(read(parts / "small.toml"), output, command="test").gathered == RUNS
    assert_same_file(output, whole)
    before = output.read_bytes()
    join(read(parts / "small.toml"), output, command="test")
    assert output.read_bytes() == before
    sweep(parts / "small.toml", output, device="cpu", command="test")  # has nothing left to do
    assert output.read_bytes() == before


def test_parts_from_elsewhere_are_joined_by_their_folders(parts: Path, whole: Path, tmp_path: Path):
    folders = [Part(number, 3).folder(parts / "small.h5").path for number in (3, 1, 2)]
    output = tmp_path / "other.h5"
    join(read(parts / "small.toml"), output, folders, command="test")
    assert_same_file(output, whole)


def test_what_is_missing_is_named_with_its_part(parts: Path, tmp_path: Path):
    plan, output = read(parts / "small.toml"), tmp_path / "some.h5"
    folders = [Part(number, 3).folder(parts / "small.h5").path for number in (1, 3)]
    with pytest.raises(Error) as caught:
        join(plan, output, folders)
    assert f"3 of {RUNS} runs have not ended: 'seed=1,torso.mass=20,torque=2', " in str(caught.value)
    assert "of part 2 of 3: `warpmuscle sweep" in str(caught.value)
    assert not list(tmp_path.iterdir())
    assert join(plan, output, folders, incomplete=True).gathered == RUNS - 3
    assert join(plan, output, [Part(2, 3).folder(parts / "small.h5").path]).gathered == RUNS


def test_parts_that_an_earlier_version_began_are_joined(parts: Path, whole: Path, tmp_path: Path):
    plan, folders = read(parts / "small.toml"), []
    runs = {run.name: run for run in plan.runs}
    for number in (1, 2, 3):
        part = Part(number, 3).folder(parts / "small.h5").path
        folders.append(tmp_path / part.name)
        shutil.copytree(part, folders[-1])
        entries = Folder(part).manifest().runs
        older = [msgspec.structs.replace(e, digest=digest(runs[e.name], {}, toml.dumps)) for e in entries]
        assert all(e.digest not in {now.digest for now in entries} for e in older)
        changed(part, tmp_path / f"{number}", runs=tuple(older)).joinpath(MANIFEST).replace(folders[-1] / MANIFEST)
    join(plan, tmp_path / "small.h5", folders, command="test")
    assert_same_file(tmp_path / "small.h5", whole)
    with pytest.raises(Error, match="is another in this sweep"):
        join(read(small_sweep(tmp_path, candidates=21)), tmp_path / "small.h5", folders)


def changed(source: Path, target: Path, **fields: object) -> Path:
    """A copy of the manifest of a part with other fields."""
    manifest = msgspec.json.decode((source / MANIFEST).read_bytes(), type=Manifest)
    target.mkdir()
    (target / MANIFEST).write_bytes(msgspec.json.encode(msgspec.structs.replace(manifest, **fields)))
    return target


def test_parts_of_other_sweeps_and_devices_are_refused(parts: Path, tmp_path: Path):
    plan, output = read(parts / "small.toml"), tmp_path / "small.h5"
    one = Part(1, 3).folder(parts / "small.h5").path
    other = changed(one, tmp_path / "small.part-1-of-3.sweep", device="cuda")
    with pytest.raises(Error, match=r"begun on cpu and .* on cuda"):
        join(plan, output, [one, other])
    with pytest.raises(Error, match=r"small.toml or its scene has changed since"):
        join(read(small_sweep(tmp_path, candidates=21)), output, [one])
    with pytest.raises(Error, match=r"there are no parts to join beside it, such as none\.part-1-of-2"):
        join(plan, tmp_path / "none.h5")
    (other / MANIFEST).write_text(json.dumps({"name": 3}))
    with pytest.raises(Error, match=r"sweep.json: damaged"):
        join(plan, output, [other])
    with Folder(one).at_work(), pytest.raises(Error, match="a process is at work on this part"):
        join(plan, output, [one])
    assert not output.exists()


def test_a_cut_file_of_a_run_counts_as_missing(parts: Path, tmp_path: Path):
    plan, output = read(parts / "small.toml"), tmp_path / "small.h5"
    copies = []
    for number in (1, 2, 3):
        source, target = (Part(number, 3).folder(at / "small.h5").path for at in (parts, tmp_path))
        target.mkdir()
        copies.append(target)
        for path in source.iterdir():
            (target / path.name).write_bytes(path.read_bytes())
    cut = next(copies[1].glob("*.h5"))
    cut.write_bytes(cut.read_bytes()[:3000])
    with pytest.raises(Error, match=rf"1 of {RUNS} runs have not ended: '{cut.stem}'; they are of part 2 of 3") as told:
        join(plan, output)
    assert f"{cut} is damaged: remove it first" in str(told.value)


# A program that, once it has evaluated something, waits to be asked to end.
UNTIL_ASKED = """
import time
from warpmuscle.cli.program import main
from warpmuscle.core.interruption import received
from warpmuscle.results.journal import Journal

append = Journal.append

def append_and_wait(*arguments):
    append(*arguments)
    while not received():
        time.sleep(0.01)

Journal.append = append_and_wait
main()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="no such signal on this system")
def test_a_part_that_is_asked_to_end_goes_on_and_joins_to_the_same(tmp_path: Path):
    file = small_sweep(tmp_path)
    first = ["sweep", "small.toml", "--device", "cpu", "--part", "1/2"]
    with running([sys.executable, "-c", UNTIL_ASKED, *first], cwd=tmp_path, stdout=subprocess.DEVNULL) as process:
        until(lambda: evaluated(tmp_path), process)
        os.kill(process.pid, signal.SIGUSR1)
        assert process.wait(PATIENCE) == 128 + signal.SIGUSR1
    assert 0 < evaluated(tmp_path) < 20 * RUNS / 2
    for arguments in (first, [*first[:-1], "2/2"], ["join", "small.toml", "-o", "small.h5"]):
        done = command_line.run(*arguments, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    assert f"wrote small.h5 with {RUNS} runs" in done.stdout
    sweep(file, tmp_path / "whole.h5", device="cpu", command="warpmuscle sweep small.toml")
    assert_same_file(tmp_path / "small.h5", tmp_path / "whole.h5")


def evaluated(folder: Path) -> int:
    try:
        return sweep_status(folder / "small.toml").evaluated
    except Error:
        return 0
