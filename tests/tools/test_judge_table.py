"""The tool that judges gaits into one table: what it prints of them, and what it does not judge again."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from judge_table import judged, table  # noqa: E402


def verdict(name: str, value: float | None, reached: str, note: str = "") -> dict[str, object]:
    bar = {"name": name, "unit": "m", "must": [None, 1.0], "goal": [0.1, None]}
    return bar | {"value": value, "reached": reached, "note": note}


def gait(*verdicts: dict[str, object], **felled_by: int) -> dict[str, object]:
    end = "reached the end of the simulated time"
    return {"verdicts": list(verdicts), "felled_by": felled_by, "commanded": [], "end": end, "impossible": False}


WALK = gait(verdict("step width", 0.123456, "goal"), verdict("angles", 2.0, "missed"))
FAST = gait(verdict("step width", 3.0, "does not count"), verdict("angles", 2.0, "no judge", "at 1.8 m/s"))
RUN = gait(verdict("flight", None, "missed"), uphill=20, noise=0) | {"end": "fell: the centre of mass sank"}


def test_gaits_of_the_same_bars_stand_in_one_table_and_runs_in_another():
    assert table({"walk": WALK, "files/fast.h5": FAST, "run": RUN}).splitlines() == [
        "| measure | unit | must | goal | `walk` | `fast` |",
        "| --- | --- | --- | --- | --- | --- |",
        "| step width | m | up to 1 | 0.1 or more | 0.123 | 3 (void) |",
        "| angles | m | up to 1 | 0.1 or more | 2 (missed) | 2 (no judge) |",
        "| fells it | of 20 |  |  | none of these | none of these |",
        "",
        "| measure | unit | must | goal | `run` |",
        "| --- | --- | --- | --- | --- |",
        "| flight | m | up to 1 | 0.1 or more | falls (missed) |",
        "| fells it | of 20 |  |  | undisturbed it fell, uphill 20 |",
    ]


def test_what_is_asked_besides_stands_in_a_table_of_its_own():
    further = [verdict("all at once", 14.0, "missed"), verdict("mean activation", 0.05, "no judge")]
    further[1] |= {"must": [None, None], "goal": [None, None]}
    lines = table({"walk": WALK | {"further": further}, "run": RUN}).splitlines()
    assert lines[-4:] == [
        "| besides | unit | must | goal | `walk` |",
        "| --- | --- | --- | --- | --- |",
        "| all at once | m | up to 1 | 0.1 or more | 14 (missed) |",
        "| mean activation | m |  |  | 0.05 (no judge) |",
    ]


def test_what_a_gait_is_like_at_each_command_has_a_table_of_its_own():
    command = {"command": {"speed": 0.8834}, "measures": {"speed": 0.9, "double support": None}, "why": ""}
    lines = table({"walk": WALK | {"commanded": [command]}}).splitlines()
    assert lines[6] == "`walk`, as commanded:"
    assert lines[-1] == "| speed 0.883 | 0.9 | - | - | - | - | - |"
    assert "as commanded" not in table({"walk": WALK | {"commanded": [command], "impossible": True}})


def test_what_is_judged_already_is_read_and_not_run_again(tmp_path: Path):
    (tmp_path / "no_such_gait.json").write_text(json.dumps(RUN))
    assert judged("no_such_gait", tmp_path, []) == RUN


def test_a_gait_that_cannot_be_judged_has_no_numbers_and_says_why(tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    assert judged("no_such_gait", tmp_path, []) is None
    assert [file.name for file in tmp_path.iterdir()] == ["no_such_gait.txt"]
    assert "there is no scene called 'no_such_gait'" in capfd.readouterr().err


def test_gaits_judged_at_the_same_time_stand_in_the_order_asked_for(tmp_path: Path):
    (tmp_path / "table.judged").mkdir()
    for name, numbers in (("run", RUN), ("walk", WALK), ("fast", FAST)):
        (tmp_path / "table.judged" / f"{name}.json").write_text(json.dumps(numbers))
    command = [sys.executable, TOOLS / "judge_table.py", "walk", "missing.toml", "run", "fast", "-j", "4", "-o"]
    ended = subprocess.run([*command, tmp_path / "table.md"], capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert ended.stderr.endswith("could not be judged: missing.toml; the errors are above\n")
    assert (tmp_path / "table.md").read_text() == table({"walk": WALK, "run": RUN, "fast": FAST})
