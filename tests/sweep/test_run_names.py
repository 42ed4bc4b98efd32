"""Names of scenes and runs never choose a file outside of the folder."""

from pathlib import Path

import msgspec
import pytest

from small_sweep import RUNS, small_sweep
from warpmuscle.core.errors import ResultError, SceneError
from warpmuscle.formats import load, toml
from warpmuscle.sweep import gather
from warpmuscle.sweep.folder import MANIFEST, Folder, Manifest, RunEntry
from warpmuscle.sweep.plan import read

HOSTILE = """
scene = "fwalk"
[search]
candidates = 2
[[run]]
name = "../../x"
[[run]]
name = "/tmp/x"
[[run]]
name = "con"
[[run]]
name = "a"
[[run]]
name = "A"
[[run]]
name = ".."
[[run]]
name = "%s"
"""


def test_names_of_runs_stay_in_the_folder_and_differ_on_every_file_system(tmp_path):
    (tmp_path / "a.toml").write_text(HOSTILE % ("ü" * 400))
    names = [run.name for run in read(tmp_path / "a.toml").runs]
    folder = Folder(tmp_path / "a.sweep")
    assert all(folder.result(name).resolve().parent == folder.path.resolve() for name in names)
    assert len({name.casefold() for name in names}) == len(names) == 7
    assert all(len(f"{name}.h5.journal".encode()) < 255 for name in names)
    assert names[2] == "_con"


@pytest.mark.parametrize("name", ["../secret", "/etc/x", "a/b", "..", ""])
def test_manifest_that_names_files_elsewhere_is_refused(name, tmp_path):
    folder = Folder(tmp_path / "a.sweep")
    folder.path.mkdir()
    manifest = Manifest("a", "", "token", "cpu", (RunEntry(name, "", 1, 1, {}),))
    (folder.path / MANIFEST).write_bytes(msgspec.json.encode(manifest))
    with pytest.raises(ResultError, match="cannot be the name of a run"):
        folder.manifest()


def test_manifest_of_usual_runs_is_read(tmp_path):
    folder = Folder(tmp_path / "a.sweep")
    folder.path.mkdir()
    folder.begin(read(small_sweep(tmp_path)), "cpu")
    assert len(folder.manifest().runs) == RUNS


@pytest.mark.parametrize("axis", [".", "..", "a/b", "a\0b"])
def test_axes_get_names_that_hdf5_takes(axis):
    assert not set(gather._dataset_name(axis)) & {"/", "\0"}
    assert gather._dataset_name(axis).strip(".")


def test_name_that_no_file_can_hold_is_refused_before_the_work(tmp_path: Path):
    text = toml.dumps(load("fwalk")).replace("lToeJoint", '"l\\u0000"', 1)
    (tmp_path / "a.toml").write_text(text)
    with pytest.raises(SceneError, match="character that no file can hold"):
        load(tmp_path / "a.toml")
