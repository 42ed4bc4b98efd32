"""What a sweep file says of its study is understood, or refused with its place."""

from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.sweep.plan import Plan, read
from warpmuscle.sweep.study.table import label

HEAD = """
scene = "fwalk"
[search]
candidates = 4
[grid]
seed = [1, 2]
strength = { keys = ["character.bodies.torso.mass"], factors = [1, 0.5] }
"""


def planned(folder: Path, text: str) -> Plan:
    file = folder / "study.toml"
    file.write_text(text)
    return read(file)


def test_the_only_axis_is_the_condition_and_its_first_value_the_reference(tmp_path: Path):
    study = planned(tmp_path, HEAD + "[study]\n").study
    assert study is not None
    assert (study.title, study.condition, study.reference, study.usual) == ("study", "strength", 1.0, True)
    assert planned(tmp_path, HEAD).study is None


def test_one_of_several_axes_is_the_condition_and_the_others_make_series(tmp_path: Path):
    text = HEAD + '"objective.torque" = [1, 2]\n[study]\ncondition = "torque"\nreference = 2\n'
    plan = planned(tmp_path, text)
    study = plan.study
    assert (
        planned(tmp_path, text.replace('"torque"\n', '"objective.torque"\n')).study == study
    )  # by the key of its axis
    assert study is not None
    assert study.reference == 2.0
    assert {study.condition_of(run.axes) for run in plan.runs} == {1.0, 2.0}
    assert {study.series_of(run.axes) for run in plan.runs} == {"normal", "strength 0.5"}


def test_without_a_condition_all_axes_are_it(tmp_path: Path):
    plan = planned(tmp_path, HEAD + '"objective.torque" = [2, 3]\n[study]\nreference = "torque 2"\n')
    study = plan.study
    assert study is not None
    found = {study.condition_of(run.axes) for run in plan.runs}
    assert found == {"torque 2", "torque 3", "strength 0.5, torque 2", "strength 0.5, torque 3"}
    assert {study.series_of(run.axes) for run in plan.runs} == {""}
    assert label({"run": "brace", "seed": 3.0}) == "brace"


def test_seeds_and_options_may_be_others_than_those_of_the_file(tmp_path: Path):
    file = tmp_path / "study.toml"
    file.write_text(HEAD)
    plan = read(file, seeds=3, options={"candidates": 20, "population": 5})
    assert sorted({run.seed for run in plan.runs}) == [1, 2, 3]
    assert {(run.options.candidates, run.options.population) for run in plan.runs} == {(20, 5)}
    file.write_text(HEAD.replace("seed = [1, 2]", ""))
    assert sorted({run.seed for run in read(file, seeds=2).runs}) == [1, 2]
    with pytest.raises(SceneError, match="the population must be at least"):
        read(file, options={"population": 1})


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('[study]\ncondition = "strenght"\n', "no axis 'strenght'; did you mean 'strength'"),
        ("[study]\nreference = 0.7\n", "no run has the condition 0.7; they are: 1, 0.5"),
        ('[study]\n[[study.expected]]\nmeasure = "speed"\n', "says neither a change"),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "sinks"\n',
            "'sinks' is none of 'falls', 'rises'",
        ),
        ('[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "falls"\nat = 3\n', "no run has the condition 3"),
        ('[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "falls"\nwithin = 3\n', 'what "stays"'),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "stays"\nwithin = nan\n',
            "within: is greater than 0",
        ),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nvalue = inf\n',
            "study.expected.0.value: is a finite number, not inf",
        ),
        ('[study]\nmeasures = ["cost", "step lenght"]\n', "'step lenght'; did you mean 'step length'"),
        ('[study]\nmeasures = ["elbow*"]\n', "no walk has a measure 'elbow[*]'; `warpmuscle gait`"),
        ('[study]\n[[study.expected]]\nmeasure = "sped"\nchange = "falls"\n', "'sped'; did you mean 'speed'"),
        ("[study]\nmeasure = []\n", "measure"),
        ("[study]\nmeasures = []\n", "study.measures: there is none in it"),
        ('[study]\ncondition = ""\n', "no axis ''"),
        ('[study]\n[[study.expected]]\nmeasure = "hip*"\nchange = "falls"\n', "measure: is the name of one measure"),
        ('[study]\n[[study.expected]]\nmeasure = "speed"\nchange = ""\n', "'' is none of 'falls'"),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "falls"\nvalue = 0.2\n',
            "study.expected.0.value: is a change, below 0 where it falls, not 0.2",
        ),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "rises"\nvalue = 0\n',
            "study.expected.0.value: is a change, above 0 where it rises, not 0",
        ),
        (
            '[study]\n[[study.expected]]\nmeasure = "speed"\nchange = "falls"\nat = 1\n',
            "study.expected.0.at: is the reference itself",
        ),
        (
            "[study]\n" + '[[study.expected]]\nmeasure = "speed"\nchange = "falls"\n' * 2,
            "study.expected.1: is there twice",
        ),
        ("study = 3\n", "study"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(tmp_path: Path, table: str, words: str):
    with pytest.raises(SceneError, match=words) as caught:
        planned(tmp_path, (table + HEAD) if table.startswith("study =") else HEAD + table)
    assert "study.toml" in str(caught.value)


def test_trainings_are_no_study(tmp_path: Path):
    text = HEAD.replace("[search]\ncandidates = 4", "[training]\niterations = 2").replace('"fwalk"', '"reflex_planar"')
    text = text[: text.index("strength")]
    assert planned(tmp_path, text).trains
    with pytest.raises(SceneError, match="trainings have none"):
        planned(tmp_path, text + "[study]\n")


def test_measures_that_some_walk_has_are_asked_for(tmp_path: Path):
    names = ["cost", "metabolic power in all", "hip*", "timing of soleus", "work of brace", "*", "objective.speed"]
    study = planned(tmp_path, HEAD + f"[study]\nmeasures = {names}\n").study
    assert study is not None
    assert list(study.measures) == names


def test_a_wrong_measure_is_named_with_its_line(tmp_path: Path):
    with pytest.raises(SceneError, match=r"study\.toml:9: .*sped"):
        planned(tmp_path, HEAD + '[[study.expected]]\nmeasure = "sped"\nchange = "falls"\nat = 0.5\n')
