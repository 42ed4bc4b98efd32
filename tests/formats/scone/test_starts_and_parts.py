"""How active muscles of a SCONE scenario start, and pushes, jumps and other numbers of muscles in it."""

from pathlib import Path

import numpy as np
import pytest

import small_scone
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.formats.lines import Ignored
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
ACTIVE = {"calf_r": 0.4, "seat_r": 0.2, "calf_l": 0.001, "nobody": 0.3}
GAIT = "GaitMeasure { weight = 100 termination_height = 0.5 min_velocity = 1 }"
STEP = "fixed_control_step_size = 0.005"


def read(folder: Path, scenario: str = small_scone.SCENARIO, active: bool = False, **texts: str) -> Scene:
    path = small_scone.write(folder, scenario, **texts)
    if active:
        lines = " ".join(f"{name} = {value}" for name, value in ACTIVE.items())
        (folder / "data" / "start.zml").write_text(f"{small_scone.START}activations {{ {lines} }}\n")
    return load(path, ignored=[])


def model(settings: str) -> str:
    """The scenario with more settings of its model."""
    return small_scone.SCENARIO.replace(STEP, f"{STEP}\n{settings}")


def test_muscles_start_as_active_as_the_file_has_them_and_never_less_than_the_least(tmp_path: Path):
    # Model.h of scone-core: initialize_activations_from_controller, true unless state_init_file contains activations
    scene = read(tmp_path, active=True)
    expected = {"calf_r": 0.4, "seat_r": 0.2, "calf_l": 0.01, "seat_l": 0.05}
    assert scene.initial_state.activations == expected
    save(scene, tmp_path / "out.toml")
    assert load(tmp_path / "out.toml").initial_state.activations == expected
    for word in ("initialize_activations_from_controller = 1", "state_init_file_ignore_activations = 1"):
        assert read(tmp_path, model(word), active=True).initial_state.activations == {}
    assert read(tmp_path).initial_state.activations == {}


def test_activations_of_another_file_than_the_one_that_is_named_are_not_taken(tmp_path: Path):
    path = small_scone.write(tmp_path)
    (tmp_path / "data" / "start.zml").unlink()
    (tmp_path / "data" / "start.sto").write_text("a\nendheader\ntime\ttilt\tcalf_r.activation\n0\t-0.05\t0.4\n")
    assert load(path, ignored=[]).initial_state.activations == {}
    path.write_text(small_scone.SCENARIO.replace("start.zml", "start.sto"))
    assert load(path, ignored=[]).initial_state.activations["calf_r"] == 0.4


@pytest.mark.parametrize("active", [True, False])
def test_fibres_start_in_equilibrium_with_the_activations_that_muscles_start_with(tmp_path: Path, active: bool):
    """So no fibre moves fast at first, whether a file or the controller says how active muscles are."""
    scene = read(tmp_path, active=active)
    if active:
        scene.gait_states.least = 0.001
    rollout = Rollout(scene, record=[0], record_rate=1.0 / scene.time_step, device="cpu")
    rollout.run(10)
    names = list(rollout.muscle_names)
    seen = rollout.recording(0)
    if active:
        assert seen.muscle_activation[1, names.index("calf_r")] > 0.35
        assert seen.muscle_activation[3, names.index("calf_r")] > 0.3
    seats = [names.index("seat_l"), names.index("seat_r")]  # the calf's tendon is slack here
    speed = np.diff(seen.muscle_fibre_length[1:4, seats], axis=0)[1] / scene.time_step
    assert np.abs(speed / 0.12).max() < 1.5  # l_opt/s; 3.5 out of equilibrium


TURN = "BodyOrientationReflex { target = seat source = leg_o axis [ 1 0 0 ] KP = 0.4 }"


@pytest.mark.parametrize(
    ("version", "source", "expected"),
    [
        # scone-core: BodyOrientationReflex.cpp and GetSensorSide of Sensors.cpp ask for the version; ours is x to the
        # left, so that its x, forwards, is our z, and mirrors to -z.
        ("", "leg_o", (-1.0, True, True)), ("2.1.1.2637", "leg_o", (-1.0, True, True)),
        ("", "leg", (1.0, True, True)), ("", "leg_r", (1.0, False, True)), ("", "leg_l", (-1.0, False, True)),
        ("", "trunk", (1.0, True, True)), ("2.0.5", "leg_o", (1.0, True, True)),
        ("2.0.4.2347", "leg_o", (1.0, True, False)), ("unknown", "leg_o", (-1.0, True, True)),
    ],
)  # fmt: skip
def test_a_turn_is_mirrored_on_the_side_of_its_body_and_by_angles_as_the_version_has_it(
    tmp_path: Path, version: str, source: str, expected: tuple[float, bool, bool]
):
    controller = f"ReflexController {{ {TURN.replace('leg_o', source)} }}"
    text = model(f"scone_version = {version}") if version else small_scone.SCENARIO
    reflexes = read(tmp_path, text, controller=controller).gait_states.reflexes
    (turn,) = (one.turn for one in reflexes.values())
    assert turn is not None
    assert (turn.axis[2], turn.mirrored, turn.angles) == expected
    assert turn.axis[:2] == (0.0, 0.0)


def test_a_perturbation_is_a_push_in_our_axes(tmp_path: Path):
    push = (
        "PerturbationController { name = Back start_time = 3 duration = 0.1 interval = 4 stop_time = 9 "
        'force = [ -100 20 5 ] moment = "0 0 2" body = trunk position_offset = [ 0.01 0.05 0 ] }'
    )
    scene = read(tmp_path, controller=f"CompositeController {{ {small_scone.CONTROLLER} {push} }}")
    assert scene.forces["Back"].type == "push"
    assert scene.forces["Back"].body == "trunk"
    assert scene.forces["Back"].parameters == {
        "start": 3.0, "duration": 0.1, "interval": 4.0, "end": 9.0, "force_x": -5.0, "force_y": 20.0, "force_z": -100.0,
        "moment_x": -2.0, "moment_y": 0.0, "moment_z": 0.0, "place_x": 0.0, "place_y": 0.05, "place_z": 0.01,
    }  # fmt: skip
    for old, new, said in (
        ("body = trunk", "body = arm", "there is no body 'arm'"),
        ("duration = 0.1", "duration = 5", "nor longer than its interval"),
        ("duration = 0.1", "duration = 0.1..0.2", "'0.1..0.2' is not a number"),
    ):
        with pytest.raises(SceneError, match=f"controller.scone:.*{said}"):
            read(tmp_path, controller=f"CompositeController {{ {push.replace(old, new)} }}")


def test_a_jump_counts_how_high_the_body_comes(tmp_path: Path):
    jump = "CompositeMeasure { minimize = 0 JumpMeasure { termination_height = 0.75 weight = 2 } }"
    pattern = "FeedForwardController { symmetric = 1 PieceWiseConstant { control_points = 2 "
    pattern += "control_point_y = 0.3~0.01<0,1> control_point_dt = 0.2~0.01<0.001,1> } }"
    scene = read(tmp_path, small_scone.SCENARIO.replace(GAIT, jump), controller=pattern)
    assert scene.objective.rise == 200.0
    assert scene.failure.com_height == 0.0
    calf = scene.gait_states.patterns["calf"]
    assert calf.values == [Free(0.3, min=0.0, max=1.0)] * 2
    assert calf.shape == "constant"
    with pytest.raises(SceneError, match=r"pair.scone:16: JumpMeasure: long jumps"):
        read(tmp_path, small_scone.SCENARIO.replace(GAIT, "JumpMeasure { jump_type = 1 }"))


def test_muscles_and_the_mass_are_changed_as_modifiers_say(tmp_path: Path):
    before = read(tmp_path).character
    more = (
        'MuscleModifier { include = "calf*;nobody" exclude = "*_l" max_isometric_force { factor = 0.5 } } '
        "MuscleModifier { include = seat* tendon_slack_length = 0.16 } ModelModifier { mass = 30 } "
        "muscle_force_multiplier = 2"
    )
    after = read(tmp_path, model(more)).character
    muscles = after.muscles
    assert muscles["calf_r"].f_max == before.muscles["calf_r"].f_max
    assert muscles["calf_l"].f_max == 6000.0
    assert {muscles[name].l_slack for name in ("seat_l", "seat_r")} == {0.16}
    assert sum(float(body.mass) for body in after.bodies.values()) == pytest.approx(30.0)
    ratio = 30.0 / sum(float(body.mass) for body in before.bodies.values())
    assert np.allclose(after.bodies["trunk"].inertia, np.multiply(before.bodies["trunk"].inertia, ratio))
    for text, said in (
        ("MuscleModifier { include = arm* optimal_fiber_length = 1 }", "MuscleModifier: no muscle is included"),
        ("MuscleModifier { width = 1 }", "width: not known in `MuscleModifier`; muscles have"),
        ("ModelModifier { mass = 0 }", "its mass must be greater than 0"),
        ("BodyModifier { include = leg_r }", "BodyModifier: not known in `ModelHyfydy`"),
        ("ScriptController { script_file = a.lua }", "scripts in Lua are not run here"),
        ("sensor_delay_scaling_factor = 2", "a factor of delays other than 1 is not known"),
    ):
        with pytest.raises(SceneError, match=f"pair.scone:1[0-9]: .*{said}"):
            read(tmp_path, model(text))


def test_what_changes_the_motion_and_is_not_known_is_noted(tmp_path: Path):
    notes: list[Ignored] = []
    text = model("max_muscle_activation = 0.5\nblueprint = { path { tiles = 2 slopes = [ 0 3 ] } }")
    load(small_scone.write(tmp_path, text.replace(GAIT, "StepMeasure { stride_length { min = 1 } }")), ignored=notes)
    said = {note.text: (note.line, note.reason) for note in notes}
    assert said["blueprint"] == (14, "not known here, and not used: the ground is level")
    assert said["max_muscle_activation"][0] == 13
    assert said["StepMeasure"][1] == "no term counts what it does; left out"


def test_a_model_alone_and_older_files_are_read(tmp_path: Path):
    alone = "ModelHyfydy {\n model_file = data/pair.hfd state_init_file = data/start.zml simulation_end_time = 60\n"
    scene = read(tmp_path, alone + " FeedForwardController { Constant { value = 0.02 } } }\n")
    assert scene.duration == 60.0
    assert scene.gait_states.patterns["calf"].values == [0.02]
    offsets = 'include_states = *foot*;tilt exclude_states = "*_u;foot_l" offset = "0.02~0.01[-1,1]"'
    older = (
        "Optimizer { type = CmaOptimizerSpot Objective { type = SimulationObjective max_duration = 2\n"
        "Model { type = OpenSimModel model_file = data/pair.hfd state_init_file = data/start.zml\n"
        f"state_init_optimization {{ {offsets} }}\n"
        'Controllers { #include "data/controller.scone"\n } ; what is measured\n'
        "Measure { type = EffortMeasure measure_type = Uchida2016 MuscleProperties {\n"
        "  MuscleProperties { muscle = calf* slow_twitch_ratio = 0.8 } } } } } }\n"
    )
    scene = read(tmp_path, older)
    assert scene.duration == 2.0
    assert scene.objective.metabolic_model == "umberger"
    assert [scene.character.muscles[name].slow_fibres for name in ("calf_l", "seat_l")] == [0.8, 0.5]
    start = read(tmp_path).initial_state.joints
    assert scene.initial_state.joints["thigh_r"] == start["thigh_r"]
    assert scene.initial_state.joints["foot_l"] == start["foot_l"]
    assert scene.initial_state.joints["foot_r"] != start["foot_r"]
