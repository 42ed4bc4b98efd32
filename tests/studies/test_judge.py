"""Verdicts on gaits: which bars are reached, what is measured at commands, what cannot be told."""

import json

import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from small_result import march
from warpmuscle.cli.common import with_commands
from warpmuscle.cli.program import app
from warpmuscle.cli.walkers import walker_of
from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import rounded
from warpmuscle.core.status import Status
from warpmuscle.examples import write
from warpmuscle.formats import load
from warpmuscle.gait.cycles import PERCENT
from warpmuscle.gait.joint_moments import from_people
from warpmuscle.gait.quality import TIMING
from warpmuscle.scene import Command
from warpmuscle.scene.number import Free
from warpmuscle.scene.people.pinzone import POWERS
from warpmuscle.studies import judge as judging
from warpmuscle.studies.judge import POWER, Walked
from warpmuscle.studies.people_comparison import of_norms
from warpmuscle.studies.verdicts import (
    COMFORTABLE,
    COST,
    COST_STRICT,
    ECONOMICAL,
    FURTHER_WALK,
    LOADED,
    OF_ENERGY,
    OF_MUSCLES,
    RUN,
    UPHILL,
    WALK,
    Bar,
    Finding,
    Verdict,
)
from warpmuscle.studies.walkers import SceneWalker, Walker, Walks


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Runs of few seconds."""
    for name, value in {"LONG": 6.0, "SHORT": 1.0, "COMMANDED": 4.0, "SPEEDS": 3, "IMPULSES": (5.0, 400.0)}.items():
        monkeypatch.setattr(judging, name, value)


def test_only_who_is_fast_runs_unless_the_scene_says_so(monkeypatch):
    scene = load("fwalk")
    for flight, speed, gait in ((5.0, 1.9, "walk"), (5.0, 2.1, "run"), (0.0, 2.5, "walk")):
        found = {"flight": flight, "speed": speed}
        monkeypatch.setattr(judging, "gait_measures", lambda *_, found=found: found)
        assert judging.gait_of(None, scene) == gait
    scene.objective.gait = "run"
    assert judging.gait_of(None, scene) == "run"


def commanded_walk():
    """fwalk on muscles' terms of a command: its step follows a speed, its ground a slope, its trunk a load."""
    scene = load("fwalk")
    scene.commands = {
        "speed": Command(1.0, 0.9, 1.1, unit="m/s"),
        "slope": Command(0.0, -5.0, 5.0, unit="deg"),
        "load": Command(0.0, 0.0, 25.0, unit="kg"),
    }
    scene.controller.states[0].time = Free(0.6, per={"speed": -0.2})
    scene.ground.normal = (0.0, 1.0, Free(0.0, per={"slope": -0.0175}))
    torso = scene.character.bodies["torso"]
    torso.mass = Free(torso.mass, per={"load": 1.0})
    return scene


@pytest.mark.parametrize(("value", "reached"), [(0.1, "goal"), (0.2, "must"), (0.3, "missed"), (None, "not measured")])
def test_a_value_reaches_the_goal_the_must_or_neither(value, reached):
    assert Verdict(Bar("x", "SD", (None, 0.25), (None, 0.12)), value).reached == reached


def test_muscles_that_take_up_more_than_they_spend_are_not_economical():
    costs = [bar for bar in WALK if bar.unit == "J/(kg m)" and bar.name.startswith("cost")]
    assert [bar.reached(-1.0) for bar in costs] == ["missed", "missed", "missed"]


class Marching(Walker):
    """Walks evenly, whatever disturbs it, with a force on its feet that has no valley."""

    def __init__(self) -> None:
        self._scene, self.commands = SceneWalker(load("fwalk")).scene(), {}

    def scene(self, commands=None):
        return self._scene

    def _walked(self, scene, disturbances, commands, recorded):
        n = len(disturbances)
        motions = [march(scene.character, 1.1, 4.0, 401) for _ in recorded]
        return Walks(np.full(n, int(Status.COMPLETED)), np.full(n, scene.duration), motions)


def test_a_force_without_a_valley_misses_the_bar_of_its_peaks():
    found = {one.bar.name: one for one in judging.judge(Marching(), pushes=0).verdicts}
    humps = found["force at peaks and valley"]
    assert (humps.value, humps.note, humps.reached) == (None, "no valley between two peaks", "missed")
    assert found["double support"].reached != "not measured"


def test_whoever_reaches_a_goal_reaches_what_must_be():
    for bar in (*WALK, *RUN):
        for value in (end for end in bar.goal if end is not None):
            assert bar.reached(value) == "goal"
            assert Bar(bar.name, bar.unit, bar.must, (np.inf, None)).reached(value) == "must"


def test_a_walk_on_torques_is_measured_but_for_its_energy():
    judgement = judging.judge(SceneWalker(load("fwalk"), "cpu", 1), pushes=1)
    found = {one.bar.name: one for one in judgement.verdicts}
    assert not judgement.running
    assert found["double support"].value == pytest.approx(judgement.measures["double support"])
    assert 10 <= found["upright, disturbed"].value <= 20
    assert 5.0 < found["impulse that half survive"].value < 400.0
    assert "cost of transport, Wang" not in found
    assert "most economical speed" not in found


class WithArms(SceneWalker):
    """Walks as the biped on torques does, and is said to have muscles at its elbows."""

    def scene(self, commands=None):
        return SceneWalker(load("elbow_open_loop")).scene()


def test_where_torques_help_the_energy_of_muscles_is_not_that_of_the_gait():
    judgement = judging.judge(WithArms(load("fwalk"), "cpu", 1), pushes=0)
    of_energy = [one for one in judgement.verdicts if one.bar.name in OF_ENERGY]
    assert [one.bar.name for one in of_energy] == list(OF_ENERGY)
    assert {(one.value, one.note, one.reached) for one in of_energy} == {
        (None, "torques help to drive it", "not measured")
    }


def test_gaits_are_measured_at_every_command_and_falls_are_told():
    told = []
    found = judging.at_conditions(SceneWalker(commanded_walk(), "cpu", 1), tell=told.append)
    asked = [one.asked for one in found]
    assert asked[0] == {}
    assert [one["speed"] for one in asked[1:4]] == pytest.approx([0.9, 1.0, 1.1])
    assert [one["slope"] for one in asked[4:6]] == [5.0, -5.0]
    assert [one["load"] for one in asked[6:]] == pytest.approx([0.18 * 70.4, 0.31 * 70.4], rel=0.01)
    assert found[3][1]["cadence"] > found[1][1]["cadence"]
    assert (found[4].measures, found[4].why) == ({}, "falls")
    assert told == ["8 walks of 4 s at other speeds, on slopes, with loads"]


def test_slopes_and_loads_that_a_gait_is_not_told_of_are_there_all_the_same():
    plain = load("fwalk")
    asked = judging.asked_of(SceneWalker(plain))
    assert [one.numbers for one in asked[:3]] == [{}, {"slope": 5.0}, {"slope": -5.0}]
    assert [one.load for one in asked[3:]] == pytest.approx([0.18 * 70.4, 0.31 * 70.4], rel=0.01)
    found = judging.at_conditions(SceneWalker(plain, "cpu", 1))
    assert [one.asked for one in found] == [one.numbers for one in asked]
    assert found[0][1]["speed"] == pytest.approx(0.95, abs=0.05)
    assert (found[1].measures, found[1].why) == ({}, "falls")
    assert found[3][1]["speed"] != found[0][1]["speed"]


def test_the_most_economical_speed_is_the_minimum_of_a_parabola_or_an_end():
    costs = [(v, 3.0 + (v - 1.27) ** 2) for v in (0.7, 1.0, 1.3, 1.6)]
    assert judging._economical(costs) == pytest.approx(1.27)
    assert judging._economical([(0.7, 1.0), (1.0, 2.0), (1.3, 3.0)]) == 0.7
    assert judging._economical(costs[:2]) is None


def test_loads_count_as_far_as_power_is_not_proportional_to_mass():
    level = {COST: 3.0, COST_STRICT: 4.1, POWER: 2.0}
    walks = [
        Walked({}, level), Walked({"slope": 5.0}, {COST: 6.2, COST_STRICT: 6.9}), Walked({"load": 12.7}, {POWER: 2.1}),
        Walked({"load": 21.8}, {POWER: 1.7}),
    ]  # fmt: skip
    found = judging._over_conditions(walks, load("fwalk"))
    assert found[UPHILL].value == pytest.approx(3.2)
    assert found[UPHILL].note == "6.20 net, 6.90 strict against 3.00 net, 4.10 strict"
    assert found[LOADED].value == pytest.approx(-15.0)
    assert found[LOADED].note == "18 % +5.0 %, 31 % -15.0 %"
    assert found[ECONOMICAL] == (None, "takes no speed", False, True)


def test_falls_are_misses_and_what_cannot_be_asked_for_is_not_measured():
    walks = [
        Walked({}, {COST: 3.0, POWER: 2.0}), Walked({"speed": 0.8}, {}, "has no whole gait cycle"),
        Walked({"speed": 1.2}, {COST: 3.1, COST_STRICT: 4.2}), Walked({"load": 12.7}, {}, "falls"),
    ]  # fmt: skip
    found = judging._over_conditions(walks, load("fwalk"))
    assert found[ECONOMICAL] == (None, "0.8 m/s has no whole gait cycle; 1.2 m/s 3.10 net, 4.20 strict", True, True)
    assert found[LOADED] == (None, "18 % falls", True, True)
    assert found[UPHILL] == (None, "takes no such slope", False, True)
    assert Verdict(WALK[-1], *found[LOADED]).reached == "missed"
    assert Verdict(WALK[-1], *found[UPHILL]).reached == "not measured"


def test_a_walker_that_falls_at_once_is_judged_and_misses():
    scene = load("fwalk")
    falling = msgspec.structs.replace(scene, failure=msgspec.structs.replace(scene.failure, com_height=0.999))
    judgement = judging.judge(SceneWalker(falling, "cpu", 1), pushes=0)
    found = {one.bar.name: one for one in judgement.verdicts}
    assert list(found) == [bar.name for bar in WALK if bar.name not in OF_MUSCLES]
    assert found["stance"].reached == "missed"
    assert "cycle" in found["stance"].note
    assert judgement.motion is not None
    assert judgement.end.startswith("fell: ")
    assert judgement.impaired == ()
    assert judgement.end.endswith(f", after {rounded(judgement.motion.end, 2)} s")
    assert found["upright, disturbed"].reached == "missed"
    assert judgement.commanded == []
    further = {one.bar.name: one.reached for one in judgement.further}
    assert further["upright, all at once"] == further["upright after 80 N s from the side"] == "missed"
    assert further["ankle power, maximum"] == "missed"


def test_a_walker_that_comes_to_the_end_without_a_gait_cycle_misses(monkeypatch):
    monkeypatch.setattr(judging, "LONG", 0.3)
    judgement = judging.judge(SceneWalker(load("fwalk"), "cpu", 1), pushes=0)
    assert judgement.end == Status.COMPLETED.meaning
    assert judgement.measures == {}
    found = {one.bar.name: one for one in judgement.verdicts}
    assert found["stance"].reached == found["step width"].reached == "missed"
    assert "after 0.2 s off the ground" in found["stance"].note


def test_the_command_prints_a_line_a_measure_and_writes_all_numbers(tmp_path):
    path, page = tmp_path / "judged.json", tmp_path / "judged.html"
    options = ["--pushes", "0", "--json", str(path), "--report", str(page), "--threads", "1"]
    done = CliRunner().invoke(app, ["judge", "fwalk", *options])
    assert done.exit_code == 0, done.output
    line = next(line for line in done.stdout.splitlines() if line.startswith("double support"))
    assert "18 to 25" in line
    assert "does not count" in line  # bodies pass through each other
    numbers = json.loads(path.read_text())
    assert {one["name"] for one in numbers["verdicts"]} >= {"stance", "impulse that half survive"}
    assert numbers["measures"]["speed"] == pytest.approx(0.94, abs=0.05)
    further = {one["name"]: one for one in numbers["further"]}
    assert list(further) == [bar.name for bar in FURTHER_WALK if bar.name not in OF_MUSCLES]
    assert further["commands met"]["note"] == "takes no command"
    assert further["variability of the step length"]["note"] == "its controller has no noise of nerves"
    assert "besides:" in done.stdout
    assert page.read_text().count("<section id=") > 5


def test_a_report_that_could_not_be_written_is_known_before_anything_is_judged(tmp_path):
    done = CliRunner().invoke(app, ["judge", "fwalk", "--report", str(tmp_path / "page.pdf")])
    assert done.exit_code != 0
    assert "a report is written as .html" in str(done.exception)


def test_a_policy_is_judged_as_it_acts_in_its_scene(tmp_path):
    write("policies", tmp_path)
    path, scene, saved = tmp_path / "walk56_like_people.h5", tmp_path / "walk56_like_people.toml", tmp_path / "j.json"
    options = ["--device", "cpu", "--threads", "1", "--pushes", "0", "--json", str(saved)]
    done = CliRunner().invoke(app, ["judge", str(path), *options])
    assert done.exit_code == 0, done.output
    assert "walk56_like_people, judged as a walk at 1.2" in done.stdout
    numbers = json.loads(saved.read_text())
    name, walker = walker_of([str(scene)], policy=path)
    assert name == numbers["scene"]
    stored = walker_of([str(path)])[1].scene()  # as it was learnt; its description has been written anew since
    assert walker.scene() == msgspec.structs.replace(stored, description=walker.scene().description)
    found = {one["name"]: one for one in numbers["verdicts"]}
    assert list(found) == [bar.name for bar in WALK]
    assert found["most economical speed"]["note"] == "takes no speed"
    assert found["cost of transport, Bhargava net"]["value"] < 3.6
    assert found["upright, disturbed"]["value"] >= 15
    for more in (["--policy", str(path)], ["--set", "duration=3"]):
        done = CliRunner().invoke(app, ["judge", str(path), *more])
        assert done.exit_code != 0
        assert f"takes no {more[0]}" in done.stderr + str(done.exception)


def test_commands_of_the_command_line_are_those_of_the_scene():
    scene = with_commands(commanded_walk(), ["speed=1.1", "slope = -2"])
    assert (scene.commands["speed"].asked, scene.commands["slope"].asked) == (1.1, -2.0)
    for text, words in (
        ("speed", "write NAME=VALUE"), ("sped=1", "did you mean 'speed'"), ("speed=fast", "not a number"),
        ("speed=9", "0.9 to 1.1 m/s"), ("speed=nan", "0.9 to 1.1 m/s"),
    ):  # fmt: skip
        with pytest.raises(Error, match=words):
            with_commands(commanded_walk(), [text])
    with pytest.raises(Error, match="takes no command 'speed', nor any other"):
        with_commands(load("fwalk"), ["speed=1"])


def test_a_gait_whose_bodies_pass_through_each_other_is_praised_for_nothing():
    bar = Bar("x", "SD", (None, 0.25), (None, 0.12))
    assert [Verdict(bar, value, void=True).reached for value in (0.1, 0.2, 0.3)] == ["does not count"] * 2 + ["missed"]
    assert Verdict(bar, None, void=True).reached == "not measured"
    assert WALK[0].name == RUN[0].name == "bodies inside each other"
    assert [WALK[0].reached(depth) for depth in (0.2, 0.9, 1.1)] == ["goal", "must", "missed"]


def test_rows_that_stand_beside_people_at_another_speed_judge_nothing_and_say_so():
    measures = {"speed": 1.6, "stance": 60.0, "angles outside the norms": 0.2, "step width": 0.1}
    found = of_norms(measures)
    assert found["stance"] == (60.0, "of people at their own speed, not at 1.60 m/s", False, False)
    assert found["angles outside the norms"].note.startswith("norms of 1.26 m/s, moved to 1.60 m/s by the trend")
    assert "step width" not in found
    assert of_norms(measures | {"speed": 1.3}) == {}
    assert not {bar.name for bar in WALK if bar.name.endswith("at this speed")} & set(COMFORTABLE)


def test_the_timing_of_muscles_names_those_that_are_least_like_people():
    measures = {TIMING: 40.0, "timing of soleus": 90.0, "timing of vasti": -20.0, "timing of hamstrings": 0.0}
    assert of_norms(measures)[TIMING] == (40.0, "least: vasti -20, hamstrings 0, soleus 90", False, True)
    assert TIMING in {bar.name for bar in WALK}


def test_a_row_that_is_no_judge_says_neither_goal_nor_missed():
    bar = Bar("x", "SD", (None, 0.25), (None, 0.12))
    assert {Verdict(bar, value, judges=False).reached for value in (0.1, 0.2, 0.3)} == {"no judge"}
    assert Verdict(bar, 0.3, judges=False, void=True).reached == "does not count"
    assert Verdict(bar, *Finding(0.3, "at 1.6 m/s", judges=False)).reached == "no judge"


def test_powers_and_the_trunk_are_judged_beside_people():
    names = {bar.name: bar for bar in WALK}
    for joint in ("hip", "knee", "ankle"):
        assert f"{joint} power from people" in names
        norm = POWERS[f"{joint.capitalize()} power"]
        mean, deviation = norm.mean(PERCENT), norm.sd(PERCENT).mean()
        assert from_people(f"{joint.capitalize()} power", [mean, mean + 2.0 * deviation]) == pytest.approx(1.0)
    for turn, mean, sd in (("tilt", 4.0, 1.8), ("obliquity", 3.3, 1.4), ("rotation", 6.9, 2.9)):  # Chung 2010
        bar = names[f"trunk {turn}, range"]
        assert bar.goal == pytest.approx((mean - sd, mean + sd))
        assert bar.must == pytest.approx((mean - 2.0 * sd, mean + 2.0 * sd))


def test_a_run_is_judged_by_when_its_feet_leave_the_ground():
    scene = load("fwalk")
    scene.objective.gait = "run"
    judgement = judging.judge(SceneWalker(scene, "cpu", 1), pushes=0)
    found = {one.bar.name: one for one in judgement.verdicts}
    assert judgement.running
    assert found["toe-off"].value == judgement.measures["stance"] > 50.0
    assert found["toe-off"].reached == "missed"
