"""Models of Hyfydy: bodies, joints, muscles and contact in our axes, and what is refused with its line."""

import math
from pathlib import Path

import numpy as np
import pytest

import small_scone
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.scone.model import Options, read_model, sphere_stiffness
from warpmuscle.formats.scone.start import put_start
from warpmuscle.formats.scone.zml import parse
from warpmuscle.scene import Force, Scene
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.masses import body_mass


def read(folder: Path, text: str = small_scone.MODEL) -> Scene:
    (folder / "pair.hfd").write_text(text)
    return load(folder / "pair.hfd", ignored=[])


def refused(folder: Path, old: str, new: str) -> str:
    assert old in small_scone.MODEL
    with pytest.raises(SceneError) as caught:
        read(folder, small_scone.MODEL.replace(old, new, 1))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_bodies_and_joints_come_in_our_axes(tmp_path: Path):
    scene = read(tmp_path)
    character = scene.character
    assert (character.root, character.root_joint) == ("trunk", "planar")
    assert list(character.bodies) == ["trunk", "leg_r", "foot_r", "leg_l", "foot_l"]
    trunk, hip = character.bodies["trunk"], character.joints["thigh_l"]
    assert trunk.inertia == (1.5, 1.0, 2.0)  # about the left, up, and forward
    assert (hip.type, hip.parent, hip.child) == ("hinge", "trunk", "leg_l")
    assert hip.axes == [(-1.0, 0.0, 0.0)]
    assert hip.position_in_parent == (0.1, -0.3, 0.0)
    assert character.joints["foot_r"].position_in_child == (0.0, 0.04, -0.05)
    assert scene.gravity == 9.81
    assert scene.ground.normal == (0.0, 1.0, 0.0)


def test_a_positive_angle_turns_x_towards_y_as_in_the_model(tmp_path: Path):
    path = small_scone.write(tmp_path)
    scene = load(path, ignored=[])
    poses = world_poses(_plain(scene))
    hip = np.array([-0.1, -0.3, 0.0])
    leg = np.array(poses["leg_r"][0]) - np.array(poses["trunk"][0])
    tilt, thigh = -0.05, 0.35  # of the start
    x = 0.3 * math.sin(tilt) + 0.4 * math.sin(tilt + thigh)  # forward, of the leg's centre before the trunk's
    y = -0.3 * math.cos(tilt) - 0.4 * math.cos(tilt + thigh)
    np.testing.assert_allclose(leg, [hip[0], y, x], atol=1e-6)


def _plain(scene: Scene) -> Scene:
    from warpmuscle.scene.parameters import start_values, substitute

    return substitute(scene, start_values(scene))


def about(axis: str, angle: float) -> np.ndarray:
    """The matrix of a turn about x, y or z of the model, in its axes."""
    c, s, k = math.cos(angle), math.sin(angle), "xyz".index(axis)
    turn = np.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return turn


def test_a_joint_about_three_axes_and_a_free_root_turn_about_z_x_and_y(tmp_path: Path):
    # In the model's axes: forward, up, right; ours are left, up, forward.
    bent = small_scone.MODEL.replace(
        "limits { x = 0..0 y = 0..0 z = -60..90 }", "limits { x = -20..30 z = -60..90 }", 1
    )
    root = "dof { name = list source = trunk_rx } dof { name = heading source = trunk_ry } dof { name = spread"
    bent = bent.replace("dof { name = trunk_y", f"{root} source = -hip_rx_r }} dof {{ name = trunk_y", 1)
    (tmp_path / "pair.hfd").write_text(bent)
    found = read_model(parse(tmp_path / "pair.hfd", Notes()), Notes())
    scene, joints = found.scene, found.scene.character.joints
    assert scene.character.root_joint == "free"
    chain = [(joints[name].parent, joints[name].child) for name in ("thigh_r", "spread", "hip_r_y")]
    assert chain == [("trunk", "leg_r_z"), ("leg_r_z", "leg_r_x"), ("leg_r_x", "leg_r")]
    assert body_mass(scene.character) == pytest.approx(body_mass(read(tmp_path).character))
    degree = math.pi / 180.0
    assert scene.forces["spread_limit"].parameters["low"] == pytest.approx(-30 * degree)  # its sense is the other way
    assert "hip_r_y_limit" not in scene.forces
    values = {"tilt": 0.2, "list": -0.15, "heading": 0.4, "thigh_r": 0.5, "spread": 0.3, "trunk_y": 1.0}
    put_start(scene, found.coordinates, values, {})
    poses = world_poses(_plain(scene))
    trunk = about("z", 0.2) @ about("x", -0.15) @ about("y", 0.4)
    leg = trunk @ about("z", 0.5) @ about("x", -0.3)
    hip = np.array([0.0, -0.3, 0.1])  # its place in the trunk
    expected = np.array([0.0, 1.0, 0.0]) + trunk @ hip - leg @ [0.0, 0.4, 0.0]
    x, y, z = np.asarray(poses["leg_r"][0])  # ours
    np.testing.assert_allclose((z, y, -x), expected, atol=1e-6)


def test_in_three_dimensions_joints_give_about_axes_that_their_limits_close(tmp_path: Path):
    """Hyfydy's manual, joint_force_pnld: beyond either end, here the same one, the torque is -k (angle - end)."""
    free = small_scone.MODEL.replace("source = trunk_rz }", "source = trunk_rz } dof { name = list source = trunk_rx }")
    scene = read(tmp_path, free)
    joints = scene.character.joints
    assert [joints[name].child for name in ("foot_l", "ankle_l_x", "ankle_l_y")] == ["foot_l_z", "foot_l_x", "foot_l"]
    closed = {"low": 0.0, "high": 0.0, "stiffness": 200.0, "damping": 2.0}
    assert scene.forces["ankle_l_x_limit"].parameters == closed
    assert scene.forces["hip_r_y_limit"].parameters["stiffness"] == 500.0
    assert list(read(tmp_path).character.joints) == ["thigh_r", "foot_r", "thigh_l", "foot_l"]  # in the plane
    stiff = free.replace("joint_limit_stiffness = 500", "").replace("limit_stiffness = 200 limit_damping = 2", "")
    assert list(read(tmp_path, stiff).character.joints) == ["thigh_r", "foot_r", "thigh_l", "foot_l"]


def test_muscles_and_limits_have_the_laws_of_hyfydy(tmp_path: Path):
    scene = read(tmp_path)
    calf, common = scene.character.muscles["calf_l"], scene.muscle_model
    assert (calf.f_max, calf.l_opt, calf.l_slack, calf.pennation) == (3000.0, 0.06, 0.3, 0.3)
    assert [point.position for point in calf.path] == [(0.0, -0.05, -0.02), (0.0, 0.0, -0.1)]
    assert (common.curves, common.tendon, common.activation) == ("hyfydy", "compliant", "excited")
    assert (common.rise_time, common.fall_time, common.v_max, common.damping) == (0.01, 0.04, 10.0, 0.1)
    degree = math.pi / 180.0
    limits = {"low": -40 * degree, "high": 30 * degree, "stiffness": 200.0, "damping": 2.0}
    assert scene.forces["foot_l_limit"] == Force("range_limit", joint="foot_l", parameters=limits)
    assert scene.forces["thigh_r_limit"].parameters["stiffness"] == 500.0  # of all joints of the model


def test_spheres_push_as_hyfydy_says_by_the_law_of_opensim(tmp_path: Path):
    # F = (k d)^(3/2) with k of both sides 6000/2, against 4/3 sqrt(R) (E^(2/3)/2 d)^(3/2).
    (heel, toe) = read(tmp_path).character.bodies["foot_r"].shapes
    assert heel.material is not None
    assert heel.material.viscous_friction == 0.0
    depth, stiffness = 0.01, float(heel.material.stiffness)
    pushed = 4.0 / 3.0 * math.sqrt(0.03) * (0.5 * stiffness ** (2.0 / 3.0) * depth) ** 1.5
    assert pushed == pytest.approx((3000.0 * depth) ** 1.5, rel=1e-12)
    # What the published models have for the same spheres in both formats: 5975.21, and 2e6 N/m^2 in OpenSim.
    assert sphere_stiffness(5975.21, 0.03) == pytest.approx(2.0e6, rel=2e-6)
    assert toe.center == (0.0, -0.02, 0.08)
    assert toe.material == heel.material


def test_options_of_a_scenario_change_muscles_and_friction(tmp_path: Path):
    (tmp_path / "pair.hfd").write_text(small_scone.MODEL)
    options = Options(transition_velocity=0.2, damping=0.05, v_max=12.0, activation_rate=50.0, deactivation_rate=20.0)
    scene = read_model(parse(tmp_path / "pair.hfd", Notes()), Notes(), options).scene
    common = scene.muscle_model
    assert (common.rise_time, common.fall_time, common.v_max, common.damping) == (0.02, 0.05, 12.0, 0.05)
    material = scene.character.bodies["foot_l"].shapes[0].material
    assert material is not None
    assert material.transition_velocity == 0.2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass = 40", "mas = 40", "pair.hfd:5: body: there is no `mass` in it"),
        ("mass = 40", "mass = 40 colour = 3", "colour: not known in `body`"),
        ("parent = trunk", "parent = tronk", "there is no body 'tronk' to hang on"),
        ("parent = trunk", "parent = foot_r", "its bodies hang on each other in a circle"),
        ("z = -60..90", "z = 90..-60", "runs down from 90 to -60"),
        ("z = -60..90", "z = 60", "'60' is not a range such as -40..120"),
        ("source = trunk_rz", "source = trunk", "'trunk' is not the turn or shift of a body"),
        ("type = sphere", "type = torus", "a torus on 'foot_r' is not known here"),
        ("{ body = leg_r", "{ body = log_r", "there is no body 'log_r'"),
        ("stiffness = 6000", "stiffness = -1", "its stiffness must not be negative"),
        ("max_isometric_force = 3000", "max_isometric_force = lots", "'lots' is not a number"),
        ("optimal_fiber_length = 0.06", "optimal_fiber_length = -0.06", "pair.hfd:26: character.muscles.calf_r.l_opt"),
        ("name = calf_r", "name = seat_r", "two are called 'seat_r'"),
        ("mass = 40", "mass = 40 ori { z = 5 }", "bodies that are turned"),
        ("body { name = trunk", "body { name = belt mass = 0 } body { name = trunk", "'belt' has no mass and hangs on"),
        ("model {", "modle {", "there is no SimulationObjective in it, nor a model of Hyfydy"),
    ],
)
def test_what_is_not_known_is_named_with_its_line(tmp_path: Path, old: str, new: str, said: str):
    assert said in refused(tmp_path, old, new)
