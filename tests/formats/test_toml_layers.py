"""Scenes made of several files: characters in parts, scenes based on scenes, and where errors are placed."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml

LEG = """root = "pelvis"
[bodies]
pelvis = { mass = 10, inertia = [1, 1, 1] }
leg = { mass = 1, inertia = [1, 1, 1] }

[joints.hip]
type = "hinge"
parent = "pelvis"
child = "leg"
position_in_parent = [0, 0, 0]
position_in_child = [0, 0, 0]
axes = [[1, 0, 0]]
"""
MUSCLE = """[muscles.flexor]
path = [{ body = "pelvis", position = [0, 0, 0.1] }, { body = "leg", position = [0, -0.1, 0.1] }]
f_max = 100
l_opt = 0.05
l_slack = 0.05
"""
STRONGER = """[muscles]
flexor = { f_max = 250 }
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a character in three parts."""
    for name, text in {"leg": LEG, "muscle": MUSCLE, "stronger": STRONGER}.items():
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path


def scene(folder: Path, text: str, name: str = "scene") -> Path:
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def test_later_parts_of_a_character_add_to_earlier_ones_key_by_key(folder):
    text = 'name = "s"\ncharacter = ["leg.toml", "muscle.toml", "stronger.toml"]\n'
    muscle = toml.read(scene(folder, text)).character.muscles["flexor"]
    assert (muscle.f_max, muscle.l_opt, len(muscle.path)) == (250.0, 0.05, 2)


def test_a_scene_takes_from_its_base_what_it_does_not_say(folder):
    scene(folder, 'name = "low"\ncharacter = "leg.toml"\nduration = 2\ngravity = 1\n', "low")
    scene(folder, 'name = "middle"\nbase = "low.toml"\ngravity = 2\n[failure]\nheading = 0\n', "middle")
    read = toml.read(scene(folder, 'name = "high"\nbase = "middle.toml"\n[failure]\ncom_height = 0.5\n'))
    assert (read.name, read.duration, read.gravity) == ("high", 2.0, 2.0)
    assert (read.failure.heading, read.failure.com_height) == (0.0, 0.5)
    assert read.character.root == "pelvis"


def test_a_controller_of_another_type_replaces_that_of_the_base_and_one_of_no_type_changes_it(folder):
    low = 'name = "low"\ncharacter = "leg.toml"\n[controller]\ntype = "theirs:made"\nparameters = { rate = 1 }\n'
    scene(folder, low, "low")
    high = 'name = "high"\nbase = "low.toml"\n[controller]\n'
    changed = toml.read(scene(folder, high + "parameters = { rate = 2 }\n")).controller
    assert (changed.type, changed.parameters) == ("theirs:made", {"rate": 2.0})
    other = 'type = "joint_pd"\n[controller.by_joint]\nothers = { kp = 1, kd = 2, angle = 0 }\n'
    replaced = toml.read(scene(folder, high + other)).controller
    assert (replaced.type, replaced.parameters) == ("joint_pd", {})


def test_a_character_of_its_own_replaces_that_of_the_base(folder):
    scene(folder, 'name = "low"\ncharacter = "leg.toml"\n', "low")
    read = toml.read(scene(folder, 'name = "high"\nbase = "low.toml"\ncharacter = ["leg.toml", "muscle.toml"]\n'))
    assert list(read.character.muscles) == ["flexor"]


def test_files_of_a_base_are_found_beside_the_base(folder, tmp_path_factory):
    scene(folder, 'name = "low"\ncharacter = "leg.toml"\n', "low")
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    read = toml.read(scene(elsewhere, f'name = "high"\nbase = "{(folder / "low.toml").as_posix()}"\n'))
    assert read.character.root == "pelvis"


def test_items_of_a_list_are_changed_by_number(folder):
    low = 'name = "low"\ncharacter = "leg.toml"\n[initial_state]\nroot_position = [1, 2, 3]\n'
    scene(folder, low, "low")
    read = toml.read(scene(folder, 'name = "high"\nbase = "low.toml"\n[initial_state.root_position]\n1 = 5\n'))
    assert read.initial_state.root_position == (1.0, 5.0, 3.0)


@pytest.mark.parametrize(
    ("text", "file", "line", "key"),
    [
        ("[muscles.flexor]\nf_max = -1\n", "wrong.toml", 2, "character.muscles.flexor.f_max"),
        ("[muscles.flexor]\nforce = 1\n", "wrong.toml", 2, "character.muscles.flexor.force"),
        ("[bodies.leg]\nmass = 0\n", "wrong.toml", 2, "character.bodies.leg.mass"),
        ("[muscles.extensor]\nf_max = 1\nl_opt = 1\nl_slack = 1\n", "wrong.toml", 1, "character.muscles.extensor"),
    ],
)
def test_errors_are_placed_in_the_part_that_has_the_key(folder, text, file, line, key):
    scene(folder, text, "wrong")
    with pytest.raises(SceneError) as caught:
        toml.read(scene(folder, 'name = "s"\ncharacter = ["leg.toml", "muscle.toml", "wrong.toml"]\n'))
    assert (caught.value.file.name, caught.value.line) == (file, line)
    assert caught.value.key.startswith(key)


def test_errors_in_what_a_base_says_are_placed_there(folder):
    scene(folder, 'name = "low"\ncharacter = "leg.toml"\n\nduration = -1\n', "low")
    with pytest.raises(SceneError) as caught:
        toml.read(scene(folder, 'name = "high"\nbase = "low.toml"\n'))
    assert (caught.value.file.name, caught.value.line) == ("low.toml", 4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('name = "s"\nbase = "scene.toml"\n', "based on each other"),
        ('name = "s"\nbase = "nowhere.toml"\n', "No such file|no such file"),
        ('name = "s"\nbase = 3\n', "path of another scene"),
        ('name = "s"\ncharacter = ["leg.toml", "nowhere.toml"]\n', "No such file|no such file"),
        ('name = "s"\ncharacter = ["leg.toml", 3]\n', "character"),
    ],
)
def test_impossible_layers_are_errors(folder, text, message):
    with pytest.raises(SceneError, match=message):
        toml.read(scene(folder, text))


@pytest.mark.parametrize("key", ["base", "character"])
def test_a_name_that_no_file_can_have_is_refused(key: str):
    with pytest.raises(SceneError, match="no file can be called"):
        toml.loads(f'name = "a"\n{key} = "x\\u0000y"\n')
