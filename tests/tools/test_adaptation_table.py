"""The table of how a policy adapts to weakness: what the weak bodies are, and how walks stand beside studies."""

import sys
from argparse import Namespace
from pathlib import Path

import pytest

from warpmuscle.formats import load
from warpmuscle.scene.impairments.impaired import impaired

TOOLS = Path(__file__).parents[2] / "tools" / "research"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

from adaptation_table import (  # noqa: E402
    CASES,
    LEFT,
    PUBLISHED,
    RIGHT,
    WANTED,
    Expected,
    Wanted,
    agreeing,
    learned,
    recovered,
    recoveries,
    settings,
    table,
    verdicts,
)

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


def test_learning_goes_on_with_what_is_given_where_there_is_no_file_yet(tmp_path: Path, monkeypatch):
    given = Namespace(folder=tmp_path, until="120s", seed=1, set=["learning.rewards.speed=50"], device=None)
    given.option = ["discount=0.995", "clip=0.2"]
    asked: list[list[str]] = []
    monkeypatch.setattr("subprocess.run", lambda command, check: asked.append(command))
    assert learned(Path("p.h5"), "p.toml", "calf", given) == tmp_path / "calf.h5"
    (words,) = asked
    assert [words[k + 1] for k, word in enumerate(words) if word == "--set"] == [*settings("calf"), *given.set]
    assert [words[k + 1] for k, word in enumerate(words) if word == "--option"] == given.option
    assert words[words.index("--from") + 1] == "p.h5"
    (tmp_path / "calf.h5").touch()
    learned(Path("p.h5"), "p.toml", "calf", given)
    assert len(asked) == 1


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


@pytest.mark.parametrize(
    ("before", "after", "found"),
    [
        (1.0, 1.2, ("100", "recovered")), (1.0, 1.1, ("50", "recovered")), (1.0, 1.05, ("25", "not recovered")),
        (1.0, 0.9, ("-50", "not recovered")), (1.4, 1.25, ("75", "recovered")),
        (1.15, 1.2, ("", "weakness changed too little")),
    ],
)  # fmt: skip
def test_half_of_what_weakness_changed_has_to_come_back(before, after, found):
    assert recovered(Wanted("speed", False, 0.1), 1.2, before, after) == found


def test_sides_that_come_to_differ_the_other_way_have_not_recovered():
    step = Wanted("step length", True, 0.01)
    assert recovered(step, 0.0, -0.04, 0.08) == ("-100", "not recovered")
    assert recovered(step, 0.0, -0.04, 0.01) == ("75", "recovered")


def test_what_comes_back_is_told_of_each_weak_body_and_can_fail():
    sided = {"gait profile score": (4.0, 4.0), "step length": (0.6, 0.6)}
    weak = {"speed": 1.0, "gait profile score": (7.0, 5.0), "step length": (0.62, 0.58)}
    adapted = {"speed": 1.2, "gait profile score": (6.0, 4.5), "step length": (0.6, 0.6)}

    def walk(values):
        found = {}
        for name, value in values.items():
            found |= {name + LEFT: value[0], name + RIGHT: value[1]} if isinstance(value, tuple) else {name: value}
        return found

    walks = {"healthy": walk({"speed": 1.25} | sided), "calf, not adapted": walk(weak), "calf": walk(adapted)}
    lines = recoveries(walks).splitlines()
    assert len(lines) == 2 + 2 * len(WANTED)
    assert "| calf | speed | 1.25 | 1 | 1.2 | 80 | recovered |" in lines
    assert "| calf | gait profile score, left less right | 0 | 2 | 1.5 | 25 | not recovered |" in lines
    assert "| calf | step length, left less right | 0 | 0.04 | 0 | 100 | recovered |" in lines
    assert "| glut_med | speed | 1.25 | falls | falls |  | not measured |" in lines
    walks |= {"glut_med, not adapted": {"upright": 3.0}, "glut_med": walk(adapted)}
    assert "| glut_med | speed | 1.25 | falls | 1.2 |  | walks again |" in recoveries(walks).splitlines()
    walks["glut_med"] = {"upright": 4.0}
    assert "| glut_med | speed | 1.25 | falls | falls |  | not measured |" in recoveries(walks).splitlines()
