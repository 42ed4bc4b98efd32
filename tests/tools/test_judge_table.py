"""The tool that judges gaits into one table: what it prints of them, and what it does not judge again."""

import json
import sys
from pathlib import Path

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from judge_table import judged, table  # noqa: E402


def verdict(name: str, value: float | None, reached: str) -> dict[str, object]:
    return {"name": name, "unit": "m", "value": value, "reached": reached, "note": ""}


WALK = {"verdicts": [verdict("step width", 0.123456, "goal"), verdict("angles", 2.0, "missed")], "felled_by": {}}
RUN = {"verdicts": [verdict("flight", None, "missed")], "felled_by": {"2 degrees up": 20, "noise": 0}}


def test_rows_of_walks_and_runs_stand_in_one_table():
    lines = table({"walk": WALK, "run": RUN}).splitlines()
    assert lines == [
        "| measure | unit | walk | run |",
        "| --- | --- | --- | --- |",
        "| step width | m | 0.123 |  |",
        "| angles | m | 2 * |  |",
        "| flight | m |  | falls |",
        "| fells it | of 20 | none of these | 2 degrees up: 20 |",
    ]


def test_what_is_judged_already_is_read_and_not_run_again(tmp_path: Path):
    (tmp_path / "no_such_gait.json").write_text(json.dumps(RUN))
    assert judged("no_such_gait", tmp_path, []) == RUN


def test_a_gait_that_cannot_be_judged_has_no_numbers(tmp_path: Path):
    assert judged("no_such_gait", tmp_path, []) is None
    assert not list(tmp_path.iterdir())
