"""The tool that measures rows of judged gaits anew: which cells of a page it replaces, and which it leaves."""

import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import judged_rows  # noqa: E402
from judged_rows import main, parsed, renewed, source_of, tables, written  # noqa: E402

PAGE = """Some text.

| measure | unit | must | goal | `walk` | `fast` |
| --- | --- | --- | --- | --- | --- |
| maximum braking force | body weights | 0.1 to 0.3 |  | 0.4 (missed) | 0.2 |
| stance | % of the cycle | 59 to 65 | 61 to 63 | 60 | 50 (missed) |
| fells it | of 20 |  |  | none of these | noise 3 |

| besides | unit | must | goal | `walk` | `fast` |
| --- | --- | --- | --- | --- | --- |
| windows in which muscles are active | share | 0.75 or more | 0.9 or more | 0.8 | 0.9 |
| commands met | of 20 | 19 or more | 20 or more | 20 | 3 (missed) |

| other | table |
| --- | --- |
"""
CELLS = {
    "`walk`": {"maximum braking force": "0.13", "clearance in mid-swing": "0.5 (no judge)"},
    "`fast`": {"clearance in mid-swing": "-"},
}


def test_tables_of_judged_gaits_are_found_and_written_as_they_were():
    found = tables(PAGE)
    assert [table[0][0] for table in found] == ["measure", "besides"]
    for table in found:
        assert written(table) in PAGE
        assert parsed(written(table)) == table


def test_cells_that_were_measured_are_replaced_and_limits_are_those_of_today():
    table = renewed(tables(PAGE)[0], ["maximum braking force", "clearance in mid-swing"], CELLS)
    assert table[2] == ["maximum braking force", "body weights", "0.1 to 0.26", "0.14 to 0.22", "0.13", "0.2"]
    assert [line[0] for line in table[2:]] == ["maximum braking force", "stance", "fells it"]
    assert table[3] == tables(PAGE)[0][3]


def test_a_row_that_a_table_lacks_gets_its_place():
    table = renewed(tables(PAGE)[1], ["clearance in mid-swing"], CELLS)
    assert [line[0] for line in table[2:]] == [
        "windows in which muscles are active",
        "clearance in mid-swing",
        "commands met",
    ]
    assert table[3] == ["clearance in mid-swing", "cm", "", "", "0.5 (no judge)", "-"]


def test_a_gait_is_a_policy_or_a_scene_of_the_folder_or_a_shipped_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert source_of("walk56") == "walk56"
    assert source_of("mine") is None
    Path("mine.toml").touch()
    assert source_of("mine") == "mine.toml"
    Path("mine.h5").touch()
    assert source_of("mine") == "mine.h5"


def test_all_gaits_have_to_be_there_before_any_is_measured(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("page.md").write_text(PAGE)
    monkeypatch.setattr(sys, "argv", ["judged_rows.py", "page.md", "--rows", "stance"])
    with pytest.raises(SystemExit):
        main()
    assert "nor a file here: walk, fast; run `warpmuscle example` first" in capsys.readouterr().err


def test_what_is_measured_is_on_the_page_at_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("walk.h5", "fast.h5"):
        Path(name).touch()
    Path("page.md").write_text(PAGE)

    def measured(source, *_):
        if source == "fast.h5":
            raise KeyboardInterrupt
        return {"maximum braking force": "0.13"}

    monkeypatch.setattr(judged_rows, "measured", measured)
    monkeypatch.setattr(sys, "argv", ["judged_rows.py", "page.md", "--rows", "maximum braking force"])
    with pytest.raises(KeyboardInterrupt):
        main()
    assert Path("page.md").read_text() == PAGE.replace("0.1 to 0.3 |  |", "0.1 to 0.26 | 0.14 to 0.22 |").replace(
        "0.4 (missed)", "0.13"
    )
