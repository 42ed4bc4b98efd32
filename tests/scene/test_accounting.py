"""How metabolic energy is counted: of a shipped and of a published walk, and told wherever a cost is printed."""

import dataclasses
import sys
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from small_result import search_result
from warpmuscle.cli import console
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.gait.measures import measure
from warpmuscle.gait.muscle_effort import spent
from warpmuscle.gait.quality import gait_measures
from warpmuscle.plots import Subject
from warpmuscle.report.page import report_html
from warpmuscle.report.summary import report
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result
from warpmuscle.scene import Muscle, Objective, Scene
from warpmuscle.scene.accounting import FORMULAS, accounting, basal_rate, fibre_work, negative_share
from warpmuscle.scene.masses import common_mass, muscle_mass
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.rollout import Rollout

TOOLS = Path(__file__).parents[2] / "tools" / "research"
if str(TOOLS) not in sys.path:
    sys.path.append(str(TOOLS))

import gait_table  # noqa: E402

USUAL = "Wang 2012 with positive work, 1.51 W/kg at rest, 27.5 kg of muscle at 0.6 MPa (66 kg at 0.25 MPa)"


@cache
def human_walk() -> tuple[Recording, Scene]:
    """Ten seconds of the human-like walk on 56 muscles."""
    scene = load("walk56_human")
    scene = msgspec.structs.replace(substitute(scene, start_values(scene)), duration=10.0)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    rollout.run()
    return rollout.recording(), scene


def counted(scene: Scene, tension: float = 6e5, **objective) -> Scene:
    """The scene with another way of counting."""
    model = msgspec.structs.replace(scene.muscle_model, specific_tension=tension)
    objective = msgspec.structs.replace(scene.objective, **objective)
    return msgspec.structs.replace(scene, muscle_model=model, objective=objective)


@pytest.mark.parametrize(
    ("model", "tension", "cost"),
    [
        ("wang", 0.25e6, 6.80), ("wang", 0.547e6, 5.09), ("wang", 0.6e6, 4.97),
        ("bhargava", 0.25e6, 5.48), ("bhargava", 0.547e6, 3.77), ("bhargava", 0.6e6, 3.64),
    ],
)  # fmt: skip
def test_a_walk_costs_what_another_implementation_of_the_formulas_makes_of_it(model: str, tension: float, cost: float):
    """Costs, J/(kg m), are those of the same recorded walk by code of others' that was written for another model."""
    motion, scene = human_walk()
    gait = measure(motion, *scene.controller.feet)
    found = spent(motion.window(gait.start), counted(scene, tension, metabolic_model=model))
    assert found.power / gait.speed_horizontal == pytest.approx(cost, rel=0.01)


def test_a_published_walk_on_92_muscles_costs_what_its_parts_add_up_to():
    """Falisse 2022: 62 kg at 1.33 m/s, heats and work of fibres in J/(kg m); 3.60 by Bhargava, 5.00 by Wang."""
    heats, shortening, lengthening = 0.7829 + 1.010 + 0.416, 1.665, 1.168
    for model, expected in {"bhargava": 3.60, "wang": 5.00}.items():
        objective = Objective(metabolic_model=model)
        share = negative_share(objective)
        work = shortening - share * lengthening
        assert basal_rate(objective) / 1.33 + heats + work == pytest.approx(expected, abs=0.01)
    volume = 12.4 / 1059.7 * 0.547e6  # N m, sum of f_max l_opt, from the mass at their mean specific tension
    assert common_mass([Muscle(f_max=volume, l_opt=1.0, l_slack=0.1)]) == pytest.approx(27.1, abs=0.05)
    assert muscle_mass(Muscle(f_max=volume, l_opt=1.0, l_slack=0.1), 0.547e6) == pytest.approx(12.4)


def test_work_and_rate_at_rest_are_those_of_the_formula_unless_the_objective_has_its_own():
    for model, formula in FORMULAS.items():
        objective = Objective(metabolic_model=model)
        assert (fibre_work(objective), basal_rate(objective)) == (formula.work, formula.basal_rate)
        for work, share in (("net", 1.0), ("positive", 0.0)):
            own = Objective(metabolic_model=model, metabolic_work=work, basal_rate=0.5)
            assert (fibre_work(own), negative_share(own), basal_rate(own)) == (work, share, 0.5)
    assert {model: formula.work for model, formula in FORMULAS.items()} == {
        "wang": "positive", "umberger": "net", "bhargava": "net", "margaria": "positive",
    }  # fmt: skip


def test_ways_of_counting_that_there_are_not_are_named():
    text = toml.dumps(load("walk56")).replace("[objective]\n", '[objective]\nmetabolic_work = "gross"\n')
    with pytest.raises(SceneError, match=r"objective\.metabolic_work"):
        toml.loads(text)
    scene = load("walk56")
    scene.objective = Objective(basal_rate=-1.0)
    with pytest.raises(SceneError, match=r"objective\.basal_rate: must not be negative"):
        check_scene(scene)


@pytest.mark.usefixtures("unoptimized_test")
def test_the_objective_counts_as_the_measures_do():
    """Over the whole of a walk the cost of transport of the objective is that of what the recording shows."""
    _, scene = human_walk()
    objective = Objective(torque=0.0, cost_of_transport=1.0, metabolic_model="bhargava")
    scene = msgspec.structs.replace(scene, objective=objective, duration=3.0)
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=1.0 / scene.time_step)
    rollout.run()
    motion = rollout.recording()
    way = np.linalg.norm((motion.root_position[-1] - motion.root_position[0])[[0, 2]])
    shown = spent(motion, scene).power * 3.0 / way
    assert rollout.terms()["cost_of_transport"][0] == pytest.approx(shown, rel=0.01)


def test_gaits_are_printed_with_their_cost_and_how_it_is_counted(capsys):
    motion, scene = human_walk()
    console.print_gait(scene, motion)
    line = capsys.readouterr().out.splitlines()[1]
    assert line.startswith("cost of transport 4.9")
    assert " J/(kg m) (6.8" in line
    assert line.endswith(f" at 0.25 MPa): {USUAL}")
    console.print_gait(counted(scene, 0.25e6), motion)
    assert "(6.8" not in capsys.readouterr().out  # said once


def test_measures_tell_the_mass_and_the_cost_at_the_common_tension():
    motion, scene = human_walk()
    measures = gait_measures(motion, scene)
    assert measures["muscle mass"] == pytest.approx(27.5, abs=0.05)
    assert measures["cost of transport"] == pytest.approx(4.97, rel=0.01)
    assert measures["cost of transport at 0.25 MPa"] == pytest.approx(6.80, rel=0.01)


def energetic(tension: float) -> Result:
    """A search that weighs the cost of transport, of a walk with muscles of a specific tension."""
    result = search_result()
    scene = toml.loads(result.scene)
    scene.objective = Objective(cost_of_transport=2.0)
    scene.muscle_model.specific_tension = tension
    evaluations = dataclasses.replace(result.evaluations, term_names=("torque", "cost_of_transport"))
    return dataclasses.replace(result, scene=toml.dumps(scene), evaluations=evaluations)


@pytest.mark.parametrize(("tension", "warns"), [(6e5, False), (2.5e5, True)])
def test_reports_say_how_energy_is_counted_and_warn_of_too_much_muscle(tension: float, warns: bool):
    result = energetic(tension)
    words = accounting(Subject(result).scene, result.replays[0].muscle_names)
    assert words.startswith("Wang 2012 with positive work, 1.51 W/kg at rest, ")
    lines = report(result)
    assert sum(words in line for line in lines) == 1
    motion = report(dataclasses.replace(result, evaluations=None, best=None))
    for text in (lines, motion):
        assert any(" kg of muscle are " in line for line in text) == warns


def test_a_page_says_how_energy_is_counted_and_warns_of_too_much_muscle():
    result = energetic(2.5e5)
    words = accounting(Subject(result).scene, result.replays[0].muscle_names)
    page = report_html(Subject(result))
    assert f"Metabolic energy by {words}." in page
    assert f"Metabolic power and cost of transport of walk56: {words}." in page
    assert page.count(" kg of muscle are ") == 1


def test_a_report_without_energy_says_nothing_about_it():
    assert not any("W/kg at rest" in line for line in report(search_result()))


def test_the_tool_that_judges_gaits_says_how_energy_is_counted():
    def judged(name: str, words: str, **measures: float) -> gait_table.Judged:
        return gait_table.Judged(name, "", True, 1.0, 1, False, measures, accounting=words)

    power = {"metabolic power": 5.0}
    gaits = [judged("a", "this", **power), judged("b", ""), judged("c", "that", **power), judged("d", "this", **power)]
    assert gait_table.accountings(gaits) == ["Metabolic power of `a`, `d`: this.", "Metabolic power of `c`: that."]
