"""Scenes from models of MuJoCo do what MuJoCo's own do: paths, moment arms, forces, accelerations, starts."""

import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
sys.path.append(str(Path(__file__).parent))

from mujoco_ours import computed  # noqa: E402
from mujoco_poses import Oracle, Poses  # noqa: E402
from small_models import ARM, HOPPER  # noqa: E402

import warpmuscle as wm  # noqa: E402
from warpmuscle.core.errors import SceneError  # noqa: E402
from warpmuscle.formats import Ignored, load, mjcf  # noqa: E402
from warpmuscle.scene.validation.scene import check_scene  # noqa: E402

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


def saved(folder: Path, text: str, name: str = "model.xml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def compared(tmp_path_factory) -> dict[str, tuple[Poses, tuple[np.ndarray, ...]]]:
    """By name of a model what MuJoCo and a scene of it compute."""
    folder = tmp_path_factory.mktemp("models")
    found = {}
    for name, text in (("arm", ARM), ("hopper", HOPPER)):
        path = saved(folder, text, f"{name}.xml")
        poses = Oracle(path).poses(40, 3)
        found[name] = poses, computed(load(path, ignored=[]), poses)
    return found


@pytest.mark.parametrize("name", ["arm", "hopper"])
def test_paths_and_moment_arms_are_those_of_mujoco(name: str, compared):
    theirs, (length, speed, arm, _, _) = compared[name]
    np.testing.assert_allclose(length, theirs.length, atol=1e-6)
    np.testing.assert_allclose(speed, theirs.speed, atol=2e-5)
    np.testing.assert_allclose(arm, theirs.arm, atol=2e-6)


@pytest.mark.parametrize("name", ["arm", "hopper"])
def test_forces_and_accelerations_are_those_of_mujoco(name: str, compared):
    theirs, (_, _, _, force, acceleration) = compared[name]
    np.testing.assert_allclose(force, theirs.force, atol=2e-4 * np.abs(theirs.force).max())
    most = np.abs(theirs.acceleration).max(axis=0)
    np.testing.assert_allclose(acceleration / most, theirs.acceleration / most, atol=2e-4)


def test_a_joint_that_follows_brings_its_rotor_and_its_drag_along(tmp_path: Path, compared):
    """Without them accelerations are others: the comparison above sees them."""
    scene = load(saved(tmp_path, ARM), ignored=[])
    for name in ("shift", "twist"):
        assert scene.character.joints[name].follows == "elbow"
        scene.character.joints[name].armature = scene.character.joints[name].damping = 0.0
    theirs = compared["arm"][0]
    off = np.abs(computed(scene, theirs)[4] - theirs.acceleration).max(axis=0)
    assert off[theirs.names.index("elbow")] > 0.05 * np.abs(theirs.acceleration[:, theirs.names.index("elbow")]).max()


def test_a_scene_starts_where_the_first_keyframe_is(tmp_path: Path):
    path = saved(tmp_path, HOPPER)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    scene = load(path, ignored=[])
    assert scene.character.root == "base"
    trunk = [model.body(name).id for name in ("base", "trunk", "pelvis")]
    center = np.average(data.xipos[trunk], axis=0, weights=model.body_mass[trunk])
    np.testing.assert_allclose(scene.initial_state.root_position, center[[1, 2, 0]], atol=1e-12)
    rollout = wm.Rollout(scene, 1, "cpu")
    names = list(rollout.names.joints)
    q = rollout.state.coordinates.numpy()[0, 7:]
    np.testing.assert_allclose([q[names.index("hip")], q[names.index("ankle")]], [0.25, 0.1], atol=1e-6)
    both = np.empty(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, model.body("base").id, both, 0)
    lever = center - data.xpos[model.body("base").id]
    np.testing.assert_allclose(scene.initial_state.root_angular_velocity, both[[1, 2, 0]], atol=1e-12)
    velocity = both[3:] + np.cross(both[:3], lever)
    np.testing.assert_allclose(scene.initial_state.root_velocity, velocity[[1, 2, 0]], atol=1e-12)


def test_shapes_touch_the_floor_where_they_are_spheres_and_capsules_and_the_rest_is_noted(tmp_path: Path):
    lost: list[Ignored] = []
    scene = load(saved(tmp_path, HOPPER), ignored=lost)
    assert scene.ground.height == pytest.approx(-0.1)
    foot = scene.character.bodies["foot"]
    assert [type(shape).__name__ for shape in foot.shapes] == ["Sphere"]
    assert foot.friction == pytest.approx(0.6)
    assert len(scene.character.bodies["leg"].shapes) == 1
    assert ("body foot", "1 geom of it touches nothing: only spheres, capsules and upright boxes do") in [
        (one.text, one.reason) for one in lost
    ]


def test_what_is_written_is_read_as_it_was(tmp_path: Path):
    scene = load(saved(tmp_path, HOPPER), ignored=[])
    again = load(saved(tmp_path, mjcf.dumps(scene), "again.xml"), ignored=[])
    first, second = (one.character.muscles["long"] for one in (scene, again))
    for field in ("f_max", "l_opt", "l_slack"):
        assert getattr(second, field) == pytest.approx(getattr(first, field), rel=1e-9), field
    assert again.character.joints["hip"].armature == pytest.approx(0.01)
    assert again.character.joints["ankle"].damping == pytest.approx(0.3)
    assert again.muscle_model.curve_shape == scene.muscle_model.curve_shape
    places = [one.character.joints["ankle"].position_in_child for one in (again, scene)]  # in axes that differ
    np.testing.assert_allclose(*(np.linalg.norm(place) for place in places), rtol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "what", "reason"),
    [
        ('damping="0.3"', 'damping="0.3" frictionloss="0.1"', "joint ankle", "friction has no effect"),
        (
            "<keyframe>",
            '<equality><weld body1="foot"/></equality><keyframe>',
            "equality equality0",
            "holds exactly",
        ),
        ("<actuator>", '<actuator><motor name="m" tendon="long"/>', "actuator m", "is no muscle; it is left out"),
        ("<actuator>", '<actuator><motor name="m" joint="hip"/>', "actuator", "controls of m stay as they are"),
        ('<spatial name="long">', '<spatial name="long" range="0 1">', "tendon long", "limits have no effect"),
        ("<worldbody>", '<option density="1"/><worldbody>', "option", "of a medium have no effect"),
    ],
)
def test_what_a_scene_cannot_hold_is_noted(tmp_path: Path, old: str, new: str, what: str, reason: str):
    assert old in HOPPER
    lost: list[Ignored] = []
    load(saved(tmp_path, HOPPER.replace(old, new, 1)), ignored=lost)
    assert [one.text for one in lost if reason in one.reason] == [what]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "<worldbody>",
            '<option gravity="1 0 -9"/><worldbody>',
            "gravity must point along -z, or along -y, not along 1 0 -9",
        ),
        (
            "<keyframe>",
            '<equality><joint joint1="hip" joint2="ankle"/><joint joint1="ankle" joint2="hip"/></equality><keyframe>',
            "which follows another one itself",
        ),
        (
            "<keyframe>",
            '<equality><joint joint1="hip" joint2="ankle"/><joint joint1="hip" joint2="ankle"/></equality><keyframe>',
            "two equalities hold the joint 'hip'",
        ),
    ],
)
def test_what_cannot_be_represented_is_said_in_one_line(tmp_path: Path, old: str, new: str, message: str):
    path = saved(tmp_path, HOPPER.replace(old, new, 1))
    with pytest.raises(SceneError, match=message) as error:
        load(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_mocap_bodies_stay_and_bodies_may_be_as_small_as_a_fly(tmp_path: Path):
    """A target of a task is such a body, with what is welded to it."""
    target = '<body name="target" mocap="true"><geom size=".1"/><body pos="1 0 0"><geom size=".1"/></body></body>'
    leg = '<body name="leg"><joint name="hip" axis="0 1 0" actuatorfrcrange="-1 1"/>'
    leg += '<inertial pos="0 0 -1e-3" mass="1e-7" diaginertia="2e-14 2e-14 1e-14"/>'
    ignored: list[Ignored] = []
    motor = '<actuator><motor name="m" joint="hip"/></actuator>'
    path = saved(tmp_path, f"<mujoco><worldbody>{target}{leg}</body></worldbody>{motor}</mujoco>")
    scene = load(path, ignored=ignored)
    assert list(scene.character.joints) == ["hip"]
    assert set(scene.character.bodies) == {"ground", "leg"}
    reasons = [one.reason for one in ignored]
    assert "a mocap body stays where it is here" in reasons
    assert "the greatest force of its actuators (actuatorfrcrange) has no effect here" in reasons
    check_scene(scene)
    scene.character.bodies["leg"].inertia = (1e-19, 1e-19, 1e-19)
    with pytest.raises(SceneError, match=r"leg\.inertia\.0: must be at least 1e-18"):
        check_scene(scene)


OTHER_PASSIVE = """<general name="front" tendon="front" dyntype="muscle" gaintype="muscle" biastype="muscle"
    dynprm="0.01 0.04" gainprm="0.6 1.4 500 200 0.4 1.7 1.5 1.3 1.2" biasprm="0.3 1.9 300 200 0.4 1.5 1.5 1.6 1.2"
    ctrlrange="0 1" lengthrange="0.3 0.6"/>"""  # as MyoSim's supraspinatus, whose bias has numbers of its own


def test_the_passive_force_may_have_another_range_and_strength_than_the_active_one(tmp_path: Path):
    usual = (
        '<muscle name="front" tendon="front" force="500" range="0.6 1.4" lengthrange="0.3 0.6" lmin="0.4" lmax="1.7"/>'
    )
    assert usual in ARM
    path = saved(tmp_path, ARM.replace(usual, OTHER_PASSIVE))
    theirs, ignored = Oracle(path).poses(40, 3), []
    scene = load(path, ignored=ignored)
    assert not [one for one in ignored if "front" in str(one)]
    force, acceleration = computed(scene, theirs)[3:]
    np.testing.assert_allclose(force, theirs.force, atol=2e-4 * np.abs(theirs.force).max())
    most = np.abs(theirs.acceleration).max(axis=0)
    np.testing.assert_allclose(acceleration / most, theirs.acceleration / most, atol=2e-4)
    for name in [name for name, muscle in scene.character.muscles.items() if muscle.polynomial is not None]:
        del scene.character.muscles[name]  # of which a file of MuJoCo has none
        scene.actuation.pop(name, None)
    again = mujoco.MjModel.from_xml_path(str(saved(tmp_path, mjcf.dumps(scene), "again.xml")))
    first = mujoco.MjModel.from_xml_path(str(path))
    for length in np.linspace(0.2, 0.7, 51):
        found = [
            f(length, *speed, m.actuator("front").lengthrange, 1.0, prm[:9])
            for m in (first, again)
            for f, speed, prm in (
                (mujoco.mju_muscleGain, (-0.1 * 0.5625 / m.actuator("front").gainprm[6],), m.actuator("front").gainprm),
                (mujoco.mju_muscleBias, (), m.actuator("front").biasprm),
            )
        ]
        np.testing.assert_allclose(found[2:], found[:2], atol=1e-3)
