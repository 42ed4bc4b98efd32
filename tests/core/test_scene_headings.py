"""What scenes say before their first table is what a whole scene has."""

from pathlib import Path

import pytest

from warpmuscle.core.shipped import description, heading, is_scene, shipped_scenes
from warpmuscle.formats import toml


def test_shipped_scenes_are_described_as_when_they_are_loaded():
    found = shipped_scenes()
    assert len(found) > 40
    assert list(found) == sorted(found)
    for name in ("fwalk", "walk56", "iwalk", "walk44_but_hips", "gait2392_walk"):
        assert description(found[name], found) == toml.read(found[name]).description != ""


def test_no_scene_lacks_a_description():
    found = shipped_scenes()
    assert [name for name, path in found.items() if not description(path, found)] == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('name = "a"\n[character]\nname = "b"\n', {"name": "a"}),
        ('x = [\n  [1, 2],\n[3],\n]\nname = "a"\n  [t]\n', {"x": [[1, 2], [3]], "name": "a"}),
        ('text = """\n[no table]\n"""\nname = "a"\n[[t]]\n', {"text": "[no table]\n", "name": "a"}),
        ('\ufeffname = "a"', {"name": "a"}),
        ("[muscles.a]\nname = 1\n", {}),
        ("name = \n[t]\n", {}),
    ],
)
def test_a_heading_ends_where_the_first_table_begins(text: str, expected: dict, tmp_path: Path):
    path = tmp_path / "a.toml"
    path.write_text(text, encoding="utf-8")
    assert heading(path) == expected
    assert is_scene(path) == ("name" in expected)


def test_what_changes_in_a_file_is_read_anew_and_bases_in_a_circle_end(tmp_path: Path):
    first, second = tmp_path / "a.toml", tmp_path / "b.toml"
    first.write_text('name = "a"\nbase = "b"\n')
    second.write_text('name = "b"\ndescription = "old"\n')
    assert description(first, {"b": second}) == "old"
    second.write_text('name = "b"\ndescription = "new"\n')
    assert description(first, {"b": second}) == "new"
    second.write_text('name = "b"\nbase = "a.toml"\n')
    assert description(first, {"b": second}) == ""
    assert heading(tmp_path / "none.toml") == {}
