"""What SCONE's tutorials and examples say in ways of their own: jumps, signs of measures, older numbers."""

import re
from pathlib import Path

import pytest

import small_scone
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.scone.parameters import Parameter, read_parameters, write_parameters
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free

PATTERN = """FeedForwardController { symmetric = 1 PieceWiseConstant { control_points = 2
 control_point_y = 0.3~0.01<0,1> control_point_dt = 0.2~0.01<0.001,1> } }"""
JUMP = "JumpMeasure { termination_height = 0.75 prepare_time = 0.25 }"
EFFORT = "EffortMeasure { weight = 0.1 measure_type = Wang2012 }"
FORCE = "ReactionForceMeasure { weight = 10 max = 1.5 abs_penalty = 1 }"


def scenario(measure: str, before: str = "") -> str:
    """The small scenario with other measures, and with something before its controller."""
    start = small_scone.SCENARIO.index("CompositeMeasure")
    text = f"{small_scone.SCENARIO[:start]}{measure}\n}}\n}}\n"
    return text.replace("<< data/controller.scone >>", f"{before}\n<< data/controller.scone >>")


def read(folder: Path, measure: str = JUMP, controller: str = PATTERN, before: str = "") -> tuple[Scene, list[Ignored]]:
    ignored: list[Ignored] = []
    path = small_scone.write(folder, scenario(measure, before), controller)
    return load(path, ignored=ignored), ignored


@pytest.mark.parametrize(
    ("measure", "rise", "metabolic"),
    [
        # scone-core: JumpMeasure wants much unless it is said or negated; a CompositeMeasure what its first part wants
        (JUMP, 100.0, 0.0),
        (f"CompositeMeasure {{ {JUMP} }}", 100.0, 0.0),
        ("JumpMeasure { negate_result = 1 weight = 2 }", 200.0, 0.0),
        (f"CompositeMeasure {{ minimize = 0 {EFFORT.replace('0.1', '-0.1')} {JUMP} }}", 100.0, 0.125),
        (f"CompositeMeasure {{ {EFFORT} JumpMeasure {{ weight = -3 }} }}", 300.0, 0.125),
        (f"CompositeMeasure {{ GaitMeasure {{ disabled = 1 speed = 3 }} {JUMP} }}", 100.0, 0.0),
    ],
)
def test_the_signs_of_jumps_and_of_what_counts_beside_them(tmp_path: Path, measure: str, rise: float, metabolic: float):
    scene, ignored = read(tmp_path, measure)
    assert (scene.objective.rise, scene.objective.metabolic) == (rise, pytest.approx(metabolic))
    assert not [one for one in ignored if "other sign" in one.reason]


def test_a_sign_by_which_a_search_would_seek_effort_is_told_of(tmp_path: Path):
    scene, ignored = read(tmp_path, f"CompositeMeasure {{ {JUMP} {EFFORT} }}")
    assert scene.objective.metabolic == pytest.approx(0.125)
    assert [one.text for one in ignored if "taken with the other sign" in one.reason] == ["EffortMeasure"]


def test_forces_count_as_often_as_their_penalty_says_by_its_newer_or_its_older_name(tmp_path: Path):
    assert read(tmp_path, FORCE)[0].objective.ground_force == pytest.approx(10.0 / 0.8)
    older = FORCE.replace("abs_penalty = 1", "abs_range_penalty = 3 start_time = 1 velocity { max = 2 }")
    scene, ignored = read(tmp_path, older)
    assert scene.objective.ground_force == pytest.approx(30.0 / 0.8)
    assert "velocity of ReactionForceMeasure" in {one.text for one in ignored}
    assert read(tmp_path, FORCE.replace("abs_penalty = 1", ""))[0].objective.ground_force == 0.0


def test_what_is_taken_otherwise_of_jumps_is_noted(tmp_path: Path):
    _, ignored = read(tmp_path, f"CompositeMeasure {{ {JUMP.replace('}', 'body = foot_r start_time = 1 }')} }}")
    said = {one.text: one.reason for one in ignored}
    assert "where SCONE counts that of foot_r" in said["body"]
    assert said["start_time of JumpMeasure"] == "counts over the whole time here"


def test_times_between_knots_whose_bounds_begin_at_0_are_kept_above_it(tmp_path: Path):
    scene, ignored = read(tmp_path, controller=PATTERN.replace("<0.001,1>", "<0,1>"))
    assert scene.gait_states is not None
    assert {str(one.intervals) for one in scene.gait_states.patterns.values()} == {str([Free(0.2, min=0.001, max=1.0)])}
    assert [one.line for one in ignored if one.text == "control_point_dt"] == [2]
    with pytest.raises(SceneError, match=r"controller.scone:1: gait_states.patterns.*must be greater than 0"):
        read(tmp_path, controller=PATTERN.replace("0.2~0.01<0.001,1>", "0"))
    with pytest.raises(SceneError, match=r"controller.scone:2: control_point_dt: its bounds end at 0"):
        read(tmp_path, controller=PATTERN.replace("0.2~0.01<0.001,1>", "0~0.01<-1,0>"))


def test_a_free_number_may_be_a_block_as_before_2017(tmp_path: Path):
    block = PATTERN.replace("= 0.3~0.01<0,1>", "{ mean = 0.3 std = 0.01 min = 0.0 max = 1 }")
    scene, _ = read(tmp_path, controller=block)
    assert scene.gait_states is not None
    assert scene.gait_states.patterns["calf"].values == [Free(0.3, min=0.0, max=1.0)] * 2
    with pytest.raises(SceneError, match="control_point_y: its spread must be greater than 0"):
        read(tmp_path, controller=block.replace("std = 0.01", "std = 0"))
    with pytest.raises(SceneError, match="colour: not known in `control_point_y`; a free number has mean"):
        read(tmp_path, controller=block.replace("std = 0.01", "colour = 1"))


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ({"controller": f"CompositeController {{ {PATTERN} ScriptController {{ script_file = a.lua }} }}"},
         r"controller.scone:2: ScriptController: scripts in Lua are not run here"),
        ({"measure": f"CompositeMeasure {{ {JUMP} ScriptMeasure {{ script_file = a.lua }} }}"},
         r"pair.scone:16: ScriptMeasure: scripts in Lua are not run here"),
        ({"before": "Parameters { dt = 0.2~0.01<0,1> }"}, r"pair.scone:14: Parameters: numbers that several places"),
        ({"controller": f"SequentialController {{ {PATTERN} }}"}, "controllers of this kind are not known here"),
    ],
)  # fmt: skip
def test_parts_that_are_not_known_are_named_wherever_they_stand(tmp_path: Path, what: dict[str, str], said: str):
    with pytest.raises(SceneError, match=said):
        read(tmp_path, **what)


def test_another_objective_and_a_model_without_muscles_are_named(tmp_path: Path):
    path = small_scone.write(tmp_path, scenario(JUMP).replace("SimulationObjective", "ImitationObjective"), PATTERN)
    with pytest.raises(SceneError, match=r"pair.scone:4: ImitationObjective: objectives of this kind are not known"):
        load(path, ignored=[])
    without = re.sub(r"\tpoint_path_muscle \{.*?\n\t\}\n", "", small_scone.MODEL, flags=re.DOTALL)
    path = small_scone.write(tmp_path, scenario(JUMP), PATTERN, without)
    with pytest.raises(SceneError, match=r"FeedForwardController: patterns drive muscles, of which the model has none"):
        load(path, ignored=[])


def test_a_file_of_parameters_of_another_scenario_is_refused(tmp_path: Path):
    path = small_scone.write(tmp_path, scenario(JUMP), PATTERN)
    write_parameters(tmp_path / "other.par", [Parameter("S00111.soleus.KF", 1.0, 1.0, 0.1)])
    with pytest.raises(SceneError, match=r"other.par: no name in it, such as S00111.soleus.KF, .* such as calf.Y0"):
        load(path, tmp_path / "other.par", ignored=[])


def written(folder: Path, **texts: str) -> tuple[dict[str, float], list[Ignored]]:
    """Best values by name that a scenario's scene writes as a .par, after a detour over its own file."""
    scene = load(small_scone.write(folder, **texts), ignored=[])
    save(scene, folder / "scene.toml")
    lost: list[Ignored] = []
    save(load(folder / "scene.toml", ignored=[]), folder / "out.par", lost)
    return {name: one.best for name, one in read_parameters(folder / "out.par").items()}, lost


def test_numbers_of_motors_are_written_in_the_names_that_they_are_read_by(tmp_path: Path):
    found, lost = written(tmp_path, **small_scone.with_chest())
    motors = {
        "posture.back_bends-chest.KP": 150.0, "posture.back_bends-chest.P0": -0.1,
        "posture.back_leans-chest.KP": 90.0, "posture.back_leans-chest.KV": 9.0,
    }  # fmt: skip
    assert {name: found[name] for name in motors} == motors
    assert not lost
    assert load(tmp_path / "pair.scone", tmp_path / "out.par", ignored=(noted := [])).forces["back_motor"]
    assert not [one for one in noted if one.file.suffix == ".par"]


def test_numbers_of_controllers_with_a_name_and_of_several_reflexes_alike_are_written_once(tmp_path: Path):
    reflex = "MuscleReflex { target = calf source = seat KF = ~0.5<0,2> delay = 0.02 }"
    controller = f"ReflexController {{ name = Upright symmetric = 1 {reflex} {reflex} }}"
    noisy = f"CompositeController {{ {controller} {PATTERN.replace('{ symm', '{ name = Hop symm')} }}"
    found, lost = written(tmp_path, controller=noisy)
    assert found["Upright.calf-seat.KF"] == 0.5
    assert {name for name in found if name.startswith("Hop.")} == {
        f"Hop.{muscle}.{number}" for muscle in ("calf", "seat") for number in ("Y0", "Y1", "DT0")
    }
    assert len([name for name in found if not name.endswith(".offset")]) == 7
    assert not lost
    scene = load(tmp_path / "pair.scone", ignored=[])
    assert scene.gait_states is not None
    scene.gait_states.reflexes["Upright_calf-seat_2"].force_gain = Free(1.0, min=0.0, max=2.0)
    save(scene, tmp_path / "two.par", lost)
    assert [one.text for one in lost] == ["gait_states.reflexes.Upright_calf-seat_2.force_gain"]
    assert read_parameters(tmp_path / "two.par")["Upright.calf-seat.KF"].best == 0.5


ONE_LEG = """ReflexController {{ name = hop dual_sided = 0
 MuscleReflex {{ target = calf_l delay = 0.02 KF = ~0.5<0,1> }}
 MuscleReflex {{ target = {target} source = {source} KL = 2 L0 = 0.7 }} }}"""


def test_reflexes_of_one_leg_say_which_one_it_is(tmp_path: Path):
    scene, _ = read(tmp_path, controller=ONE_LEG.format(target="seat_r", source="calf_l"))
    found = scene.gait_states.reflexes
    assert {name: (one.muscle, one.side, one.of, one.opposite) for name, one in found.items()} == {
        "hop_calf_l": ("calf", "left", "", False),
        "hop_seat_r-calf_l": ("seat", "right", "calf", True),
    }
    scene, _ = read(tmp_path, controller=ONE_LEG.format(target="seat_r", source="calf_r"))
    assert scene.gait_states.reflexes["hop_seat_r-calf_r"].opposite is False


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (ONE_LEG.format(target="seat", source="calf_l"), "3: target: with dual_sided = 0 it says of which leg it is"),
        (ONE_LEG.format(target="seet_l", source="calf_l"), "3: target: there is no muscle 'seet' in the model"),
        (
            "ReflexController {\n MuscleReflex { target = calf_l KF = 1 } }",
            "2: target: names the muscle of one leg: leave _l out, or say dual_sided = 0 above",
        ),
        (
            "ReflexController {\n MuscleReflex { target = calf KF = 1 delay = -0.1 } }",
            "2: .*delay: must not be negative",
        ),
    ],
)
def test_what_is_wrong_in_reflexes_of_a_leg_is_told_with_its_line(tmp_path: Path, controller: str, message: str):
    with pytest.raises(SceneError, match=rf"controller\.scone:{message}"):
        read(tmp_path, controller=controller)


def test_states_take_composite_controllers_and_lists_without_names(tmp_path: Path):
    inside = "ReflexController { MuscleReflex { target = calf KF = 1 } }"
    pattern = PATTERN.replace("symmetric = 1", "")
    plain = f"states = Swing {inside} {pattern}"
    nested = f"states = Swing CompositeController {{ name = two {inside} CompositeController {{ {pattern} }} }}"
    found = [
        read(tmp_path, controller=f"GaitStateController {{ ConditionalControllers {text} }}")[0].gait_states
        for text in (f"{{ ConditionalController {{ {plain} }} }}", f"[ {{ {nested} }} ]")
    ]
    assert found[0] == found[1]
    assert (len(found[0].reflexes), len(found[0].patterns)) == (1, 2)
    with pytest.raises(SceneError, match="NoiseController: not known in `ConditionalController`; what acts in states"):
        read(
            tmp_path,
            controller="GaitStateController { ConditionalControllers { ConditionalController { states = Swing"
            " NoiseController { base_noise = 1 } } } }",
        )
