"""The tables of judged gaits in the manual: every row that a judgement has today, and every gait that they name."""

import re
import shlex
from pathlib import Path

from warpmuscle.studies.verdicts import OF_MUSCLES, RUN, WALK, Bar

PAGE = (Path(__file__).parents[2] / "docs" / "explanation" / "gaits.md").read_text("utf-8")
HEAD = "| measure | unit | must | goal |"


def tables() -> list[list[list[str]]]:
    """Cells of each table of judged gaits, without the line below its head."""
    found = re.findall(rf"^{re.escape(HEAD)}.*\n(?:\|.*\n)+", PAGE, re.MULTILINE)
    return [
        [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if "---" not in line]
        for text in found
    ]


def ends(bar: tuple[float | None, float | None]) -> str:
    low, high = bar
    return f"up to {high:g}" if low is None else f"{low:g} or more" if high is None else f"{low:g} to {high:g}"


def rows(bars: tuple[Bar, ...]) -> list[list[str]]:
    return [[bar.name, bar.unit, ends(bar.must), ends(bar.goal)] for bar in bars]


def test_tables_have_the_rows_that_a_judgement_has():
    of_torques = tuple(bar for bar in WALK if bar.name not in OF_MUSCLES)
    known = [rows(WALK), rows(of_torques), rows(RUN)]
    found = [[row[:4] for row in table[1:-1]] for table in tables()]
    assert found
    assert all(one in known for one in found)
    assert all(one in found for one in known)
    assert {table[-1][0] for table in tables()} == {"fells it"}


def test_every_gait_that_the_command_judges_has_a_column():
    command = re.search(r"^python tools/judge_table\.py ((?:.*\\\n)*.*)$", PAGE, re.MULTILINE)
    assert command is not None
    words = shlex.split(command[1].replace("\\\n", " "))
    asked = [Path(word).stem for word in words[: next(k for k, word in enumerate(words) if word.startswith("-"))]]
    columns = [cell.strip("`") for table in tables() for cell in table[0][4:]]
    assert len(asked) == 28
    assert sorted(columns) == sorted(asked)
