"""A shipped scene that is read again is the same as the first time, and nobody else's."""

import msgspec
import pytest

import loaded_once
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.formats.load import shipped_scenes


@pytest.mark.parametrize("name", ["walk56", "throw", "gait2392_walk", "arm18"])
def test_a_copy_is_what_is_read(name: str):
    first, again = [], []
    path = shipped_scenes()[name]
    wanted = toml.read.as_ever(path, first)
    for _ in range(2):
        again.clear()
        found = toml.read(path, again)
        assert found == wanted
        assert msgspec.to_builtins(found) == msgspec.to_builtins(wanted)  # the same values, not only equal ones
        assert found is not wanted
        assert list(map(str, again)) == list(map(str, first))
    found.duration = found.duration + 1.0
    next(iter(found.character.bodies.values())).mass = 99.0
    assert toml.read(path) == wanted
    with pytest.raises(KeyError, match="nobody"):
        toml.read(path).character.bodies["nobody"]


def test_who_changes_how_scenes_are_read_reads_them_so(monkeypatch: pytest.MonkeyPatch):
    load("walk56")
    said = SceneError("refused", "name")

    def refuse(scene: object) -> None:
        raise said

    monkeypatch.setattr(toml, "check_scene", refuse)
    with pytest.raises(SceneError, match="refused"):
        load("walk56")


def test_files_elsewhere_are_read_every_time(tmp_path):
    path = tmp_path / "mine.toml"
    for seconds in (1.0, 2.0):
        path.write_text(f'base = "fwalk"\nname = "mine"\nduration = {seconds}\n')
        assert load(path).duration == seconds
    assert loaded_once.SCENES.is_dir()
