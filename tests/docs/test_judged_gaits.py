"""The tables of judged gaits in the manual: every row that a judgement has today, and every gait that they name."""

import re
import shlex
from pathlib import Path

import pytest

from warpmuscle.core.shipped import description, scene_groups, shipped_scenes
from warpmuscle.gait.quality import INSIDE
from warpmuscle.studies.verdicts import FURTHER_RUN, FURTHER_WALK, OF_MUSCLES, RUN, WALK, Bar, ends

ROOT = Path(__file__).parents[2]
PAGES = [(ROOT / "docs" / "explanation" / name).read_text("utf-8") for name in ("gaits.md", "gait-tables.md")]
PAGE = "\n".join(PAGES)
GALLERY = (ROOT / "docs" / "gallery.md").read_text("utf-8")
SAMPLES = ROOT / "warpmuscle" / "examples" / "files"  # scenes of policies
HEAD, BESIDES = "| measure | unit | must | goal |", "| besides | unit | must | goal |"


def tables(head: str = HEAD) -> list[list[list[str]]]:
    """Cells of each table of judged gaits, without the line below its head."""
    found = re.findall(rf"^{re.escape(head)}.*\n(?:\|.*\n)+", PAGE, re.MULTILINE)
    return [
        [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if "---" not in line]
        for text in found
    ]


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


def test_tables_of_what_is_asked_besides_have_its_rows():
    known = [rows(tuple(bar for bar in bars if muscles or bar.name not in OF_MUSCLES))
             for bars in (FURTHER_WALK, FURTHER_RUN) for muscles in (True, False)]  # fmt: skip
    found = tables(BESIDES)
    assert found
    assert all([row[:4] for row in table[1:]] in known for table in found)


def judged() -> list[str]:
    """Gaits that the commands of both pages judge."""
    commands = re.findall(r"^python tools/judge_table\.py ((?:.*\\\n)*.*)$", PAGE, re.MULTILINE)
    assert len(commands) == len(PAGES)
    words = [shlex.split(command.replace("\\\n", " ")) for command in commands]
    return [
        Path(one).stem for some in words for one in some[: next(k for k, w in enumerate(some) if w.startswith("-"))]
    ]


def test_every_gait_that_the_commands_judge_has_a_column():
    columns = [cell.strip("`") for table in tables() for cell in table[0][4:]]
    assert sorted(columns) == sorted(judged())


def test_every_shipped_gait_and_policy_is_judged():
    """All but models, arms, bodies that stand, squat or rise, and walks whose arms are what they are about."""
    groups = scene_groups()
    others = {
        "gait2392",
        "gait2392_stand",
        "gait2392_squat",
        "gait2392_rise",
        "arm18",
        "arm18_reach",
        *groups.pop("throws"),
    }
    others |= {
        "elbow_open_loop",
        "elbow_simplified",
        "moment_arm_angle",
        "muscle_groups",
        "wrist_biarticular",
    }
    gaits = {name for names in groups.values() for name in names}
    policies = {path.stem for path in SAMPLES.glob("*.h5")}
    assert sorted(judged()) == sorted(policies | gaits - others)


def judged_as(measure: str) -> dict[str, str]:
    """The first word of the cell of each judged gait in the row of a measure."""
    found = {}
    for table in tables():
        row = next(row for row in table if row[0] == measure)
        found |= {gait.strip("`"): cell.split()[0] for gait, cell in zip(table[0][4:], row[4:], strict=True)}
    return found


DEEP = {gait: float(depth) for gait, depth in judged_as(INSIDE).items() if float(depth) > 1.0}  # cm
FALLING = {gait: int(runs) for gait, runs in judged_as("upright, disturbed").items() if int(runs) < 19}


def test_the_page_tells_of_every_gait_that_falls_why_it_is_here():
    told = PAGES[0].partition("| why it is here | gaits |")[2].partition("\n\n")[0]
    assert {gait: int(runs) for gait, runs in re.findall(r"`(\w+)` (\d+)\b", told)} == FALLING
    assert len(re.findall(r"`\w+` \d+\b", told)) == len(FALLING)


@pytest.mark.parametrize(("gait", "depth"), DEEP.items())
def test_a_gait_whose_bodies_are_inside_each_other_says_so_in_its_description(gait: str, depth: float):
    scenes = shipped_scenes()
    said = description(scenes[gait] if gait in scenes else SAMPLES / f"{gait}.toml", scenes)
    told = re.search(r"\bpass\b[^.;]*? (\d+(?:\.\d)?) cm", said)
    assert told, said
    assert float(told[1]) == pytest.approx(depth, abs=0.5)
    if gait in scenes:
        assert said in GALLERY


@pytest.mark.parametrize(("gait", "runs"), FALLING.items())
def test_a_gait_that_falls_in_more_than_one_of_20_disturbed_runs_says_so_in_its_description(gait: str, runs: int):
    scenes = shipped_scenes()
    said = description(scenes[gait] if gait in scenes else SAMPLES / f"{gait}.toml", scenes)
    assert f"stays up in {runs} of 20 disturbed runs" in said or re.search(r"\bfalls\b", said), said
    assert gait not in scenes or said in GALLERY
