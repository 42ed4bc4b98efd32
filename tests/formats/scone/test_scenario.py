"""Scenarios of SCONE as scenes: states, reflexes, start and objective, values of parameters, and what is not known."""

import math
from pathlib import Path

import numpy as np
import pytest

import small_scone
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.formats.lines import Ignored
from warpmuscle.formats.scone.parameters import Parameter, read_parameters, write_parameters
from warpmuscle.formats.toml import dumps, loads
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import free_parameters, start_values, substitute

VALUES = [
    Parameter("stance_load_threshold", 0.2, 0.2, 0.01), Parameter("S00111.calf.KF", 1.6, 1.5, 0.1),
    Parameter("S00111.seat-tilt.KP", -0.5, 0.0, 0.1), Parameter("S11000.calf-foot.pos_max", -0.3, 0.0, 0.1),
    Parameter("tilt.offset", 0.02, 0.0, 0.01), Parameter("initial_load", 0.5, 0.5, 0.1),
    Parameter("nobody.KF", 1.0, 1.0, 0.1),
]  # fmt: skip


TILTED = "DofReflex { target = seat source = tilt"
POINT = "BodyPointReflex { direction [ 0 1 0 ] target = seat "


def read(folder: Path, **texts: str) -> Scene:
    return load(small_scone.write(folder, **texts), ignored=[])


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def test_reflexes_act_in_the_states_that_they_are_named_under(tmp_path: Path):
    scene = read(tmp_path)
    states = scene.gait_states
    assert states is not None
    assert scene.feet == ("foot_l", "foot_r")
    assert (states.base, states.control_step, states.least) == ("trunk", 0.005, 0.01)
    assert states.leg_length == pytest.approx(math.hypot(0.05, 0.49))
    assert states.stance_load == Free(0.1, min=0.001, max=1.0)
    assert states.swing_load is None
    assert list(states.reflexes) == ["S00111_calf", "S00111_seat-tilt", "S11000_seat-calf", "S11000_calf"]
    calf, seat = states.reflexes["S00111_calf"], states.reflexes["S00111_seat-tilt"]
    assert calf.during == ["early_stance", "late_stance", "liftoff"]
    assert calf.delay == 0.02
    assert (calf.constant, calf.force_gain) == (0.05, Free(1.2, min=-10.0, max=10.0))
    assert (seat.joint, seat.angle_target, seat.rate_gain, seat.positive) == ("root", -0.1, 0.4, [])
    other, silent = states.reflexes["S11000_seat-calf"], states.reflexes["S11000_calf"]
    assert (other.of, other.length_offset, other.velocity_gain, other.positive) == ("calf", 0.7, 0.1, ["velocity"])
    assert (silent.within_joint, silent.within_high) == ("foot", Free(-0.1, min=-1.0, max=1.0))


def test_the_best_values_of_a_par_file_are_where_numbers_start(tmp_path: Path):
    path = small_scone.write(tmp_path)
    write_parameters(tmp_path / "best.par", VALUES)
    notes = []
    scene = load(path, tmp_path / "best.par", ignored=notes)
    found = {one.name: one.value for one in free_parameters(scene)}
    assert found["gait_states.stance_load"] == 0.2
    assert found["gait_states.reflexes.S00111_calf.force_gain"] == 1.6
    assert found["gait_states.reflexes.S00111_seat-tilt.angle_gain"] == -0.5
    assert found["gait_states.reflexes.S11000_calf.within_high"] == -0.3
    lost = [note for note in notes if note.file == tmp_path / "best.par"]
    assert [(note.text, note.line) for note in lost] == [("nobody.KF", 7)]
    tilt = 2.0 * math.atan2(-float(scene.initial_state.root_orientation[0]), 1.0)
    assert tilt == pytest.approx(-0.05 + 0.02, abs=1e-4)  # start, and its offset


def test_a_scene_gives_its_parameters_back_in_scones_names(tmp_path: Path):
    scene = read(tmp_path)
    lost = []
    save(scene, tmp_path / "out.par", lost)
    found = {name: one.best for name, one in read_parameters(tmp_path / "out.par").items()}
    assert lost == []
    begun = {f"{name}.offset": 0.0 for name in ("tilt", "thigh_r", "foot_r", "thigh_l", "foot_l")}
    assert list(found)[:5] == list(begun)  # SCONE has them first
    assert found == begun | {
        "stance_load_threshold": 0.1,
        "S00111.calf.KF": 1.2,
        "S00111.seat-tilt.KP": 1.9,
        "S11000.seat-calf.KL": 2.0,
        "S11000.calf-foot.pos_max": -0.1,
    }


def test_offsets_and_load_of_the_start_come_back_as_they_were_given(tmp_path: Path):
    """Without them SCONE would start from another pose with the parameters that a search has found."""
    scenario = small_scone.SCENARIO.replace("initial_state_offset =", "initial_load = ~0.4<0,1> initial_state_offset =")
    path = small_scone.write(tmp_path, scenario)
    begun = {"initial_load": 0.6, "tilt.offset": 0.02, "thigh_l.offset": -0.03}
    write_parameters(tmp_path / "best.par", [Parameter(name, value, value, 0.01) for name, value in begun.items()])
    scene = loads(dumps(load(path, tmp_path / "best.par", ignored=[])))
    save(scene, tmp_path / "out.par")
    found = {name: one.best for name, one in read_parameters(tmp_path / "out.par").items()}
    assert {name: found[name] for name in begun} == begun
    assert found["foot_r.offset"] == 0.0
    again = load(path, tmp_path / "out.par", ignored=[])
    assert again.initial_state == scene.initial_state


def test_settings_of_a_search_are_noted_with_the_options_that_are_the_same_and_blocks_are_refused(tmp_path: Path):
    before, ignored = "min_progress = 1e-4", []
    settings = "lambda = 40 random_seed = 5 min_progress_samples = 200 optimizations = 6"
    load(small_scone.write(tmp_path, small_scone.SCENARIO.replace(before, settings, 1)), ignored=ignored)
    said = {one.text: one.reason for one in ignored}
    assert said["lambda"] == "--population 40 of `warpmuscle optimize` is the same; not used"
    assert said["random_seed"] == "--seed 5 of `warpmuscle optimize` is the same; not used"
    assert said["min_progress_samples"] == said["optimizations"] != said["lambda"]
    with pytest.raises(SceneError, match=r"pair.scone:3: Mystery: not known in `CmaOptimizer`"):
        read(tmp_path, scenario=small_scone.SCENARIO.replace(before, "Mystery { a = 1 }", 1))


def test_a_scene_stays_the_same_as_toml(tmp_path: Path):
    scene = read(tmp_path)
    assert loads(dumps(scene)) == scene


def test_the_start_has_the_load_on_the_ground_that_is_asked_for(tmp_path: Path):
    scene = read(tmp_path)
    plain = substitute(scene, start_values(scene))
    poses, pushed = world_poses(plain), 0.0
    for foot in ("foot_l", "foot_r"):
        position, orientation = poses[foot]
        angle = 2.0 * math.atan2(orientation[0], orientation[3])
        for _, y, z in ((shape.center) for shape in plain.character.bodies[foot].shapes):
            height = position[1] + y * math.cos(angle) - z * math.sin(angle)
            pushed += (3000.0 * max(0.03 - height, 0.0)) ** 1.5
    weight = 9.81 * (40.0 + 2.0 * (8.0 + 1.5))
    assert pushed == pytest.approx(0.2 * weight, rel=1e-5)
    assert plain.initial_state.root_velocity == (0.0, 0.0, 1.1)
    assert plain.initial_state.root_angular_velocity == pytest.approx((0.1, 0.0, 0.0))


def test_a_storage_file_starts_as_the_text_does(tmp_path: Path):
    text = read(tmp_path).initial_state
    names = [
        "tilt",
        "trunk_x",
        "thigh_r",
        "foot_r",
        "thigh_l",
        "foot_l",
        "tilt_u",
        "trunk_x_u",
        "thigh_r_u",
        "thigh_l_u",
    ]
    row = [-0.05, 0, 0.35, 0.05, -0.15, 0.02, -0.1, 1.1, -1.5, 0.8]
    lines = ["a", "inDegrees=no", "endheader", "\t".join(["time", *names]), "\t".join(map(str, [2.0, *row]))]
    (tmp_path / "data" / "start.zml").unlink()
    (tmp_path / "data" / "start.sto").write_text("\n".join(lines))
    assert load(tmp_path / "pair.scone", ignored=[]).initial_state == text


def test_balance_counts_the_part_of_the_time_that_a_fall_leaves(tmp_path: Path):
    """BalanceMeasure::GetResult of SCONE: (end - time) / end, of a height of 0.5 of the first one by default."""
    gait = "GaitMeasure { weight = 100 termination_height = 0.5 min_velocity = 1 }"
    found = [
        read(tmp_path, scenario=changed(small_scone.SCENARIO, gait, f"BalanceMeasure {{ {more} }}"))
        for more in ("weight = 40 termination_height = 0.8", "")
    ]
    assert [scene.objective.fall for scene in found] == pytest.approx([40.0 / 0.8, 1.0 / 0.8])
    assert [scene.failure.com_height for scene in found] == [0.8, 0.5]
    assert found[0].objective.speed == 0.0


def test_measures_become_terms_as_far_as_there_are_any(tmp_path: Path):
    notes = []
    scene = load(small_scone.write(tmp_path), ignored=notes)
    objective = scene.objective
    assert (objective.target_speed, objective.speed) == (1.0, pytest.approx(100.0 / 0.8))
    assert (objective.cost_of_transport, objective.metabolic_model) == (0.1, "wang")
    assert (scene.failure.com_height, scene.muscle_model.specific_tension) == (0.5, 2.5e5)
    assert any(note.text == "GaitMeasure" and "squared error" in note.reason for note in notes)


def test_weak_muscles_and_reflexes_that_always_act_come_in_as_well(tmp_path: Path):
    weak = "Properties { calf_l { max_isometric_force.factor = 0.2 } seat_r { optimal_fiber_length = 0.1 } }\n"
    more = (
        "ReflexController { name = Spastic symmetric = 1 MuscleReflex { target = calf delay = 0.02 C0 = 0.1 KF = 1 } }"
    )
    scenario = changed(small_scone.SCENARIO, "model_file", f"{weak} model_file")
    inside = f"CompositeController {{ << data/controller.scone >> {more} }}"
    scene = read(tmp_path, scenario=changed(scenario, "<< data/controller.scone >>", inside))
    muscles = scene.character.muscles
    assert (muscles["calf_l"].f_max, muscles["calf_r"].f_max) == (pytest.approx(600.0), 3000.0)
    assert (muscles["seat_r"].l_opt, muscles["seat_l"].l_opt) == (0.1, 0.12)
    assert scene.gait_states is not None
    spastic = scene.gait_states.reflexes["Spastic_calf"]
    assert len(spastic.during) == 5
    assert (spastic.constant, spastic.force_gain) == (0.1, 1.0)


@pytest.mark.parametrize(
    ("where", "old", "new", "said"),
    [
        (
            "controller",
            "GaitStateController",
            "SpinalController",
            "controller.scone:3: SpinalController: controllers of",
        ),
        ("controller", "MuscleReflex {", "BodyPainReflex {", "controller.scone:10: BodyPainReflex: not known in"),
        ("controller", "target = calf", "target = claf", "there is no muscle 'claf' in the model, nor claf_l"),
        ("controller", "source = tilt", "source = trunk_x", "of the root only its turns can be sensed: 'tilt'"),
        ("controller", "Liftoff", "Lift", "there is no state 'Lift'; there are EarlyStance"),
        ("controller", TILTED, "BodyPointReflex { target = seat", "no `source` in"),
        ("controller", TILTED, "BodyPointReflex { target = seat source = leg", "there is no `direction` in it"),
        ("controller", TILTED, POINT + "source = head", "there is no body 'head'"),
        ("controller", TILTED, "ComPivotReflex { dir [ 0 0 0 ] target = seat", "no length"),
        ("controller", "KF = ~1.2<-10,10>", "KX = 1", "KX: not known in `MuscleReflex`"),
        ("controller", "delay = 0.020", "delay = -1", "gait_states.reflexes.S00111_calf.delay: must not be negative"),
        ("controller", "delay = 0.020", "delay = 1e9", "the limit `delay`"),
        ("controller", "dof = foot", "dof = toe", "there is no joint 'toe' in the model"),
        ("scenario", "Wang2012", "Wang2013", "'Wang2013' is not known here; there are Wang2012"),
        ("scenario", "GaitMeasure", "MimicMeasure", "measures of this kind are not known here; there are"),
        ("scenario", "GaitMeasure", "BalanceMeasure", "min_velocity: not known in `BalanceMeasure`"),
        ("scenario", "max_duration = 0.8", "max_duration = 0.8 colour = 1", "colour: not known in"),
        ("scenario", "data/pair.hfd", "../pair.hfd", "leads out of the folder"),
        ("scenario", "data/pair.hfd", "data/none.hfd", "there is no file 'data/none.hfd' here"),
        ("scenario", "ModelHyfydy", "ModelOther", "there is no model in it; there are ModelHyfydy"),
        ("scenario", "CmaOptimizer", "Optimiser", "there is no SimulationObjective in it"),
    ],
)
def test_what_is_not_known_is_named_with_its_line(tmp_path: Path, where: str, old: str, new: str, said: str):
    text = {"controller": small_scone.CONTROLLER, "scenario": small_scone.SCENARIO}[where]
    with pytest.raises(SceneError) as caught:
        read(tmp_path, **{where: changed(text, old, new)})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_controller_alone_is_no_scenario(tmp_path: Path):
    (tmp_path / "a.scone").write_text(small_scone.CONTROLLER)
    with pytest.raises(SceneError, match=r"a.scone:\d+: \w+Controller: is a part of scenarios"):
        load(tmp_path / "a.scone", ignored=[])


def test_of_the_acceleration_of_a_point_it_is_said_over_what_time_it_is_taken(tmp_path: Path):
    text = changed(small_scone.CONTROLLER, TILTED, POINT + "source = leg KA = 1 A0 = 9.81")
    small_scone.write(tmp_path, controller=text)
    notes = []
    scene = load(tmp_path / "pair.scone", ignored=notes)
    assert scene.gait_states is not None
    found = [one for one in scene.gait_states.reflexes.values() if one.point is not None]
    assert [(one.acceleration_gain, one.acceleration_target) for one in found] == [(1.0, 9.81)]
    assert ["over a control step" in note.reason for note in notes if note.text == "leg"] == [True]


def test_a_scenario_is_written_as_no_scenario(tmp_path: Path):
    with pytest.raises(SceneError, match="a scene is written as"):
        save(read(tmp_path), tmp_path / "again.scone")


def test_every_prefix_of_a_scenario_is_read_or_refused(tmp_path: Path):
    random, read_or_refused = np.random.default_rng(4), []
    for end in random.integers(0, len(small_scone.SCENARIO), 40):
        try:
            read_or_refused.append(str(read(tmp_path, scenario=small_scone.SCENARIO[:end])))
        except SceneError as error:
            read_or_refused.append(str(error))
    assert not any("\n" in text for text in read_or_refused)


def test_a_motor_holds_a_chest_upright_by_reflexes_of_its_turns(tmp_path: Path):
    ignored: list[Ignored] = []
    path = small_scone.write(tmp_path, **small_scone.with_chest())
    scene = load(path, ignored=ignored)
    motor = scene.forces["back_motor"]
    assert (motor.type, motor.body, motor.other_body) == ("joint_motor", "trunk", "chest")
    given = {name: value for name, value in motor.parameters.items() if value != 0.0}
    assert given == {
        "stiffness": 5.0, "damping": 20.0, "most": 900.0, "lean_gain": Free(150.0, min=0.0, max=500.0),
        "lean_damping": 20.0, "lean_target": Free(-0.1, min=-0.5, max=0.5),
        "list_gain": Free(90.0, min=0.0, max=500.0), "list_damping": Free(9.0, min=0.0, max=50.0),
    }  # fmt: skip
    assert scene.character.joints["back_leans"].parent == "chest_z"  # about an axis that its limits leave no range on
    assert scene.forces["back_leans_limit"].parameters["stiffness"] == 30.0
    notes = {one.text: one.reason for one in ignored}
    assert notes["capsule on chest"] == "only spheres touch the ground here; left out"
    assert notes["delay of back_bends"] == "motors of joints act without delay here"
    values = [
        Parameter("posture.back_bends-chest.KP", 200.0, 200.0, 1.0),
        Parameter("back_leans.offset", 0.2, 0.2, 1.0),
    ]
    write_parameters(tmp_path / "found.par", values)
    found = load(path, tmp_path / "found.par", ignored=[])
    assert found.forces["back_motor"].parameters["lean_gain"] == Free(200.0, min=0.0, max=500.0)
    assert found.initial_state.joints["back_leans"] is not None


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        ("controller", "source = chest delay", "source = trunk delay", "of their own body, 'chest'"),
        ("controller", "axis = [ 1 0 0 ]", "axis = [ 0 1 0 ]", "its axis must be that of 'back_leans' here"),
        ("controller", "KV = 20", "KV = 20 C0 = 1", "C0: not known in `BodyOrientationReflex`; a motor is driven by"),
        ("controller", "target = back_leans source = chest axis = [ 1 0 0 ]", "target = back_bends source = chest",
         "one reflex drives a motor about this axis already"),
        ("controller", "$nerve = 0.005", "", "delay: $nerve has no value here: give it one before"),
        ("model", "joint = back", "joint = neck", "there is no joint 'neck'"),
        ("model", "target_ori = [ 0 0 0 ]", "target_ori = [ 0 0 9 ]", "a target_ori other than 0 is not known here"),
    ],
)  # fmt: skip
def test_what_a_motor_cannot_do_is_named_with_its_line(tmp_path: Path, text: str, old: str, new: str, said: str):
    texts = small_scone.with_chest()
    with pytest.raises(SceneError) as error:
        read(tmp_path, **texts | {text: changed(texts[text], old, new)})
    assert said in str(error.value)
    assert error.value.line > 0


def test_numbers_start_from_the_file_that_a_search_starts_from(tmp_path: Path):
    scenario = small_scone.SCENARIO.replace("min_progress = 1e-4", "init { file = data/found.par std_factor = 5 }", 1)
    path = small_scone.write(tmp_path, scenario=scenario)
    ignored: list[Ignored] = []
    states = load(path, ignored=ignored).gait_states
    assert states is not None
    assert states.stance_load == Free(0.1, min=0.001, max=1.0)
    assert "there is no file 'data/found.par' here; numbers start from their means" in {one.reason for one in ignored}
    write_parameters(tmp_path / "data" / "found.par", [Parameter("stance_load_threshold", 0.2, 0.3, 0.01)])
    assert load(path, ignored=[]).gait_states.stance_load == Free(0.3, min=0.001, max=1.0)
    path.write_text(changed(scenario, "std_factor = 5", "use_best_as_mean = 1"))
    assert load(path, ignored=[]).gait_states.stance_load == Free(0.2, min=0.001, max=1.0)


def test_activations_are_weighed_by_muscle_mass_and_way_as_their_measure_says(tmp_path: Path):
    effort = "EffortMeasure { weight = 1000 measure_type = CubedMuscleActivation"
    each, transport = "use_average_per_muscle = 1", "use_cost_of_transport = 1"
    before = small_scone.SCENARIO.index("EffortMeasure")

    def weight(*words: str) -> float:
        text = f"{effort} {' '.join(words)} }}\n"
        scene = read(tmp_path, scenario=small_scone.SCENARIO[:before] + text + small_scone.SCENARIO[before:])
        return scene.objective.effort_cubed

    mass, way = 40.0 + 2.0 * (8.0 + 1.5), 1.0  # kg; m, the least that counts, for 0.8 s at 1 m/s
    assert weight() == pytest.approx(1000.0 / 0.8)
    assert weight(each) == pytest.approx(1000.0 / 4.0 / 0.8)
    assert weight(each, transport) == pytest.approx(1000.0 / 4.0 / (mass * way))


def test_activation_may_be_that_of_opensim_and_no_heading_ends_a_simulation(tmp_path: Path):
    scenario = changed(
        small_scone.SCENARIO, "fixed_control", "use_opensim_activation_dynamics = 1\n\t\t\tfixed_control"
    )
    scene = read(tmp_path, scenario=scenario)
    assert (scene.muscle_model.activation, scene.muscle_model.rise_time) == ("scaled", 0.01)
    assert scene.failure.heading == 0.0
    assert read(tmp_path).muscle_model.activation == "excited"
