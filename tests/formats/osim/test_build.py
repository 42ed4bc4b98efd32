"""Scenes of OpenSim models: their bodies are where the models' joints and OpenSim itself put them."""

import copy
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import osim_models as small
from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import about, rotate
from warpmuscle.formats import Ignored, load, save
from warpmuscle.formats.osim.frames import turned
from warpmuscle.formats.osim.functions import Function
from warpmuscle.formats.osim.placement import WORLD
from warpmuscle.scene import JointState, Scene
from warpmuscle.scene.initial_pose import initial_pose
from warpmuscle.scene.opensim_root import root_motion

X, Y, Z = np.eye(3)
QUIET = pytest.mark.filterwarnings("ignore")
# Centres of mass, m, in OpenSim's axes, computed by OpenSim 4.6 with the coordinates below (other ones 0, or coupled).
PELVIS = {"pelvis_tilt": 0.1, "pelvis_list": -0.2, "pelvis_rotation": 0.3, "pelvis_tx": 0.4, "pelvis_ty": 1.0,
    "pelvis_tz": -0.3, "hip_flexion_r": 0.5, "hip_adduction_r": -0.3, "hip_rotation_r": 0.2, "ankle_angle_r": 0.2,
    "subtalar_angle_r": 0.1, "lumbar_extension": -0.2, "lumbar_bending": 0.1, "lumbar_rotation": 0.3}  # fmt: skip
ARM = {"arm_flex_r": 0.4, "arm_add_r": -0.5, "arm_rot_r": 0.3, "elbow_flex_r": 1.0, "pro_sup_r": 0.6}
FLAT = {"pelvis_tilt": 0.1, "pelvis_tx": 0.4, "pelvis_ty": 1.0, "hip_flexion_r": 0.5, "knee_angle_r": -0.9,
    "ankle_angle_r": 0.2, "lumbar_extension": -0.2}  # fmt: skip
SHARED = {
    "Rajagopal2016": ({**PELVIS, **ARM, "knee_angle_r": 0.9}, {
        "toes_r": (0.668854942, 0.25127799, 0.126053481), "patella_r": (0.653691862, 0.635352233, -0.078013419),
        "hand_r": (0.801039116, 1.051736994, -0.261703845)}),
    "gait2392_thelen2003muscle": ({**PELVIS, "knee_angle_r": -0.9, "mtp_angle_r": 0.2}, {
        "toes_r": (0.664952316, 0.258627578, 0.169358307), "torso": (0.309391329, 1.394962625, -0.321944269)}),
    "arm26": ({"r_shoulder_elev": 0.7, "r_elbow_flex": 1.2}, {
        "r_ulna_radius_hand": (0.345692001, 0.631871061, 0.15579004)}),
    "gait10dof18musc": (FLAT, {
        "toes_r": (0.599803312, 0.13119428, 0.075), "torso": (0.293763225, 1.39243595, 0.0)}),
}  # fmt: skip


def scene_of(folder: Path, text: str) -> Scene:
    return load(small.written(folder, text), ignored=[])


def centers(scene: Scene, values: Mapping[str, float]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Centre of mass, m, and axes (3, 3) of every body in the world where coordinates have these values, others 0."""
    posed = copy.deepcopy(scene)
    posed.initial_state.joints = {}
    for name, joint in posed.character.joints.items():
        if joint.type == "hinge":
            turn = tuple(map(float, about(np.array(joint.axes[0]), values.get(name, 0.0))))
            posed.initial_state.joints[name] = JointState(turn)
        elif joint.type != "fixed" and not joint.follows:
            posed.initial_state.joints[name] = JointState(coordinate=values.get(name, 0.0))
    assert scene.opensim is not None
    root = root_motion(scene.opensim, np.array([[values.get(name, 0.0) for name in scene.opensim.root_coordinates]]))
    poses, _ = initial_pose(posed)
    axes = rotate(root.orientation[0], np.eye(3)).T
    return {
        name: (root.position[0] + axes @ place, axes @ rotate(turn, np.eye(3)).T)
        for name, (place, turn) in poses.items()
    }


@pytest.mark.parametrize("name", SHARED)
@QUIET
def test_bodies_of_well_known_models_are_where_opensim_has_them(reference_data: Path, name: str):
    values, places = SHARED[name]
    path = reference_data / "opensim_models" / f"{name}.osim"
    if not path.is_file():
        pytest.skip(f"no model {path}")
    found = centers(load(path, ignored=[]), values)
    for body, place in places.items():
        np.testing.assert_allclose(found[body][0], WORLD @ place, atol=2e-9, err_msg=body)


@pytest.mark.parametrize(
    ("kind", "turns", "shifts"),
    [
        ("PinJoint", [Z], []), ("SliderJoint", [], [X]), ("UniversalJoint", [X, Y], []),
        ("GimbalJoint", [X, Y, Z], []), ("BallJoint", [X, Y, Z], []), ("FreeJoint", [X, Y, Z], [X, Y, Z]),
        ("PlanarJoint", [Z], [X, Y]), ("WeldJoint", [], []),
    ],
)  # fmt: skip
@pytest.mark.parametrize("held", [False, True])
@QUIET
def test_joints_of_every_kind_carry_their_bodies(tmp_path: Path, kind: str, turns: list, shifts: list, held: bool):
    names = [f"q{k}" for k in range(len(turns) + len(shifts))]
    values = {name: 0.3 + 0.2 * k for k, name in enumerate(names)}
    place, turn, own, own_turn = "0.1 0.2 0.3", "0.3 -0.2 0.5", "-0.2 0.1 0.4", "0.6 0.1 -0.4"
    coordinates = "".join(map(small.coordinate, names))
    joint = small.joint(kind, "j", "ground", "rod", coordinates, "", place, turn, own, own_turn)
    bodies = small.body("rod", center="0.05 -0.3 0.02")
    if held:  # by a body that something else is fixed to, so that the ground is a body
        joint = small.joint("WeldJoint", "w", "ground", "base") + joint.replace("/ground", "/bodyset/base")
        bodies = small.body("base") + bodies
    found = centers(scene_of(tmp_path, small.model(bodies, joint)), values)

    def numbers(text: str) -> list[float]:
        return [float(word) for word in text.split()]

    axes, origin = turned(numbers(turn)), np.array(numbers(place))
    moved = sum((np.array(axis) * values[f"q{len(turns) + k}"] for k, axis in enumerate(shifts)), np.zeros(3))
    origin = origin + axes @ moved
    for k, axis in enumerate(turns):
        axes = axes @ rotate(about(axis, values[f"q{k}"]), np.eye(3)).T
    axes = axes @ turned(numbers(own_turn)).T
    center = origin + axes @ (np.array([0.05, -0.3, 0.02]) - np.array(numbers(own)))
    np.testing.assert_allclose(found["rod"][0], WORLD @ center, atol=1e-14)


def test_functions_of_one_coordinate_make_one_coupled_joint(tmp_path: Path):
    knots = small.spline("SimmSpline", "-1 0 1 2", "0 0.1 0.3 0.2")
    broken = small.spline("PiecewiseLinearFunction", "-1 0 1", "0 0.1 0.3")
    square = '<PolynomialFunction name="function"><coefficients>3 2 1</coefficients></PolynomialFunction>'
    transform = small.axes(
        rotation1=("q", "0 0 1", small.LINE), rotation2=("q", "0 1 0", square), translation1=("q", "1 0 0", knots),
        translation2=("q", "0 1 0", broken),
        translation3=("", "0 0 1", '<Constant name="f"><value>2</value></Constant>'),
    )  # fmt: skip
    text = small.model(
        small.body("rod"), small.joint("CustomJoint", "knee", "ground", "rod", small.coordinate("q"), transform)
    )
    scene = scene_of(tmp_path, text)
    (joint,) = scene.character.joints.values()
    assert (joint.type, joint.parent, joint.position_in_parent) == ("coupled", "ground", (-2.0, 0.0, 0.0))
    assert [d.axis for d in joint.rotations] == [(-1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    assert joint.rotations[1].polynomial == [1.0, 2.0, 3.0]
    assert [d.ends for d in joint.translations] == ["simm", "linear"]
    assert joint.limits == [(-2.0, 2.0)]
    assert joint.limit_stiffness == 0.0


def test_several_coordinates_make_a_row_through_bodies_without_mass(tmp_path: Path):
    transform = small.axes(
        rotation1=("a", "0 0 1", small.LINE), rotation2=("b", "1 0 0", small.LINE),
        rotation3=("c", "0 1 0", small.LINE), translation2=("y", "0 1 0", small.LINE),
    )  # fmt: skip
    coordinates = "".join(small.coordinate(name) for name in "abcy")
    scene = scene_of(
        tmp_path,
        small.model(small.body("rod"), small.joint("CustomJoint", "hip", "ground", "rod", coordinates, transform)),
    )
    joints = scene.character.joints
    assert list(joints) == ["y", "a", "b", "c"]
    assert [joint.type for joint in joints.values()] == ["slide", "hinge", "hinge", "hinge"]
    assert [joint.child for joint in joints.values()] == ["rod_y", "rod_a", "rod_b", "rod"]
    assert [scene.character.bodies[f"rod_{name}"].mass for name in "yab"] == [0.0] * 3


def test_a_coordinate_that_follows_another_one_has_a_joint_without_one(tmp_path: Path):
    """As a patella; what follows within one joint is no coordinate at all."""
    kneecap = small.axes(rotation1=("beta", "0 0 1", small.LINE), translation1=("beta", "1 0 0", small.LINE))
    knee = small.axes(rotation1=("q", "0 0 1", small.LINE), translation1=("x", "1 0 0", small.LINE))
    bodies = small.body("thigh") + small.body("shank") + small.body("patella")
    joints = (
        small.joint("WeldJoint", "hip", "ground", "thigh")
        + small.joint("CustomJoint", "knee", "thigh", "shank", small.coordinate("q") + small.coordinate("x"), knee)
        + small.joint("CustomJoint", "cap", "thigh", "patella", small.coordinate("beta"), kneecap)
    )
    scene = scene_of(tmp_path, small.model(bodies, joints, more=couplers(("beta", "x", "2 0.1"), ("x", "q", "0.5 0"))))
    character = scene.character
    assert list(character.joints) == ["hip", "q", "beta"]
    assert character.joints["q"].translations[0].slope == 0.5
    assert character.joints["beta"].follows == "q"
    assert (character.joints["beta"].rotations[0].value, character.joints["beta"].rotations[0].slope) == (0.1, 1.0)
    assert scene.opensim is not None
    lines = {name: (one.joint, one.slope, one.value) for name, one in scene.opensim.couplers.items()}
    assert lines == {"beta": ("q", 1.0, 0.1), "x": ("q", 0.5, 0.0)}


def couplers(*which: tuple[str, str, str]) -> str:
    """Linear couplers: dependent, independent coordinate, slope and offset."""
    inner = "".join(
        f'<CoordinateCouplerConstraint name="of {first}"><coupled_coordinates_function><LinearFunction><coefficients>'
        f"{line}</coefficients></LinearFunction></coupled_coordinates_function><independent_coordinate_names>{second}"
        f"</independent_coordinate_names><dependent_coordinate_name>{first}</dependent_coordinate_name>"
        "</CoordinateCouplerConstraint>\n"
        for first, second, line in which
    )
    return f"<ConstraintSet><objects>{inner}</objects></ConstraintSet>"


def test_locked_coordinates_are_folded_in_and_prescribed_ones_move_as_they_should(tmp_path: Path):
    line = "<LinearFunction><coefficients>0.1 0.2</coefficients></LinearFunction>"
    coordinates = (
        small.coordinate("a", "<locked>true</locked><default_value>0.5</default_value>")
        + small.coordinate("b", f"<prescribed>true</prescribed><prescribed_function>{line}</prescribed_function>")
        + small.coordinate("c", "<default_value>0.3</default_value><default_speed_value>2</default_speed_value>")
    )
    scene = scene_of(
        tmp_path, small.model(small.body("rod"), small.joint("GimbalJoint", "j", "ground", "rod", coordinates))
    )
    assert list(scene.character.joints) == ["b", "c"]
    assert scene.opensim is not None
    assert scene.opensim.locked == {"a": 0.5}
    np.testing.assert_allclose(scene.character.joints["b"].axes[0], WORLD @ turned([0.5, 0.0, 0.0]) @ Y)
    motion = scene.motion["b"]
    np.testing.assert_allclose(motion.value, 0.2 + 0.1 * np.array(motion.time))
    assert scene.actuation["b"].drive == "kinematic"
    np.testing.assert_allclose(np.linalg.norm(scene.initial_state.joints["c"].angular_velocity), 2.0)


def test_a_prescribed_spline_keeps_its_accelerations(tmp_path: Path):
    """Knots of a motion are close enough together for a spline whose third derivative jumps."""
    knots = ((0.0, 0.1, 0.2, 0.4, 0.6, 1.0), (0.1, 0.15, 0.4, 0.5, 0.3, 0.0))
    x, y = (" ".join(map(str, values)) for values in knots)
    function = small.spline("SimmSpline", x, y)
    more = f"<prescribed>true</prescribed><prescribed_function>{function}</prescribed_function>"
    scene = scene_of(tmp_path, small.pendulum().replace("<range>-2 2</range>", f"<range>-2 2</range>{more}"))
    motion = scene.motion["q"]
    spline = make_interp_spline(motion.time, motion.value, k=5)
    expected, times = Function(x=knots[0], y=knots[1]), np.linspace(0.01, 0.99, 500)
    small_time = 1e-4
    before, at, after = (expected.values(times + shift) for shift in (-small_time, 0.0, small_time))
    acceleration = (after - 2.0 * at + before) / small_time**2
    np.testing.assert_allclose(spline(times), at, atol=1e-6)
    np.testing.assert_allclose(spline(times, 2), acceleration, atol=0.01 * np.abs(acceleration).max())


def test_inertia_keeps_its_axes(tmp_path: Path):
    text = small.pendulum().replace("1 2 2 0 0 0", "2 3 4 0.1 -0.2 0.3")
    scene = scene_of(tmp_path, text)
    body = scene.character.bodies["rod"]
    axes = rotate(np.array(body.inertia_axes), np.eye(3)).T
    matrix = WORLD @ np.array([[2.0, 0.1, -0.2], [0.1, 3.0, 0.3], [-0.2, 0.3, 4.0]]) @ WORLD.T
    np.testing.assert_allclose(axes @ np.diag(body.inertia) @ axes.T, matrix, atol=1e-14)


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (
            small.joint("PinJoint", "p", "ground", "a", small.coordinate("q"))
            + small.joint("PinJoint", "r", "a", "b", small.coordinate("r"))
            + small.joint("WeldJoint", "s", "b", "b"), "joint 's' is from a body to itself",
        ),
        (
            small.joint("CustomJoint", "p", "ground", "a", small.coordinate("q"),
                small.axes(rotation1=("bend", "0 0 1", small.LINE))), "'bend' is none of the joint's: q",
        ),
        (
            small.joint("PlanarJoint", "p", "ground", "a", small.coordinate("q")),
            "has 1 coordinate, a joint of its class 3; name all of them, or none",
        ),
    ],
)  # fmt: skip
def test_a_skeleton_that_cannot_be_represented_is_refused_with_its_line(tmp_path: Path, joints: str, message: str):
    path = small.written(tmp_path, small.model(small.body("a") + small.body("b"), joints))
    with pytest.raises(SceneError) as caught:
        load(path)
    assert message in caught.value.message
    assert caught.value.file == path
    assert caught.value.line > 6


@pytest.mark.parametrize(
    ("coordinate", "function", "reason"),
    [
        (small.coordinate("q"), small.spline("SimmSpline", "0.1", "0.2"), "no axis turns or moves with it"),
        (small.coordinate("q").replace("-2 2", "2 -2"), small.LINE, "range runs down from 2 to -2"),
        (small.coordinate("q", "<default_value>7</default_value>"), small.LINE, "starts at 7, outside of its range"),
    ],
)
def test_odd_coordinates_are_told_with_their_line(tmp_path: Path, coordinate: str, function: str, reason: str):
    joint = small.joint("CustomJoint", "j", "ground", "rod", coordinate, small.axes(rotation1=("q", "0 0 1", function)))
    ignored: list[Ignored] = []
    load(small.written(tmp_path, small.model(small.body("rod"), joint)), ignored=ignored)
    (note,) = [note for note in ignored if note.text == "Coordinate q"]
    assert reason in note.reason
    assert note.line == 9


def test_joints_may_lead_from_the_child_to_the_parent(tmp_path: Path):
    """As OpenSim allows: the tree begins at the ground whichever way a joint is written."""
    transform = small.axes(rotation1=("q", "0 0 1", small.LINE), translation1=("x", "1 0 0", small.LINE))
    joint = small.joint(
        "CustomJoint", "j", "rod", "ground", small.coordinate("q") + small.coordinate("x"), transform, "0 0.2 0",
        "0 0 0", "0.1 0 0", "0 0 0.2",
    )  # fmt: skip
    found = centers(scene_of(tmp_path, small.model(small.body("rod"), joint)), {"q": 0.4, "x": 0.3})
    turn = turned([0.0, 0.0, 0.2]) @ turned([0.0, 0.0, 0.4]).T
    center = np.array([0.1, 0.0, 0.0]) + turn @ -np.array([0.3, 0.2, 0.0])
    np.testing.assert_allclose(found["rod"][0], WORLD @ center, atol=1e-14)


@QUIET
def test_a_body_without_a_joint_is_free_and_the_scene_is_written_and_read_back(tmp_path: Path):
    scene = scene_of(tmp_path, small.model(small.body("rod"), ""))
    assert scene.character.root_joint == "free"
    assert scene.opensim is not None
    assert scene.opensim.root_coordinates == [f"free_rod_coord_{k}" for k in range(6)]
    save(scene, tmp_path / "again.toml")
    assert load(tmp_path / "again.toml") == scene


@QUIET
def test_a_coordinate_that_moves_a_joint_before_and_after_another_one_makes_two_joints(tmp_path: Path):
    transform = small.axes(
        rotation1=("q", "0 0 1", small.LINE), rotation2=("r", "0 1 0", small.LINE), rotation3=("q", "1 0 0", small.LINE)
    )
    joint = small.joint("CustomJoint", "j", "ground", "rod", small.coordinate("q") + small.coordinate("r"), transform)
    scene = scene_of(tmp_path, small.model(small.body("rod", center="0.05 -0.3 0.02"), joint))
    assert {name: one.follows for name, one in scene.character.joints.items()} == {"q": "", "r": "", "q_2": "q"}
    found, values = centers(scene, {"q": 0.4, "r": -0.7}), (0.4, -0.7, 0.4)
    axes = np.eye(3)
    for axis, value in zip((Z, Y, X), values, strict=True):
        axes = axes @ rotate(about(axis, value), np.eye(3)).T
    np.testing.assert_allclose(found["rod"][0], WORLD @ axes @ [0.05, -0.3, 0.02], atol=1e-14)
