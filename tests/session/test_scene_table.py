"""The shipped scenes as a table."""

import pytest

import warpmuscle as wm
from warpmuscle.core.errors import ArgumentError


@pytest.fixture(scope="module")
def table():
    return wm.scenes()  # loads them all


def test_the_table_has_each_shipped_scene_with_its_description(table):
    assert "walk56" in table
    assert table.names == tuple(sorted(table.names))
    row = next(row for row in table if row.name == "walk56")
    assert row.muscles == 56
    assert row.description == wm.load("walk56").description
    assert row.description in repr(table)


def test_a_part_of_the_table_is_a_table_that_notebooks_show(table):
    part = table[:2]
    assert len(part) == 2
    assert part._repr_html_().count("<tr>") == 3
    assert part[0] in part


def test_a_scene_is_found_by_its_name_and_scenes_by_words(table):
    assert table["walk56"].muscles == 56
    with pytest.raises(ArgumentError, match="no scene is called 'wlak56'; did you mean 'walk56'"):
        table["wlak56"]
    found = wm.scenes("walk STAIRS")
    assert "bwalk_stairs" in found
    assert len(found) < len(table)
    assert all("stairs" in f"{row.name} {row.description}".lower() for row in found)
    assert len(wm.scenes("nothing of this kind")) == 0
