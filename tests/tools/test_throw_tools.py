"""Tables of throws: what their lines say."""

import json
import runpy
from pathlib import Path

TOOLS = Path(__file__).parents[2] / "tools" / "research"


def test_a_table_counts_throws_and_names_those_that_miss_a_bar():
    table = runpy.run_path(str(TOOLS / "throw_table.py"))
    row = {
        "number": 5, "kind": "together", "names": ["one", "two"], "held_out": [1], "good": [True, False],
        "r2": [[0.9999, 0.9995], [0.99, 0.9999]], "velocity_r2": [[0.99, 0.99], [0.96, 0.99]],
        "hand_error": [0.01, 0.03], "correlation": [0.95, 0.97], "explained": 0.9, "share": [0.4, 0.5], "cpu": 3.0,
    }  # fmt: skip
    assert "all bars  1 of  2, held out  0 of  1" in table["line"]([row])
    (text,) = table["missed"](row)
    assert "two: r2 0.9900, velocity 0.960, hand 3.0 cm, correlation 0.970" in text


def test_a_table_that_was_ended_does_not_fit_again_what_its_file_has(tmp_path: Path):
    table = runpy.run_path(str(TOOLS / "throw_table.py"))
    task, kept = table["Task"], table["kept"]
    files = (tmp_path / "throw_1.csv", tmp_path / "throw_2.csv")
    row = {"scene": "throw18", "names": ["throw_1", "throw_2"], "asked": 5}
    (tmp_path / "rows.json").write_text(json.dumps(row) + "\n")
    (found,) = kept(tmp_path / "rows.json")
    assert task("throw18", files, 5).gave(found)
    others = [task("throw18", files, 6), task("throw18", files, None), task("throw", files, 5)]
    assert not any(one.gave(found) for one in [*others, task("throw18", files[:1], 5)])
    assert kept(tmp_path / "none.json") == kept(None) == []
