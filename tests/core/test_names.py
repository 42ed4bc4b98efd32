"""Names become names of files that stay in their folder, on any system."""

import pytest

from warpmuscle.core.names import file_name, is_file_name

HOSTILE = [
    "../x", "..", ".", "/etc/passwd", "a/../../b", "..\\..\\x", "C:\\x", "a\0b", "", "   ", "...", "con", "NUL.txt",
    "com1", "-" * 300, "ü" * 300, "a\nb", "\x1b[2J", "a:b|c", "~/x", "\ud800",
]  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_any_name_becomes_one_within_its_folder(name, tmp_path):
    made = file_name(name)
    assert not set(made) & set('/\\\0:|\n\x1b*?"<>')
    assert made.strip(". ") == made != ""
    path = tmp_path / f"{made}.h5.journal"
    path.write_text("")
    assert [found.name for found in tmp_path.iterdir()] == [path.name]
    assert path.resolve().parent == tmp_path.resolve()
    assert is_file_name(made)
    assert made.split(".")[0].lower() not in ("con", "nul", "com1")


@pytest.mark.parametrize("name", ["walk56", "normal,seed=2,target_speed=0.8,weakness=0.25", "größe 2", "a.b~3"])
def test_usual_names_stay_as_they_are(name):
    assert file_name(name) == name
    assert is_file_name(name)


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "", ".", "con"])
def test_names_that_would_be_others_are_told(name):
    assert not is_file_name(name)
