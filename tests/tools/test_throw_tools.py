"""Tables of throws: what their lines say."""

import runpy
from pathlib import Path

TOOLS = Path(__file__).parents[2] / "tools"


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
