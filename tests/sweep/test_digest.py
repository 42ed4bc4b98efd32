"""Which sweeps go on with an earlier one: runs are the same where their files have been moved together."""

from pathlib import Path

import msgspec
import pytest

from warpmuscle.core.errors import ResultError
from warpmuscle.formats import toml
from warpmuscle.sweep.folder import Folder, entries_of
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.plan.digest import Text, digest, named_from

SWEEP = """
scene = "fwalk"
[search]
candidates = 4
[set]
objective.tracking = 1.0
tracking = {{ file = "{file}" }}
[grid]
seed = [1, 2]
"""


def plan_of(folder: Path, file: str) -> Plan:
    folder.mkdir(exist_ok=True)
    (folder / "walks.toml").write_text(SWEEP.format(file=file))
    return read(folder / "walks.toml")


def digests(plan: Plan) -> list[str]:
    return [entry.digest for entry in entries_of(plan)]


def test_a_gait_that_lies_beside_the_sweep_is_the_same_wherever_both_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    here = digests(plan_of(Path("here"), "here/gait.npz"))
    assert here[0] != here[1]  # their seeds are others
    assert digests(plan_of(tmp_path / "here", str(tmp_path / "here" / "gait.npz"))) == here
    assert digests(plan_of(Path("there"), "there/gait.npz")) == here
    assert not set(digests(plan_of(Path("there"), "here/gait.npz"))) & set(here)
    assert not set(digests(plan_of(Path("there"), "there/other.npz"))) & set(here)
    monkeypatch.chdir(tmp_path / "here")
    assert digests(plan_of(Path(), "gait.npz")) == here


def test_a_scene_that_follows_no_file_is_named_by_all_of_it(tmp_path: Path) -> None:
    for name in ("fwalk", "gait2392_arms", "walk56"):
        scene = read(written(tmp_path, name)).runs[0].scene
        assert msgspec.msgpack.encode(named_from(tmp_path, scene)) == msgspec.msgpack.encode(scene)


def written(folder: Path, scene: str) -> Path:
    file = folder / f"{scene}.toml"
    file.write_text(f'scene = "{scene}"\n[search]\ncandidates = 4\n')
    return file


@pytest.mark.parametrize("text", [msgspec.msgpack.encode, toml.dumps])
def test_what_began_with_a_version_that_named_files_as_they_were_given_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: Text
) -> None:
    monkeypatch.chdir(tmp_path)
    plan = plan_of(Path("here"), "here/gait.npz")
    folder = Folder.of(Path("walks.h5"))
    folder.path.mkdir()
    now = folder.begin(plan, "cpu")
    before = [
        msgspec.structs.replace(entry, digest=digest(run, {}, text))
        for entry, run in zip(now.runs, plan.runs, strict=True)
    ]
    assert [entry.digest for entry in before] != [entry.digest for entry in now.runs]
    earlier = msgspec.structs.replace(now, runs=tuple(before))
    (folder.path / "sweep.json").write_bytes(msgspec.json.encode(earlier))
    assert folder.begin(plan, "cpu") == earlier
    with pytest.raises(ResultError, match="is another"):
        folder.begin(plan_of(Path("here"), "here/other.npz"), "cpu")
