"""Shipped scenes: a folder for each study, each scene found by its name alone."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.shipped import CHARACTERS, STUDIES, is_scene, scene_groups, scenes_folder, shipped_file
from warpmuscle.formats import load, scene_names

FILES = sorted(scenes_folder().rglob("*.toml"))


def test_every_file_lies_in_the_folder_of_a_study_and_no_two_have_one_name():
    assert {path.parent.relative_to(scenes_folder()).as_posix() for path in FILES} == {*STUDIES, CHARACTERS}
    assert len({path.name for path in FILES}) == len(FILES)
    assert all(shipped_file(path.stem) == path == shipped_file(path.name) for path in FILES)
    assert shipped_file("nothing") is None


def test_groups_hold_every_scene_once_and_the_shared_characters_are_none():
    groups = scene_groups()
    assert sorted(name for names in groups.values() for name in names) == scene_names()
    assert len(scene_names()) == len(set(scene_names())) > 40
    assert all(groups.values())
    assert not any(is_scene(path) for path in FILES if path.parent.name == CHARACTERS)


def test_superseded_scenes_are_those_that_pages_or_other_scenes_rest_on():
    root = scenes_folder().parents[1]
    others = [*(root / "docs").rglob("*.md*"), *(path for path in FILES if path.parent.name != "superseded")]
    texts = [path.read_text() for path in others]
    assert [name for name in scene_groups()["superseded"] if not any(name in text for text in texts)] == []


@pytest.mark.parametrize("line", ['base = "{}/fwalk.toml"', 'base = "fwalk"\ncharacter = ["{}/biped.toml"]'])
def test_a_path_to_a_shipped_scene_of_before_says_what_to_write(line: str, tmp_path: Path):
    mine = tmp_path / "mine.toml"
    mine.write_text('name = "mine"\n' + line.format(tmp_path / "clone/scenes"))
    with pytest.raises(
        SceneError, match=r"have folders of their own now; write the name alone, \"(fwalk|biped)\"$"
    ) as error:
        load(mine)
    assert (error.value.file, error.value.line) == (mine, 1 + line.count("\n") + 1)
    with pytest.raises(SceneError, match='write the name alone, "fwalk"'):
        load(tmp_path / "clone/scenes/fwalk.toml")


def test_a_file_of_the_users_own_in_a_folder_called_scenes_is_his(tmp_path: Path):
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "fwalk.toml").write_text('base = "bwalk"\nname = "mine"\n')
    assert load(folder / "fwalk.toml").name == "mine"
    (tmp_path / "on.toml").write_text('base = "scenes/fwalk.toml"\nname = "on"\n')
    assert load(tmp_path / "on.toml").controller == load("bwalk").controller
