"""What `check_scene` rejects, and the key that it names."""

import copy
import math

import numpy as np
import pytest

from biped import biped
from small_scene import ZERO, X, hip, muscle_scene, sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import LIMITS
from warpmuscle.scene import (
    PD,
    Actuation,
    Body,
    Condition,
    Curve,
    Excitation,
    InitialState,
    JointState,
    Muscle,
    MuscleModel,
    Scene,
    SearchStage,
    Trajectory,
    ViaPoint,
)
from warpmuscle.scene.number import Free
from warpmuscle.scene.simbicon.checks import trajectory_joints
from warpmuscle.scene.validation import scene as validation
from warpmuscle.scene.validation.muscles import initial_path_lengths, slack_warnings
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.simulation.stages import Stages


def changed(key: str, value: object) -> Scene:
    """The small scene with muscles and another value at a path; missing members of tables are added."""
    scene = copy.deepcopy(muscle_scene())
    *path, last = key.split(".")
    part: object = scene
    for name in path:
        index = int(name) if isinstance(part, list) else name
        part = part[index] if isinstance(part, list | dict) else getattr(part, name)
    if isinstance(part, list | dict):
        part[int(last) if isinstance(part, list) else last] = value
    else:
        setattr(part, last, value)
    return scene


def test_a_stage_that_frees_only_what_it_sets_itself_is_refused():
    scene = changed("objective.speed", Free(1.0, 0.0, 2.0))
    scene.stages = [SearchStage("a", {"speed": 1.0}, free=["objective.*"])]
    with pytest.raises(SceneError, match=r"stages\.0\.free: everything that this stage frees is also set by it"):
        check_scene(scene)


def test_sound_scenes_pass():
    check_scene(sound_scene())
    check_scene(muscle_scene())
    check_scene(changed("controller", None))


def test_trajectories_change_sides_with_the_stance():
    assert trajectory_joints("SWING_Hip", {}) == ("rHip", "lHip")
    assert trajectory_joints("STANCE_Hip", {}) == ("lHip", "rHip")
    assert trajectory_joints("torso_head", {}) == ("torso_head", "torso_head")


def test_trajectories_find_joints_of_other_names_in_pairs():
    pairs = {"Knee": ("knee_angle_l", "knee_angle_r")}
    assert trajectory_joints("SWING_Knee", pairs) == ("knee_angle_r", "knee_angle_l")
    assert trajectory_joints("STANCE_Knee", pairs) == ("knee_angle_l", "knee_angle_r")
    assert trajectory_joints("SWING_Hip", pairs) == ("rHip", "lHip")
    scene = changed("controller.pairs", {"Hip": ("lHip", "rhip")})
    with pytest.raises(SceneError, match=r"controller\.pairs\.Hip\.1: .*'rhip'"):
        check_scene(scene)


def test_only_states_that_end_by_contact_wait_beyond_phase_one():
    scene = changed(f"{STATE}.longest", 1.4)
    check_scene(scene)
    scene.controller.states[0].transition = "time_up"
    with pytest.raises(SceneError, match=r"states\.0\.longest: only a state that ends on `foot_down` may last"):
        check_scene(scene)


STATE = "controller.states.0"
COMPONENT = f"{STATE}.trajectories.SWING_Hip.components.0"
HFL, TFL = "character.muscles.HFL", "character.muscles.TFL"
COLLIDING = "failure.self_collision_pairs"
CONDITION = f"{TFL}.path.1.condition"
HERE = ViaPoint("pelvis", ZERO)


@pytest.mark.parametrize(
    ("key", "value", "at", "message"),
    [
        ("name", " ", "name", "needs a name"),
        ("duration", 0.0, "duration", "must be greater than 0, is 0"),
        ("time_step", -1.0, "time_step", "greater than 0"),
        ("time_step", 11.0, "time_step", "longer than the duration"),
        ("gravity", math.nan, "gravity", "not a finite number"),
        ("gravity", "9.8", "gravity", "expected a number, got text"),
        ("character.root", "pelvs", "character.root", "no body is called 'pelvs'; did you mean 'pelvis'?"),
        ("character.bodies.lFoot.mass", 0.0, "character.bodies.lFoot.mass", "must be greater than 0"),
        ("character.bodies.lFoot.mass", Free(1.0, 0.0, 2.0), "character.bodies.lFoot.mass", "must be greater than 0"),
        ("character.bodies.lFoot.inertia", (1.0, -1.0, 1.0), "character.bodies.lFoot.inertia.1", "greater than 0"),
        ("character.bodies.lFoot.inertia", (1.0, 1.0), "character.bodies.lFoot.inertia", "expected 3 values, got 2"),
        ("character.bodies.lFoot.friction", -0.1, "character.bodies.lFoot.friction", "must not be negative"),
        ("character.bodies.lFoot.shapes.0.low", (2.0, 0.0, 0.0), "character.bodies.lFoot.shapes.0.low.0", "greater"),
        ("character.bodies.pelvis.shapes.0.radius", 0.0, "character.bodies.pelvis.shapes.0.radius", "greater than 0"),
        ("character.bodies.hand", Body(1.0, X), "character.bodies.hand.inertia.1", "must be greater than 0"),
        ("character.bodies.hand", Body(1.0, (1.0,) * 3), "character.bodies.hand", "no joint connects it to the root"),
        ("character.joints.lHip.parent", "hips", "character.joints.lHip.parent", "no body is called 'hips'"),
        ("character.joints.lHip.child", "rFoot", "character.joints.rHip.child", "is a child of joint 'lHip' already"),
        ("character.joints.lHip.child", "pelvis", "character.joints.lHip.child", "is the root and cannot be a child"),
        ("character.joints.lHip.parent", "lFoot", "character.joints.lHip.parent", "loop: lFoot -> lFoot"),
        ("character.joints.root", hip("l"), "character.joints.root", "cannot be called root"),
        ("character.joints.lHip.axes", [X], "character.joints.lHip.axes", "takes 2 axes, got 1"),
        ("character.joints.lHip.axes.1", ZERO, "character.joints.lHip.axes.1", "axis has no length"),
        ("character.joints.lHip.axes.1", (-2.0, 0.0, 0.0), "character.joints.lHip.axes", "parallel"),
        ("character.joints.lHip.limits", [(0.0, 1.0)], "character.joints.lHip.limits", "3 limits or none, got 1"),
        ("character.joints.lHip.limits.2", (1.0, 0.0), "character.joints.lHip.limits.2", "low 1 is greater than high"),
        ("character.joints.lHip.limit_damping", -1.0, "character.joints.lHip.limit_damping", "negative"),
        ("controller.pd.lKnee", PD(1.0, 1.0), "controller.pd.lKnee", "no joint is called 'lKnee'"),
        ("controller.pd.root.kp", -1.0, "controller.pd.root.kp", "must not be negative"),
        ("controller.pd.root.kp", Free(same_as="controller.pd.lHip.kd"), "controller.pd.root.kp.same_as", "not a free"),
        ("controller.pd.root.kp", Free(same_as="controller.pd.root.kp"), "controller.pd.root.kp.same_as", "itself"),
        ("controller.feet", ("lFoot", "rfoot"), "controller.feet.1", "did you mean 'rFoot'?"),
        ("controller.hips", ("lHip", "lHip"), "controller.hips", "left and right are both 'lHip'"),
        ("controller.states", [], "controller.states", "at least one state"),
        (f"{STATE}.longest", 0.9, f"{STATE}.longest", "must be at least 1, is 0.9"),
        (f"{STATE}.longest", Free(1.2, 0.8, 1.5), f"{STATE}.longest", "must be at least 1, is 0.8"),
        ("controller.start_state", 1, "controller.start_state", "there is no state 1"),
        (f"{STATE}.next", -1, f"{STATE}.next", "there is no state -1"),
        (f"{STATE}.time", 0.0, f"{STATE}.time", "must be greater than 0"),
        (f"{STATE}.trajectories.STANCE_Knee", Trajectory(), f"{STATE}.trajectories.STANCE_Knee", "'lKnee' of this"),
        (f"{STATE}.trajectories.neck", Trajectory(), f"{STATE}.trajectories.neck", "no joint is called 'neck'"),
        (f"{STATE}.balance.velocity_z", Curve([], []), f"{STATE}.balance.velocity_z.phase", "at least one knot"),
        (f"{COMPONENT}.axis", ZERO, f"{COMPONENT}.axis", "no length"),
        (f"{COMPONENT}.angle", [1.0], f"{COMPONENT}.angle", "1 value for 2 phases"),
        (f"{COMPONENT}.phase", [0.5, 0.5], f"{COMPONENT}.phase.1", "phases must increase, but 0.5 follows 0.5"),
        (f"{COMPONENT}.angle.1", math.inf, f"{COMPONENT}.angle.1", "not a finite number"),
        (f"{COMPONENT}.feedback.axis", ZERO, f"{COMPONENT}.feedback.axis", "no length"),
        (f"{COMPONENT}.feedback.d_limits", (1.0, 0.0), f"{COMPONENT}.feedback.d_limits", "greater than high"),
        ("initial_state.root_orientation", (0.0,) * 4, "initial_state.root_orientation", "quaternion has no length"),
        ("initial_state.joints.knee", JointState(), "initial_state.joints.knee", "no joint is called 'knee'"),
        ("ground.normal", ZERO, "ground.normal", "normal has no length"),
        ("ground.normal", (0.0, -1.0, 0.1), "ground.normal", "upwards, out of the ground"),
        ("ground.normal", (1.0, 0.0, 0.0), "ground.normal", "y must be greater than 0, is 0"),
        ("ground.stiffness", -1.0, "ground.stiffness", "must not be negative"),
        ("failure.self_collision", -0.01, "failure.self_collision", "must not be negative"),
        (COLLIDING, [("pelvis", "lFot")], f"{COLLIDING}.0.1", "no body is called 'lFot'; did you mean 'lFoot'?"),
        (COLLIDING, [("pelvis", "lFoot"), ("rFoot", "lFoot")], f"{COLLIDING}.1.0", "'rFoot' has no shape that could"),
        (COLLIDING, [("lFoot", "lFoot")], f"{COLLIDING}.0", "a pair takes two bodies, got 'lFoot' twice"),
        (COLLIDING, [("lFoot",)], f"{COLLIDING}.0", "expected 2 values, got 1"),
        ("failure.max_speed", 0.0, "failure.max_speed", "must be greater than 0"),
        ("objective.failure_cost", 0.0, "objective.failure_cost", "must be greater than 0"),
        ("stages", [SearchStage(" ")], "stages.0.name", "needs a name"),
        ("stages", [SearchStage("a"), SearchStage("a")], "stages.1.name", "stage 0 is called 'a' already"),
        ("stages", [SearchStage("a", {"sped": 1.0})], "stages.0.objective.sped", "unknown key; did you mean 'speed'?"),
        ("stages", [SearchStage("a", {"speed": -1.0})], "stages.0.objective.speed", "must not be negative"),
        ("stages", [SearchStage("a", {"speed": "x"})], "stages.0.objective.speed", "expected a number, got text"),
        ("stages", [SearchStage("a", {"speed": math.inf})], "stages.0.objective.speed", "not a finite number"),
        ("stages", [SearchStage("a", {"speed": Free(1.0, 0.0, 2.0)})], "stages.0.objective.speed", "got a table"),
        ("stages", [SearchStage("a", {"tracking": 1.0})], "stages.0.objective.tracking", "no gait to track"),
        ("stages", [SearchStage("a", {"head": 1.0})], "stages.0.objective.head_body", "no body is called 'head'"),
        ("stages", [SearchStage("a", {"metabolic_model": "wong"})], "stages.0.objective.metabolic_model", "'wang'?"),
        ("stages", [SearchStage("a", {}, {"com_hight": 0.5})], "stages.0.failure.com_hight", "mean 'com_height'?"),
        ("stages", [SearchStage("a", {}, {"com_height": True})], "stages.0.failure.com_height", "got true or false"),
        ("stages", [SearchStage("a", {}, {"max_speed": 0.0})], "stages.0.failure.max_speed", "greater than 0"),
        ("stages", [SearchStage("a", robustness={"slop": 0.1})], "stages.0.robustness.slop", "mean 'slope'?"),
        ("stages", [SearchStage("a", robustness={"runs": 0})], "stages.0.robustness.runs", "must be 1 at least"),
        ("stages", [SearchStage("a", robustness={"runs": 1.5})], "stages.0.robustness.runs", "expected a whole number"),
        ("stages", [SearchStage("a", robustness={"mass": 1.0})], "stages.0.robustness.mass", "less than 1"),
        ("stages", [SearchStage("a", duration=1e-5)], "stages.0.duration", "shorter than the time step"),
        ("stages", [SearchStage("a", duration=-1.0)], "stages.0.duration", "greater than 0"),
        ("stages", [SearchStage("a", candidates=0.0)], "stages.0.candidates", "greater than 0"),
        ("stages", [SearchStage("a", candidates=1.5)], "stages.0.candidates", "neither a whole number nor a part"),
        ("stages", [SearchStage("a", searches=0)], "stages.0.searches", "greater than 0"),
        ("stages", [SearchStage("a", population=1.5)], "stages.0.population", "expected a whole number"),
        ("stages", [SearchStage("a", free=["*", "controler.*"])], "stages.0.free.1", "did you mean 'controller.*'?"),
        (f"{HFL}.path", [HERE], f"{HFL}.path", "at least two points, got 1"),
        (f"{HFL}.path.1.body", "lfoot", f"{HFL}.path.1.body", "there is no body 'lfoot'; did you mean 'lFoot'?"),
        (f"{HFL}.path.0.position", (0.0, math.nan, 0.0), f"{HFL}.path.0.position.1", "not a finite number"),
        (f"{CONDITION}.joint", "ltoe", f"{CONDITION}.joint", "there is no joint 'ltoe'; did you mean 'lToe'?"),
        (f"{CONDITION}.joint", "lHip", f"{CONDITION}.blend", "give a blend of 0"),
        (f"{CONDITION}.axis", 1, f"{CONDITION}.axis", "a hinge joint has no angle 1"),
        (f"{CONDITION}.axis", -1, f"{CONDITION}.axis", "no angle -1"),
        (f"{CONDITION}.low", 0.5, f"{CONDITION}.low", "low must be less than high, but they are 0.5 and 0.5"),
        (
            f"{CONDITION}.low",
            Free(-1.0, -2.0, 0.6),
            f"{CONDITION}.low",
            "low must be less than high, but they are 0.6 and 0.5",
        ),
        (f"{CONDITION}.blend", Free(0.1, -0.1, 0.2), f"{CONDITION}.blend", "must not be negative, is -0.1"),
        (f"{HFL}.f_max", 0.0, f"{HFL}.f_max", "must be greater than 0"),
        (f"{HFL}.f_max", Free(1.0, 0.0, 2.0), f"{HFL}.f_max", "must be greater than 0"),
        (f"{HFL}.f_max", Free(same_as="controller.pd.lHip.kp", factor=-1.0), f"{HFL}.f_max", "is -20"),
        (f"{HFL}.l_opt", -0.1, f"{HFL}.l_opt", "must be greater than 0"),
        (f"{HFL}.l_slack", -0.1, f"{HFL}.l_slack", "must not be negative"),
        (f"{HFL}.delay", -0.1, f"{HFL}.delay", "must not be negative"),
        (f"{HFL}.delay", 10.0, f"{HFL}.delay", "less than the scene's duration of 10 s, is 10 s"),
        (f"{HFL}.delay", Free(0.1, 0.0, 20.0), f"{HFL}.delay", "duration of 10 s, is 20 s"),
        (f"{HFL}.pennation", -0.1, f"{HFL}.pennation", "must not be negative"),
        (f"{HFL}.pennation", 1.4, f"{HFL}.pennation", "must be less than 1.4 rad"),
        (f"{TFL}.excitation", Excitation([], []), f"{TFL}.excitation.time", "at least one knot"),
        (f"{TFL}.excitation.value", [1.0], f"{TFL}.excitation.value", "1 value for 2 times"),
        (f"{TFL}.excitation.time", [0.5, 0.5], f"{TFL}.excitation.time.1", "times must increase, but 0.5 follows 0.5"),
        (f"{TFL}.excitation.value.1", 1.1, f"{TFL}.excitation.value.1", "must be within 0 and 1, is 1.1"),
        (f"{TFL}.excitation.value.0", Free(0.0, -0.5, 2.0), f"{TFL}.excitation.value.0", "within 0 and 1, is -0.5"),
        (f"{TFL}.excitation.period", -1.0, f"{TFL}.excitation.period", "must not be negative"),
        ("muscle_model.rise_time", 0.0, "muscle_model.rise_time", "must be greater than 0"),
        ("muscle_model.fall_time", -1.0, "muscle_model.fall_time", "must be greater than 0"),
        ("muscle_model.initial_activation", 1.5, "muscle_model.initial_activation", "within 0 and 1, is 1.5"),
        ("muscle_model.v_max", 0.0, "muscle_model.v_max", "must be greater than 0"),
        ("muscle_model.damping", -0.1, "muscle_model.damping", "must not be negative"),
        ("muscle_model", MuscleModel(tendon="compliant", damping=0.0), "muscle_model.damping", "greater than 0"),
        ("muscle_model", MuscleModel(legacy=True, ideal=True), "muscle_model.ideal", "both legacy and ideal"),
        (
            "muscle_model",
            MuscleModel(legacy=True, sharing="least_effort"),
            "muscle_model.sharing",
            "legacy muscles cannot share torques",
        ),
        ("muscle_model", MuscleModel(negative="drop", sharing="least_effort"), "muscle_model.negative", "leave it out"),
        ("muscle_model", MuscleModel(ideal=True, law="legacy"), "muscle_model.law", "cannot be both ideal and legacy"),
        ("muscle_model", MuscleModel(law="legacy", tendon="switch"), "muscle_model.tendon", "leave out `tendon`"),
        ("muscle_model", MuscleModel(legacy=True, tendon="switch"), "muscle_model.tendon", "leave out `tendon`"),
        ("muscle_model", MuscleModel(legacy=True, curves="millard"), "muscle_model.curves", "leave out `curves`"),
        ("actuation.neck", Actuation("torque"), "actuation.neck", "no joint is called 'neck'"),
        ("actuation.lHip", Actuation(["torque"] * 2), "actuation.lHip.drive", "a ball joint takes one word or 3 in a"),
        ("actuation.lToe", Actuation([]), "actuation.lToe.drive", "a hinge joint takes one word or 1 in a list, got 0"),
        ("actuation.rHip", Actuation("muscle"), "actuation.rHip.drive", "no muscle crosses this joint"),
        ("actuation.rHip", Actuation(["none", "none", "assisted"]), "actuation.rHip.drive", "no muscle crosses"),
        ("actuation.rHip.stiffness", -1.0, "actuation.rHip.stiffness", "must not be negative"),
        ("actuation.rHip.damping", -1.0, "actuation.rHip.damping", "must not be negative"),
    ],
)
def test_fault_is_named_by_its_key(key, value, at, message):
    with pytest.raises(SceneError) as caught:
        check_scene(changed(key, value))
    assert caught.value.key == at
    assert message in caught.value.message
    assert "\n" not in str(caught.value)


def test_hips_must_be_joints_of_the_root():
    scene = sound_scene()
    scene.character.joints["rHip"].parent = "lFoot"
    with pytest.raises(SceneError, match=r"controller\.hips\.1: hip 'rHip' must be a joint of the root 'pelvis'"):
        check_scene(scene)


def test_long_loops_are_shown():
    scene = sound_scene()
    scene.character.joints["lHip"].parent, scene.character.joints["rHip"].parent = "rFoot", "lFoot"
    with pytest.raises(SceneError, match="joints make a loop: lFoot -> rFoot -> lFoot"):
        check_scene(scene)


def test_a_followed_number_may_not_follow_another():
    scene = sound_scene()
    scene.controller.pd["root"] = PD(Free(same_as="controller.pd.lHip.kp"), Free(same_as="controller.pd.root.kp"))
    with pytest.raises(SceneError, match="follows another number itself"):
        check_scene(scene)


def test_only_compliant_tendons_need_a_length():
    scene = changed("character.muscles.HFL.l_slack", 0.0)
    check_scene(scene)
    scene.muscle_model.tendon = "compliant"
    with pytest.raises(SceneError, match=r"muscles\.HFL\.l_slack: must be greater than 0"):
        check_scene(scene)


def test_fixed_joints_cannot_be_driven():
    scene = changed("actuation.lToe", Actuation("none"))
    check_scene(scene)
    scene.character.joints["lToe"].type, scene.character.joints["lToe"].axes = "fixed", []
    scene.character.muscles = {}
    with pytest.raises(SceneError, match=r"actuation\.lToe: a fixed joint cannot be driven"):
        check_scene(scene)


def test_a_muscle_drives_what_its_path_or_its_conditions_depend_on():
    scene = changed("actuation.lToe", Actuation(["assisted"]))
    scene.actuation["lHip"] = Actuation(["muscle", "torque", "passive"])
    check_scene(scene)
    scene.character.muscles["TFL"].path[2].body = "lFoot"  # still on a condition of the toes
    check_scene(scene)
    scene.character.muscles["TFL"].path[1].condition = None
    with pytest.raises(SceneError, match="no muscle crosses this joint"):
        check_scene(scene)


# Tendons that are as long as the whole path.


def test_slack_lengths_that_leave_no_fibre_are_named_with_one_that_fits():
    scene = changed("character.muscles.HFL.l_slack", 0.4)  # its path is 0.4 m long
    (warning,) = slack_warnings(scene)
    assert warning.key == "character.muscles.HFL.l_slack"
    assert warning.message == (
        "slack length 0.4 m leaves no fibre in the initial pose, where the path is 0.4 m; 0.2 m would fit "
        "(path minus l_opt)"
    )
    scene.character.muscles["HFL"].l_opt = 0.5
    assert "l_opt 0.5 m alone is as long" in slack_warnings(scene)[0].message
    scene.character.muscles["HFL"].l_slack = Free(0.39, 0.1, 0.5)
    assert slack_warnings(scene) == []


def test_a_fibre_that_is_far_too_short_for_its_path_is_named():
    scene = changed("character.muscles.HFL.l_opt", 2e-4)  # its path is 0.4 m long
    scene.character.muscles["HFL"].l_slack = 0.1
    (warning,) = slack_warnings(scene)
    assert warning.key == "character.muscles.HFL.l_opt"
    assert "stretched to 1.5e+03 times l_opt 0.0002 m" in warning.message
    scene.character.muscles["HFL"].l_opt = 0.04
    assert slack_warnings(scene) == []


@pytest.mark.parametrize("model", [MuscleModel(legacy=True), MuscleModel(ideal=True)])
def test_slack_lengths_do_not_matter_to_muscles_without_bounds_or_fibres(model):
    scene = changed("character.muscles.HFL.l_slack", 1.0)
    assert len(slack_warnings(scene)) == 1
    scene.muscle_model = model
    assert slack_warnings(scene) == []


def test_conditional_points_count_where_their_angle_is_within_the_interval():
    scene = muscle_scene()
    through = initial_path_lengths(scene)["TFL"]
    assert through == pytest.approx(math.hypot(0.2, 0.05) + math.hypot(0.2, 0.15))
    scene.character.muscles["TFL"].path[1].condition.high = -0.5
    assert initial_path_lengths(scene)["TFL"] == pytest.approx(math.hypot(0.4, 0.2))


def test_initial_paths_are_as_long_as_those_of_the_simulation():
    character = biped()
    turn = (0.3, -0.2, 0.1, 0.9)
    ends = ["head", "lLowerarm", "rLowerarm", "lToes", "rToes"]
    far = {
        body: Muscle(path=[HERE, ViaPoint(body, (0.05, 0.02, -0.03))], f_max=1.0, l_opt=0.1, l_slack=0.1)
        for body in ends
    }
    character.muscles = far | {"knee": Muscle(path=points_about_a_knee(), f_max=1.0, l_opt=0.1, l_slack=0.1)}
    joints = {name: JointState(turn) for name in character.joints}
    scene = Scene("lengths", character, initial_state=InitialState((0.0, 1.0, 0.0), turn, joints=joints))
    lengths = Stages(scene, 1, "cpu").muscle_paths().length[0]
    np.testing.assert_allclose(list(initial_path_lengths(scene).values()), lengths, atol=2e-6)


def points_about_a_knee() -> list[ViaPoint]:
    """A path with one point that counts and one that does not, both away from the ends of their intervals."""
    return [
        ViaPoint("lUpperleg", (0.0, 0.1, 0.05)),
        ViaPoint("lUpperleg", (0.0, -0.2, 0.08), Condition("lKnee", -2.0, 2.0)),
        ViaPoint("lLowerleg", (0.0, 0.2, 0.09), Condition("lAnkle", 2.0, 3.0, axis=1)),
        ViaPoint("lLowerleg", (0.0, -0.1, 0.05)),
    ]


def test_numbers_of_numpy_are_numbers():
    check_scene(changed("gravity", np.float64(9.8)))
    check_scene(changed("controller.pd.root.kp", np.float32(9.5)))
    with pytest.raises(SceneError, match="nan is not a finite number"):
        check_scene(changed("gravity", np.float32("nan")))
    with pytest.raises(SceneError):
        check_scene(changed("gravity", np.zeros(3)))


def test_a_sound_scene_is_checked_once_and_again_as_soon_as_anything_is_different(monkeypatch):
    made, whole = [], validation._Check.scene
    monkeypatch.setattr(validation, "_sound", {})
    monkeypatch.setattr(validation._Check, "scene", lambda check: made.append(check) or whole(check))
    scene = sound_scene()
    for _ in range(3):
        validation.check_scene(scene)
        validation.check_scene(copy.deepcopy(scene))
    assert len(made) == 1
    body = next(iter(scene.character.bodies.values()))
    mass, body.mass = body.mass, -1.0
    for _ in range(2):  # what is wrong is not remembered
        with pytest.raises(SceneError, match="mass"):
            validation.check_scene(scene)
    body.mass = np.float64(mass)  # nor what only Python has
    validation.check_scene(scene)
    assert len(made) == 4
    body.mass = mass
    validation.check_scene(scene)
    assert len(made) == 4
    monkeypatch.setitem(LIMITS, "bodies", LIMITS["bodies"]._replace(most=0))
    with pytest.raises(SceneError, match="bodies"):
        validation.check_scene(scene)
    monkeypatch.undo()
    monkeypatch.setattr(validation, "_sound", {})
    monkeypatch.setattr(validation, "SOUND", 2)
    for number in range(5):
        scene.gravity = 9.0 + 0.1 * number
        validation.check_scene(scene)
    assert len(validation._sound) == 2
