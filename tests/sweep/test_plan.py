"""Sweep files: which runs they ask for, by which names, and what is wrong with them, with file, line and key."""

import warnings
from pathlib import Path

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.results.records import SearchOptions
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.sweep import plan as plan_module
from warpmuscle.sweep.plan import Plan, read


def plan(tmp_path: Path, text: str) -> Plan:
    path = tmp_path / "a.toml"
    path.write_text(text)
    return read(path)


def names(tmp_path: Path, text: str) -> list[str]:
    return [run.name for run in plan(tmp_path, text).runs]


def test_example_of_the_documentation_is_what_it_says(tmp_path):
    text = plan_module.__doc__.partition("Example:\n")[2].partition("\nWhat stands")[0]
    found = plan(tmp_path, "\n".join(line.removeprefix("    ") for line in text.splitlines()))
    assert len(found.runs) == 2 * 3 * 3 * 4
    run = {run.name: run for run in found.runs}["short shanks,seed=2,target_speed=1.2,weakness=0.25"]
    assert (run.seed, run.options.strategy, run.options.candidates) == (2, "cma", 3000)
    assert (run.scene.duration, run.scene.objective.target_speed) == (5.0, 1.2)
    normal = {run.name: run for run in found.runs}["normal,seed=2,target_speed=1.2,weakness=1"].scene.character
    assert run.scene.character.muscles["lSOL"].f_max == 0.25 * normal.muscles["lSOL"].f_max
    assert run.scene.character.bodies["lLowerleg"].mass == pytest.approx(0.9**3 * normal.bodies["lLowerleg"].mass)
    assert run.axes == {"run": "short shanks", "seed": 2.0, "target_speed": 1.2, "weakness": 0.25}


def test_file_without_axes_is_one_run(tmp_path):
    found = plan(tmp_path, 'scene = "fwalk"\nseed = 3\n[set]\nduration = 2.0\n')
    assert [(run.name, run.seed, run.options, run.scene.duration) for run in found.runs] == [
        ("run", 3, SearchOptions(), 2.0)
    ]
    assert found.name == "a"


def test_search_scene_and_seed_can_be_axes(tmp_path):
    text = 'name = "mine"\n[grid]\nscene = ["fwalk", "walk56"]\n"search.sigma" = [0.1, 0.2]\nseed = [1]\n'
    found = plan(tmp_path, text)
    assert [run.name for run in found.runs][:2] == ["scene=fwalk,sigma=0.1,seed=1", "scene=fwalk,sigma=0.2,seed=1"]
    assert {run.scene.name for run in found.runs} == {"fwalk", "walk56"}
    assert [run.options.sigma for run in found.runs] == [0.1, 0.2] * 2


def test_keys_without_quotes_mean_the_same(tmp_path):
    quoted = '[grid]\n"objective.speed" = [1, 2]\n[[run]]\n"scale.lFoot" = 1.1\n"search.sigma" = 0.1\n'
    bare = "[grid]\nobjective.speed = [1, 2]\n[[run]]\nscale.lFoot = 1.1\nsearch.sigma = 0.1\n"
    assert plan(tmp_path, 'scene = "fwalk"\n' + quoted).runs == plan(tmp_path, 'scene = "fwalk"\n' + bare).runs


def test_scene_is_found_beside_the_sweep_file(tmp_path, monkeypatch):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "mine.toml").write_text(
        f'name = "mine"\nbase = "{Path("warpmuscle/scenes/torques/fwalk.toml").resolve()}"\n'
    )
    (tmp_path / "b" / "sweep.toml").write_text('scene = "mine.toml"\n')
    monkeypatch.chdir(tmp_path)
    assert read("b/sweep.toml").runs[0].scene.name == "mine"


def test_names_are_unique_readable_and_fit_for_files(tmp_path):
    text = 'scene = "fwalk"\n[grid]\ndescription = ["a/b", "a:b", "a\\\\b", "{long}"]\n'.replace("{long}", "x" * 500)
    found = names(tmp_path, text)
    assert found[:3] == ["description=a_b", "description=a_b~2", "description=a_b~3"]
    assert len(found[3]) < 130
    values = 'scene = "fwalk"\n[grid]\n"initial_state.root_velocity" = [[0, 0, 0], [0, 0, 1]]\n'
    assert names(tmp_path, values) == ["root_velocity=#0", "root_velocity=#1"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('scene = "fwalk"\n[grid]\n"objective.sped" = [1, 2]\n', "a.toml:3: objective.sped: unknown key"),
        ('scene = "fwalk"\n[grid]\n"objective.speed" = [\n  1,\n  -2,\n]\n', "a.toml:5: objective.speed: must not be"),
        ('scene = "fwalk"\n[grid]\nobjective.speed = 1\n', "a.toml:3: grid.objective.speed: an axis is a list"),
        ('scene = "fwalk"\n[grid]\nx = { keys = ["gravity"] }\n', "a.toml:3: grid.x: an axis has keys, and either"),
        ('scene = "fwalk"\n[grid]\nx = { keys = ["gravity"], factor = [1] }\n', "did you mean 'factors'?"),
        ('scene = "fwalk"\n[grid]\nx = { keys = ["gravity"], factors = [] }\n', "factors, which are not empty"),
        ('scene = "fwalk"\n[grid]\nx = { keys = ["gravity"], factors = [2, 2] }\n', "has the factor 2 twice"),
        ('scene = "fwalk"\n[set]\nx = 1\n', "a.toml:3: x: unknown key: there is no 'x' in a scene"),
        ('scene = "fwalk"\n[[run]]\nname = "a"\n\n[[run]]\ngravit = 3\n', "a.toml:6: gravit: unknown key"),
        ('scene = "fwalk"\n[[run]]\nname = 3\n', "a.toml:3: run.0.name: the name of a run is text"),
        ('scene = "fwalk"\n[[run]]\ngravity = 3\n[grid]\ngravity = [9]\n', "a.toml:5: gravity: is set twice"),
        ('scene = "fwalk"\n[grid]\nseed = [1.5]\n', "a.toml:3: seed: a seed is a whole number from 0"),
        ('scene = "fwalk"\n[search]\nstrategi = "cma"\n', "a.toml:3: search.strategi: unknown key; did you mean"),
        ('scene = "fwalk"\n[search]\nstrategy = "cmb"\n', "a.toml:3: search.strategy: there is no search strat"),
        ('scene = "fwalk"\n[search]\nstrategy = ""\n', "a.toml:3: search.strategy: there is no search strategy ''"),
        ('scene = "fwalk"\n[search]\nstrategy = 3\n', "a.toml:3: search.strategy: expected text, got a whole number"),
        ('scene = "fwalk"\n[grid]\n"search.strategy" = [""]\n', "a.toml:3: search.strategy: there is no search strat"),
        ('scene = "fwalk"\n[[run]]\nname = " "\n', "a.toml:3: run.0.name: the name of a run is text in one line"),
        ('scene = "fwalk"\n[[run]]\nname = "a\\nb"\n', "a.toml:3: run.0.name: the name of a run is text in one line"),
        ('scene = "fwalk"\n[[run]]\n[[run]]\nname = "a"\n', "run.0: a run has a name, or changes something"),
        (
            'scene = "fwalk"\n[[run]]\nname = "a"\n[[run]]\ngravity = 3\nname = "a"\n',
            "a.toml:6: run.1.name: 'a' is the name of another run",
        ),
        ('scene = "fwalk"\n[[run]]\ngravity = 3\n[[run]]\ngravity = 3\n', "run.1: 'gravity=3' is the name of anoth"),
        ('scene = "fwalk"\ngrid = []\n', "a.toml:2: grid: there is no axis in it"),
        ('scene = "fwalk"\nseed = -1\n[grid]\nseed = [1]\n', "a.toml:2: seed: a seed is a whole number from 0 to"),
        ('scene = "fwalk"\n[grid]\nseed = [-1]\n', "a.toml:3: seed: a seed is a whole number from 0"),
        (
            'scene = "fwalk"\n[set]\n"ground.normal" = [0, -1, 0]\n',
            "a.toml:3: ground.normal: must point upwards, out of",
        ),
        ('scene = "fwalk"\n[search]\ncandidates = 0\n', "a.toml:3: search.candidates: candidates must be a positive"),
        ('scene = "fwalk"\n[search]\npopulation = 8\nsigma = 9\n', "a.toml:4: search.sigma: sigma must be above 0"),
        ('scene = "fwalk"\n[grid]\nseed = {}\n', "a.toml:3: grid.seed: missing key 'keys'"),
        ('scene = "fwalk"\n[grid]\n"search.sigm" = [1]\n', "a.toml:3: search.sigm: unknown key; did you mean 'sigma'?"),
        ('scene = "fwalk"\n[grid]\n"search.sigma" = ["x"]\n', "a.toml:3: search.sigma: expected a number, got text"),
        ('scene = "fwolk"\n', "a.toml:1: scene: there is no scene called 'fwolk'; did you mean 'fwalk'?"),
        ('scene = "iwalk"\n', "no free parameters"),
        ("seed = 1\n", "name the scene"),
        ('scene = "fwalk"\nsed = 1\n', "a.toml:2: sed: unknown key; did you mean 'seed'?"),
        ('scene = "fwalk"\n[grid]\nx = [1, 2\n', "a.toml:3: not valid TOML"),
        ('scene = "mine.toml"\n', "mine.toml: there is no such file"),
    ],
)
def test_what_is_wrong_is_one_line_with_its_place(text, message, tmp_path):
    with pytest.raises(SceneError) as caught:
        plan(tmp_path, text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_file_is_an_error(tmp_path):
    with pytest.raises(SceneError, match="no such file"):
        read(tmp_path / "a.toml")


GRIDS = """scene = "walk56"
[[grid]]
calf = { keys = ["character.muscles.?SOL.f_max"], factors = [1, 0.5] }
[[grid]]
thigh = { keys = ["character.muscles.?VAS.f_max"], factors = [0.5] }
gravity = [9.8, 5]
"""


def test_grids_are_swept_by_themselves_and_with_every_run(tmp_path):
    found = plan(tmp_path, GRIDS)
    assert [run.name for run in found.runs] == ["calf=1", "calf=0.5", "thigh=0.5,gravity=9.8", "thigh=0.5,gravity=5"]
    assert [run.axes for run in found.runs] == [
        {"calf": 1.0, "thigh": 1.0},
        {"calf": 0.5, "thigh": 1.0},
        {"calf": 1.0, "thigh": 0.5, "gravity": 9.8},
        {"calf": 1.0, "thigh": 0.5, "gravity": 5.0},
    ]
    assert found.runs[3].scene.gravity == 5.0
    twice = GRIDS + '[[run]]\nname = "a"\n[[run]]\nname = "b"\nduration = 3\n'
    assert names(tmp_path, twice)[3:5] == ["a,thigh=0.5,gravity=5", "b,calf=1"]


def test_what_is_wrong_in_one_of_several_grids_has_its_place(tmp_path):
    with pytest.raises(SceneError, match=r"a\.toml:8: gravit: unknown key"):
        plan(tmp_path, GRIDS + "[[grid]]\ngravit = [9.8]\n")
    with pytest.raises(SceneError, match=r"a\.toml:8: grid\.2\.gravity: an axis is a list"):
        plan(tmp_path, GRIDS + "[[grid]]\ngravity = 9.8\n")


def test_shipped_sweep_weakens_three_groups_on_both_sides():
    found = read(Path(__file__).parents[2] / "tools" / "research" / "sweeps" / "weakness.toml")
    muscles = {"plantarflexors": "SOL", "hip_abductors": "HipAbd", "quadriceps": "VAS"}
    normal = found.runs[0].scene.character.muscles
    assert set(found.runs[0].axes.values()) == {1.0}
    for group in muscles:
        assert {run.axes[group] for run in found.runs} == {1.0, 0.75, 0.5, 0.25}
    assert len(found.runs) == 10
    for run in found.runs:
        for group, name in muscles.items():
            for muscle in (f"l{name}", f"r{name}"):
                assert run.scene.character.muscles[muscle].f_max == run.axes[group] * normal[muscle].f_max


def test_a_speed_that_no_term_weighs_is_told_of(tmp_path):
    """A search on walk56 weighs torques only."""
    with pytest.warns(SceneWarning, match="objective does not weigh speed") as told:
        plan(tmp_path, 'scene = "walk56"\n[grid]\n"objective.target_speed" = [0.8, 1.0]\n')
    assert [one.category for one in told].count(SceneWarning) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plan(tmp_path, 'scene = "walk56"\n[set]\n"objective.speed" = 10\n[grid]\n"objective.target_speed" = [0.8]\n')
        plan(tmp_path, 'scene = "walk56"\n[set]\n"objective.stride_speed" = 10\n"objective.target_speed" = 1.0\n')
        plan(tmp_path, 'scene = "walk56_human"\n[grid]\n"objective.target_speed" = [0.8, 1.0]\n')
        plan(tmp_path, 'scene = "walk56"\n')


@pytest.mark.parametrize(
    ("text", "keep"),
    [
        ("", "all"),
        ('[study]\nmeasures = ["speed"]\n', "best"),
        ('keep = "all"\n[study]\nmeasures = ["speed"]\n', "all"),
        ('keep = "best"\n', "best"),
    ],
)
def test_studies_keep_the_best_candidates_unless_they_are_told(tmp_path, text: str, keep: str):
    assert plan(tmp_path, f'scene = "fwalk"\n{text}[grid]\nseed = [1, 2]\nduration = [1, 2]\n').keep == keep


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('keep = "some"\n', r"a\.toml:2: keep: .*'some'"),
        ('keep = "best"\n[training]\niterations = 1\n', r"a\.toml:2: keep: trainings have no candidates"),
        ('keep = "best"\n[prune]\nafter = [0.5]\n', r"a\.toml:2: keep: runs that compete .* leave it out"),
    ],
)
def test_what_cannot_be_kept_is_refused_with_its_line(tmp_path, text: str, message: str):
    with pytest.raises(SceneError, match=message):
        plan(tmp_path, f'scene = "fwalk"\n{text}[grid]\nseed = [1, 2]\n')
