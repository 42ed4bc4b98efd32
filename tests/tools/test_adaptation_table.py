"""The table of how a policy adapts to weakness: what the weak bodies are, and how walks stand beside studies."""

import sys
from pathlib import Path

import pytest

from warpmuscle.formats import load
from warpmuscle.scene.impairments.impaired import impaired

TOOLS = Path(__file__).parents[2] / "tools" / "research"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from adaptation_table import CASES, LEFT, PUBLISHED, RIGHT, Expected, agreeing, settings, table, verdicts  # noqa: E402

from warpmuscle.cli.common import load_scene  # noqa: E402

HEALTHY = {"speed": 1.25, "mean activation": 0.15, "stance" + LEFT: 61.0, "stance" + RIGHT: 61.5}


@pytest.mark.parametrize("case", CASES)
def test_muscles_of_one_side_have_half_their_strength(case: str):
    weak = load_scene(["gait2392_walk"], settings=settings(case)[1:])
    plain = load("gait2392_walk").character.muscles
    found = impaired(weak).character.muscles
    for name, muscle in found.items():
        assert muscle.f_max == pytest.approx(plain[name].f_max * (0.5 if name in CASES[case] else 1.0)), name
    assert settings(case)[0] == "learning.symmetric = false"


def test_both_sides_stand_in_one_cell_and_a_fall_is_told():
    lines = table({"healthy": HEALTHY, "calf": {"upright": 3.0}}).splitlines()
    assert lines[0] == "| measure | healthy | calf |"
    assert "| speed, m/s | 1.25 | falls |" in lines
    assert "| stance | 61, 61.5 |  |" in lines


def test_changes_are_as_published_or_otherwise():
    for change, within, amount, agrees in (
        ("rises", 0.0, 0.1, True), ("rises", 0.0, -0.1, False), ("falls", 0.0, -0.1, True), ("rises", 0.2, 0.1, False),
        ("stays", 2.0, -1.9, True), ("stays", 2.0, 2.1, False),
    ):  # fmt: skip
        assert agreeing(Expected("calf", "x", change, within, "someone"), amount) == agrees


def test_what_studies_found_is_of_the_weak_bodies_and_has_a_source():
    assert {one.case for one in PUBLISHED} == set(CASES) - {"healthy"}
    assert all(one.source for one in PUBLISHED)
    lines = verdicts({"healthy": HEALTHY, "calf": {"mean activation": 0.16}}).splitlines()
    (told,) = (line for line in lines if line.startswith("| calf | mean activation |"))
    assert "| 0.15 to 0.16 | as published |" in told
    assert sum("not measured" in line for line in lines) == len(PUBLISHED) - 1
