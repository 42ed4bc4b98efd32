"""A task to walk: legs that are found, soles that touch the ground, springs that hold, and what is no walker."""

import math

import numpy as np
import pytest

from command_line import run
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, toml
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.geometry import lowest_point
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology
from warpmuscle.scene.validation.damping import mass_matrix
from warpmuscle.walking.legs import find_legs
from warpmuscle.walking.support import springs
from warpmuscle.walking.task import walking_task

TURNED = "rotations = [{ axis = [-1, 0, 0], slope = 1 }, { axis = [0, 1, 0], value = 1.5708 }]"
THIGH, SHANK = 0.4, 0.38  # m


def body(name: str, mass: float, more: str = "") -> str:
    return f"[character.bodies.{name}]\nmass = {mass}\ninertia = [{mass / 50}, {mass / 50}, {mass / 50}]\n{more}"


def joint(name: str, parent: str, child: str, place: tuple[float, float, float], kind: str = "hinge") -> str:
    axes = "axes = [[-1, 0, 0]]\n" if kind == "hinge" else ""
    return (
        f'[character.joints.{name}]\ntype = "{kind}"\nparent = "{parent}"\nchild = "{child}"\n{axes}'
        f"position_in_parent = {list(place)}\nposition_in_child = [0, 0, 0]\n"
    )


def muscle(name: str, *bodies: str) -> str:
    points = ", ".join(f'{{ body = "{one}", position = [0, -0.02, 0.02] }}' for one in bodies)
    return f"[character.muscles.{name}]\npath = [{points}]\nf_max = 1000\nl_opt = 0.1\nl_slack = 0.2\n"


def two_legs(foot: str = "foot", toes: bool = True, ankle_bone: bool = True, root: str = "free") -> str:
    """A pelvis with a trunk on a joint without muscles, an arm that hangs, and two legs whose feet have no shapes."""
    text = [f'name = "legs"\n[character]\nroot = "pelvis"\nroot_joint = "{root}"\n', body("pelvis", 10.0)]
    text += [body("trunk", 30.0), joint("waist", "pelvis", "trunk_base", (0, 0.1, 0)), body("trunk_base", 1.0)]
    text += [joint("chest", "trunk_base", "trunk", (0, 0.3, 0), "fixed")]
    text += [body("arm", 3.0), body("hand", 0.5)]
    text += [joint("shoulder", "trunk", "arm", (0.2, 0.1, 0)), joint("wrist", "arm", "hand", (0, -0.5, 0), "fixed")]
    for side, x in (("l", 0.1), ("r", -0.1)):
        text += [body(f"thigh_{side}", 7.0), body(f"shank_{side}", 3.0), body(f"{foot}_{side}", 1.0)]
        text += [joint(f"hip_{side}", "pelvis", f"thigh_{side}", (x, -0.05, 0))]
        text += [joint(f"knee_{side}", f"thigh_{side}", f"shank_{side}", (0, -THIGH, 0))]
        above = f"shank_{side}"
        if ankle_bone:
            text += [body(f"talus_{side}", 0.2)]
            text += [joint(f"ankle_{side}", above, f"talus_{side}", (0, -SHANK, 0))]
            text += [joint(f"heel_{side}", f"talus_{side}", f"{foot}_{side}", (0, -0.03, -0.04), "fixed")]
        else:
            text += [joint(f"ankle_{side}", above, f"{foot}_{side}", (0, -SHANK, 0))]
        if toes:
            text += [
                body(f"toes_{side}", 0.2),
                joint(f"toe_joint_{side}", f"{foot}_{side}", f"toes_{side}", (0, 0, 0.17)),
            ]
        text += [
            muscle(f"hip_flexor_{side}", "pelvis", f"thigh_{side}"),
            muscle(f"vastus_{side}", f"thigh_{side}", above),
        ]
        text += [muscle(f"soleus_{side}", above, f"{foot}_{side}")]
    return "\n".join(text)


def written(text: str, tmp_path) -> toml.Scene:
    """The scene of the task that the command writes for a model."""
    (tmp_path / "model.toml").write_text(text)
    done = run("walking-task", "model.toml", "-o", "walks.toml", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    return toml.read(tmp_path / "walks.toml")


@pytest.mark.parametrize("toes", [True, False])
@pytest.mark.parametrize("ankle_bone", [True, False])
def test_feet_are_found_below_hip_knee_and_ankle_whatever_they_consist_of(toes: bool, ankle_bone: bool, tmp_path):
    scene = written(two_legs(toes=toes, ankle_bone=ankle_bone), tmp_path)
    assert scene.feet == ("foot_l", "foot_r")
    for side, name in enumerate("lr"):
        assert leg_joints(scene, side) == [f"hip_{name}", f"knee_{name}", f"ankle_{name}"]
    soled = {name for name, part in scene.character.bodies.items() if part.shapes}
    assert soled == {f"{part}_{side}" for side in "lr" for part in (["foot", "toes"] if toes else ["foot"])}


def test_a_leg_is_as_long_as_its_thigh_and_shank():
    left, right = find_legs(toml.loads(two_legs()))
    assert left.length == pytest.approx(THIGH + SHANK)
    assert left.height() == pytest.approx((THIGH + SHANK) / 0.491)  # Winter 2009: 0.245 + 0.246 of the height
    assert (left.toes, right.toes) == ("toes_l", "toes_r")


def test_a_foot_is_as_long_as_a_persons_and_touches_the_ground_at_the_start(tmp_path):
    scene = written(two_legs(toes=False), tmp_path)
    assert lowest_point(scene.character, world_poses(scene)) == pytest.approx(0.0, abs=1e-4)
    box = scene.character.bodies["foot_l"].shapes[0]
    height = (THIGH + SHANK) / 0.491
    assert box.high[2] - box.low[2] == pytest.approx(0.152 * height, abs=1e-3)  # Winter 2009, fig. 4.1
    assert box.high[0] - box.low[0] == pytest.approx(0.055 * height, abs=1e-3)
    assert 0.03 - box.low[1] == pytest.approx(0.039 * height, abs=1e-3)  # the ankle is 3 cm above the foot's origin


def test_feet_that_touch_the_ground_already_keep_their_shapes(tmp_path):
    more = 'shapes = [{ type = "sphere", center = [0, -0.03, 0], radius = 0.02 }]\n'
    text = two_legs(toes=False)
    for side in "lr":
        text = text.replace(body(f"foot_{side}", 1.0), body(f"foot_{side}", 1.0, more))
    scene = written(text, tmp_path)
    assert [shape.radius for shape in scene.character.bodies["foot_r"].shapes] == [0.02]
    assert lowest_point(scene.character, world_poses(scene)) == pytest.approx(0.0, abs=1e-4)


def test_a_spring_that_holds_a_trunk_is_stiffer_than_gravity_and_an_arm_has_little():
    found = springs(toml.loads(two_legs()), find_legs(toml.loads(two_legs())))
    assert set(found) == {"waist", "shoulder", "toe_joint_l", "toe_joint_r"}
    # The trunk of 30 kg is 0.3 m above the waist; the arm's 3 kg hang at a height of 0.1, its hand 0.5 m lower.
    moment = 9.81 * (30.0 * 0.3 + 3.0 * 0.4 - 0.5 * 0.1)
    aside = 9.81 * (3.0 + 0.5) * 0.2
    assert found["waist"].stiffness == pytest.approx(4.0 * math.hypot(moment, aside), rel=0.01)
    assert found["waist"].stiffness > moment
    assert found["shoulder"].stiffness == pytest.approx(0.4 * 9.81 * 0.5 * 0.5, rel=0.01)
    assert all(one.drive == "passive" and one.damping > 0.0 for one in found.values())


def test_speeds_go_with_the_root_of_the_height(tmp_path):
    person = written(two_legs(), tmp_path).learning
    half = two_legs().replace("-0.4, 0]", "-0.1, 0]").replace("-0.38, 0]", "-0.095, 0]")
    small = written(half, tmp_path).learning
    assert person is not None
    assert small is not None
    assert small.speed[1] / person.speed[1] == pytest.approx(0.5, rel=0.01)
    assert small.imitation.cycle_time / person.imitation.cycle_time == pytest.approx(0.5, rel=0.01)
    assert toml.read(tmp_path / "walks.toml").failure.no_progress == pytest.approx(0.15, abs=0.02)


def test_standing_pays_less_than_progress_and_costs_grow(tmp_path):
    task = written(two_legs(), tmp_path).learning
    assert task is not None
    assert task.rewards.progress > task.rewards.alive
    assert task.tightening is not None
    assert task.tightening.costs is not None
    assert task.tightening.costs < 1.0  # where all count at once, who falls soon loses less than who tries


def test_sides_learn_from_each_other_where_they_are_alike_alone(tmp_path):
    assert written(two_legs(), tmp_path).learning.symmetric
    left = muscle("vastus_l", "thigh_l", "shank_l")
    assert not written(two_legs().replace(left, left.replace("1000", "500")), tmp_path).learning.symmetric
    assert walking_task(load("gait2392")).symmetric


def test_a_body_in_a_plane_is_not_asked_for_wide_steps(tmp_path):
    assert written(two_legs(root="planar"), tmp_path).learning.imitation.step_width is None
    assert written(two_legs(), tmp_path).learning.imitation.step_width > 0.0


def test_a_shipped_model_is_taken_by_its_name(tmp_path):
    assert run("walking-task", "gait2392", "-o", "walks.toml", folder=tmp_path).returncode == 0
    scene = toml.read(tmp_path / "walks.toml")
    assert scene.feet == ("calcn_l", "calcn_r")
    assert len(scene.character.muscles) == 92
    poses = world_poses(scene)
    assert np.isclose(lowest_point(scene.character, poses), 0.0, atol=1e-4)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (two_legs(root="fixed"), "character.root_joint: the root is fixed"),
        (two_legs().replace("_r", "_x"), "no body is called one of the left, such as foot_l"),
        (two_legs().split("[character.muscles")[0], "character.muscles: a walk is learnt by muscles"),
        (two_legs().replace(joint("knee_l", "thigh_l", "shank_l", (0, -THIGH, 0)),
                            joint("knee_l", "thigh_l", "shank_l", (0, -THIGH, 0), "fixed")), "'foot_l'"),
    ],
)  # fmt: skip
def test_what_cannot_walk_is_told(text: str, words: str):
    with pytest.raises(SceneError, match=words.replace("(", r"\(")):
        walking_task(toml.loads(text))


def test_a_foot_whose_axes_are_turned_asks_for_shapes():
    ankle = joint("ankle_l", "shank_l", "foot_l", (0, -SHANK, 0))
    turned = ankle.replace("hinge", "coupled").replace("axes = [[-1, 0, 0]]", TURNED)
    leaning = two_legs(toes=False, ankle_bone=False).replace(ankle, turned)
    with pytest.raises(SceneError, match=r"foot_l: its axes are turned by 90 degrees"):
        walking_task(toml.loads(leaning))


def test_files_that_are_no_scene_or_the_model_itself_are_refused(tmp_path):
    (tmp_path / "model.toml").write_text(two_legs())
    for words, told in (
        (("model.osim", "-o", "walks.toml"), "warpmuscle convert model.osim -o model.toml"),
        (("model.toml", "-o", "walks.osim"), "is written as .toml"),
        (("model.toml", "-o", "model.toml"), "is the model itself"),
        (("other.toml", "-o", "walks.toml"), "other.toml"),
    ):
        done = run("walking-task", *words, folder=tmp_path)
        assert done.returncode == 2
        assert told in " ".join(done.stderr.split())
    assert (tmp_path / "model.toml").read_text() == two_legs()


def test_springs_of_toes_too_light_for_explicit_damping_are_implicit(tmp_path):
    (tmp_path / "model.toml").write_text('base = "gait2392"\nname = "model"\n')
    done = run("walking-task", "model.toml", "-o", "walks.toml", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    scene = at_start(toml.read(tmp_path / "walks.toml"))
    matrix, names = mass_matrix(scene), topology(scene.character)
    speed = names.speeds_of(names.body_of_joint("mtp_angle_l")).start
    free = 1.0 / np.linalg.inv(matrix + 1e-9 * matrix.max() * np.eye(len(matrix)))[speed, speed]  # kg m^2, of the toes
    share = scene.time_step * scene.actuation["mtp_angle_l"].damping / free
    assert share > 2.0  # beyond which the speed of an explicit damper grows from step to step
    assert scene.implicit_pd
