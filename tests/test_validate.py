"""What `check_scene` rejects, and the key that it names."""

import copy
import math

import numpy as np
import pytest

from small_scene import ZERO, X, hip, sound_scene
from warpmuscle.errors import SceneError
from warpmuscle.number import Free
from warpmuscle.scene import PD, Body, Curve, JointState, Scene, Trajectory
from warpmuscle.validate import check_scene, trajectory_joints


def changed(key: str, value: object) -> Scene:
    """The small scene with another value at a path; missing members of tables are added."""
    scene = copy.deepcopy(sound_scene())
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


def test_sound_scene_passes():
    check_scene(sound_scene())


def test_trajectories_change_sides_with_the_stance():
    assert trajectory_joints("SWING_Hip") == ("rHip", "lHip")
    assert trajectory_joints("STANCE_Hip") == ("lHip", "rHip")
    assert trajectory_joints("torso_head") == ("torso_head", "torso_head")


STATE = "controller.states.0"
COMPONENT = f"{STATE}.trajectories.SWING_Hip.components.0"


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
        ("controller.start_state", 1, "controller.start_state", "there is no state 1"),
        (f"{STATE}.next", -1, f"{STATE}.next", "there is no state -1"),
        (f"{STATE}.time", 0.0, f"{STATE}.time", "must be greater than 0"),
        (f"{STATE}.trajectories.STANCE_Knee", Trajectory(), f"{STATE}.trajectories.STANCE_Knee", "'lKnee' of this"),
        (f"{STATE}.trajectories.neck", Trajectory(), f"{STATE}.trajectories.neck", "no joint is called 'neck'"),
        (f"{STATE}.balance.velocity_z", Curve([], []), f"{STATE}.balance.velocity_z.phase", "at least one knot"),
        (f"{COMPONENT}.axis", ZERO, f"{COMPONENT}.axis", "no length"),
        (f"{COMPONENT}.angle", [1.0], f"{COMPONENT}.angle", "1 values for 2 phases"),
        (f"{COMPONENT}.phase", [0.5, 0.5], f"{COMPONENT}.phase.1", "phases must increase, but 0.5 follows 0.5"),
        (f"{COMPONENT}.angle.1", math.inf, f"{COMPONENT}.angle.1", "not a finite number"),
        (f"{COMPONENT}.feedback.axis", ZERO, f"{COMPONENT}.feedback.axis", "no length"),
        (f"{COMPONENT}.feedback.d_limits", (1.0, 0.0), f"{COMPONENT}.feedback.d_limits", "greater than high"),
        ("initial_state.root_orientation", (0.0,) * 4, "initial_state.root_orientation", "quaternion has no length"),
        ("initial_state.joints.knee", JointState(), "initial_state.joints.knee", "no joint is called 'knee'"),
        ("ground.normal", ZERO, "ground.normal", "normal has no length"),
        ("ground.stiffness", -1.0, "ground.stiffness", "must not be negative"),
        ("failure.max_speed", 0.0, "failure.max_speed", "must be greater than 0"),
        ("objective.failure_cost", 0.0, "objective.failure_cost", "must be greater than 0"),
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


def test_numbers_of_numpy_are_numbers():
    check_scene(changed("gravity", np.float64(9.8)))
    check_scene(changed("controller.pd.root.kp", np.float32(9.5)))
    with pytest.raises(SceneError, match="nan is not a finite number"):
        check_scene(changed("gravity", np.float32("nan")))
    with pytest.raises(SceneError):
        check_scene(changed("gravity", np.zeros(3)))
