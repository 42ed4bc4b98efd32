"""The exported MJCF as MuJoCo understands it: masses, joints and their order, frames, contacts."""

from pathlib import Path
from xml.etree import ElementTree

import msgspec
import mujoco
import numpy as np
import pytest

from biped import X, Y, Z, biped, breadth_first, forward_kinematics, load_recording, multiply, rotate, xyzw
from mujoco_oracle import accelerations, body_states, compile_model, mass_matrix, state_to_qpos
from random_states import States, body_order, random_states
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, mjcf
from warpmuscle.scene import Body, Capsule, Character, Ground, InitialState, Joint, Scene, Sphere
from warpmuscle.scene.number import Free
from warpmuscle.simulation.stages import Stages

KINDS = ("free", "planar", "fixed")


def chain(kind: str = "universal", axes: tuple = (X, Z), **character) -> Scene:
    """Two bodies and a joint between them."""
    bodies = {"base": Body(2.0, (0.1, 0.1, 0.1), [Sphere((0.0, 0.0, 0.0), 0.1)]), "tip": Body(1.0, (0.02, 0.03, 0.04))}
    joint = Joint(kind, "base", "tip", (0.1, 0.2, 0.3), (0.0, 0.25, 0.05), list(axes), [(-0.5, 0.75)] * len(axes))
    return Scene("chain", Character("base", bodies, {"link": joint}, **character))


def test_biped_keeps_its_mass_and_its_34_degrees_of_freedom():
    model = compile_model(Scene("biped", biped()))
    assert model.body_mass.sum() == pytest.approx(70.4, rel=1e-12)
    assert (model.nv, model.nbody) == (34, 16)
    kinds = [mujoco.mjtJoint(kind).name for kind in model.jnt_type]
    assert [kinds.count(f"mjJNT_{kind}") for kind in ("FREE", "BALL", "HINGE")] == [1, 6, 10]


@pytest.mark.parametrize(("root_joint", "freedoms"), [("free", 6), ("planar", 3), ("fixed", 0)])
def test_root_joint_has_its_degrees_of_freedom(root_joint, freedoms):
    assert compile_model(chain(root_joint=root_joint)).nv == freedoms + 2


@pytest.mark.parametrize(
    ("kind", "axes", "freedoms"), [("ball", (X, Y), 3), ("universal", (X, Z), 2), ("hinge", (Y,), 1), ("fixed", (), 0)]
)
def test_joint_has_its_degrees_of_freedom(kind, axes, freedoms):
    assert compile_model(chain(kind, axes, root_joint="fixed")).nv == freedoms


def test_universal_joint_turns_about_b_of_the_parent_then_a_of_the_child():
    alpha, beta = 0.7, -0.4
    about_x = np.array([np.sin(alpha / 2), 0.0, 0.0, np.cos(alpha / 2)])
    about_z = np.array([0.0, 0.0, np.sin(beta / 2), np.cos(beta / 2)])
    model = compile_model(chain(root_joint="fixed"))
    data = mujoco.MjData(model)
    data.qpos[model.joint("link_a").qposadr[0]] = alpha
    data.qpos[model.joint("link_b").qposadr[0]] = beta
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(xyzw(data.body("tip").xquat), multiply(about_z, about_x), atol=1e-14)


@pytest.mark.parametrize("root_joint", KINDS)
def test_forward_kinematics_and_velocities_agree_with_recursion_over_the_tree(root_joint):
    scene = Scene("biped", biped())
    scene.character.root_joint = root_joint
    states = random_states(scene.character, 4, seed=3)
    position, orientation, _, angular_velocity = body_states(scene, states)
    names = breadth_first(scene.character)
    joints = dict(zip(names, np.moveaxis(states.joint_orientation, 1, 0), strict=True))
    poses = forward_kinematics(scene.character, states.root_position, states.root_orientation, joints)
    speeds = {"pelvis": states.root_angular_velocity}
    for place, name in enumerate(names):
        joint = scene.character.joints[name]
        relative = rotate(poses[joint.parent][1], states.joint_angular_velocity[:, place])
        speeds[joint.child] = speeds[joint.parent] + relative
    for place, name in enumerate(body_order(scene.character)):
        np.testing.assert_allclose(position[:, place], poses[name][0], atol=1e-12)
        np.testing.assert_allclose(np.abs(np.sum(orientation[:, place] * poses[name][1], axis=1)), 1.0, atol=1e-12)
        np.testing.assert_allclose(angular_velocity[:, place], speeds[name], atol=1e-11)


def test_poses_agree_with_the_bodies_of_the_original_program(reference_data: Path):
    path = reference_data / "simbicon/reference/fullrate_bipV2_fWalk.npz"
    scene, recording = Scene("biped", biped()), load_recording(path, biped())
    rows = slice(1, None, 200)
    states = States(*(recording[name][rows] for name in States.__dataclass_fields__))
    position, orientation, velocity, _ = body_states(scene, states)
    with np.load(path) as file:
        columns = [list(file["body_names"]).index(name) for name in body_order(scene.character)]
        np.testing.assert_allclose(position, file["body_pos"][rows, columns], atol=1e-3)
        np.testing.assert_allclose(velocity, file["body_vel"][rows, columns], atol=2e-2)
        cosines = np.sum(orientation * xyzw(file["body_quat"][rows, columns]), axis=-1)
    np.testing.assert_allclose(np.abs(cosines), 1.0, atol=1e-5)


@pytest.mark.parametrize("root_joint", KINDS)
def test_accelerations_are_rates_of_the_velocities(root_joint):
    scene = Scene("biped", biped())
    scene.character.root_joint = root_joint
    states = random_states(scene.character, 1, seed=5)
    torque = np.random.default_rng(5).normal(size=(1, 14, 3)) * 20.0
    found = accelerations(scene, states, torque)
    model, step = compile_model(scene), 1e-6
    qpos, qvel = state_to_qpos(model, scene.character, states, 0)
    rates = []
    for time in (-step, step):
        data = mujoco.MjData(model)
        data.qpos, data.qvel = qpos, qvel + time * found.generalized[0]
        mujoco.mj_integratePos(model, data.qpos, data.qvel, time)
        mujoco.mj_forward(model, data)
        both = np.empty((model.nbody, 6))
        for body in range(model.nbody):
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, both[body], 0)
        rates.append(both[[model.body(name).id for name in body_order(scene.character)]])
    expected = (rates[1] - rates[0]) / (2.0 * step)
    np.testing.assert_allclose(found.angular[0], expected[:, :3], atol=1e-4 * np.abs(expected).max())
    np.testing.assert_allclose(found.linear[0], expected[:, 3:], atol=1e-4 * np.abs(expected).max())


def test_joint_torques_do_not_move_the_common_centre_of_mass():
    scene = Scene("biped", biped())
    states = random_states(scene.character, 3, seed=1)
    torque = np.random.default_rng(1).normal(size=(3, 14, 3)) * 100.0
    masses = np.array([scene.character.bodies[name].mass for name in body_order(scene.character)])
    fall = np.einsum("nbi,b->ni", accelerations(scene, states, torque).linear, masses / masses.sum())
    np.testing.assert_allclose(fall, [[0.0, -9.8, 0.0]] * 3, atol=1e-9)


def test_mass_matrix_gives_the_kinetic_energy_of_the_bodies():
    scene = Scene("biped", biped())
    states = random_states(scene.character, 3, seed=2)
    _, orientation, velocity, angular_velocity = body_states(scene, states)
    bodies = [scene.character.bodies[name] for name in body_order(scene.character)]
    spin = rotate(orientation * [-1.0, -1.0, -1.0, 1.0], angular_velocity)
    inertia, mass = np.array([body.inertia for body in bodies]), np.array([body.mass for body in bodies])
    expected = 0.5 * np.sum(inertia * spin**2, axis=(1, 2)) + 0.5 * np.sum(mass[:, None] * velocity**2, axis=(1, 2))
    model = compile_model(scene)
    qvel = np.array([state_to_qpos(model, scene.character, states, index)[1] for index in range(3)])
    matrices = mass_matrix(scene, states)
    np.testing.assert_allclose(0.5 * np.einsum("ni,nij,nj->n", qvel, matrices, qvel), expected, rtol=1e-12)


def test_bodies_touch_the_ground_but_not_each_other():
    scene = chain("fixed", ())
    scene.character.bodies["tip"].shapes = [Capsule((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), 0.5)]  # wide enough for both
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pairs = {frozenset(model.geom_bodyid[contact.geom].tolist()) for contact in data.contact}
    assert pairs == {frozenset((0, 1)), frozenset((0, 2))}  # bodies


def test_ground_is_a_plane_at_its_height_along_its_normal():
    scene = chain()
    scene.ground = Ground(normal=(0.0, 0.8, 0.6), height=-0.5)
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    ground = data.geom("ground")
    np.testing.assert_allclose(ground.xmat.reshape(3, 3)[:, 2], [0.0, 0.8, 0.6], atol=1e-12)
    np.testing.assert_allclose(ground.xpos, [0.0, -0.4, -0.3], atol=1e-12)


@pytest.mark.parametrize("root_joint", KINDS)
def test_reference_configuration_has_the_initial_pose_of_the_root(root_joint):
    scene = chain(root_joint=root_joint)
    scene.initial_state = InitialState(root_position=(0.0, 1.5, 0.25), heading=0.6)
    model = compile_model(scene)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(data.body("base").xpos, [0.0, 1.5, 0.25], atol=1e-12)
    turn = [0.0, 0.0, 0.0, 1.0] if root_joint == "planar" else [0.0, np.sin(0.3), 0.0, np.cos(0.3)]
    np.testing.assert_allclose(xyzw(data.body("base").xquat), turn, atol=1e-12)


def test_heading_replaces_the_turn_about_the_vertical():
    scene = chain(root_joint="fixed")
    tilted, turned = np.array([np.sin(0.2), 0.0, 0.0, np.cos(0.2)]), np.array([0.0, np.sin(0.5), 0.0, np.cos(0.5)])
    scene.initial_state = InitialState(root_orientation=tuple(multiply(turned, tilted).tolist()), heading=0.0)
    model = compile_model(scene)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(xyzw(data.body("base").xquat), tilted, atol=1e-12)


def test_limits_are_written_on_request_only():
    assert not compile_model(chain()).jnt_limited.any()
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(chain(), limits=True, up="y"))
    np.testing.assert_allclose(model.joint("link_a").range, [-0.5, 0.75])
    ball = chain("ball", (X, Y))
    ball.character.joints["link"].limits = [(-0.5, 0.75), (-0.5, 0.75), (-1.25, 0.1)]
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(ball, limits=True, up="y"))
    np.testing.assert_allclose(model.joint("link").range, [0.0, 1.25])


def test_free_parameters_count_with_their_values():
    scene = chain()
    scene.character.bodies["base"].mass = Free(3.0, 1.0, 5.0)
    scene.character.bodies["tip"].mass = Free(same_as="character.bodies.base.mass")
    assert compile_model(scene).body_mass.sum() == pytest.approx(6.0)


def test_file_holds_the_text_and_a_missing_folder_is_one_clear_error(tmp_path):
    mjcf.write(chain(), tmp_path / "chain.xml")
    assert (tmp_path / "chain.xml").read_text(encoding="utf-8") == mjcf.dumps(chain())
    with pytest.raises(SceneError, match=r"nowhere.chain\.xml: cannot be written: its folder does not exist"):
        mjcf.write(chain(), tmp_path / "nowhere" / "chain.xml")


def test_a_name_that_no_xml_may_hold_leaves_a_file_that_can_be_read():
    text = mjcf.dumps(msgspec.structs.replace(chain(), name="a\x1b[31m \uffff<b>"))
    assert ElementTree.fromstring(text).get("model") == "a\ufffd[31m \ufffd<b>"


@pytest.mark.parametrize("name", ["fwalk", "bigbird_walk"])
def test_keyframe_is_the_initial_state(name):
    scene = load(name)
    model = compile_model(scene)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    ours = Stages(scene, 1, "cpu").forward_kinematics()
    ids = [model.body(body).id for body in body_order(scene.character)]
    np.testing.assert_allclose(data.xpos[ids], ours["position"][0], atol=1e-5)
    mujoco.mj_subtreeVel(model, data)
    np.testing.assert_allclose(data.subtree_linvel[1], ours["com"][0, 1], atol=1e-5)


def mapped(vectors: np.ndarray) -> np.ndarray:
    """Our vectors in a world whose z is up and x forward."""
    return vectors[..., [2, 0, 1]]


@pytest.mark.parametrize("name", ["fwalk", "walk56_person", "planar", "fixed"])
def test_the_world_of_a_file_is_z_up_and_the_same_world(name):
    scene = chain(root_joint=name) if name in KINDS else load(name)
    if name in KINDS:
        scene.initial_state = InitialState(root_position=(0.0, 1.5, 0.25), heading=0.6)
    found = []
    for up in ("y", "z"):
        model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up=up))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        for _ in range(40):
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        turned = data.xmat.reshape(-1, 3, 3)[1:] @ np.array([0.1, 0.2, 0.3])
        normal = data.geom("ground").xmat.reshape(3, 3)[:, 2]
        found.append((data.xpos[1:], turned, data.subtree_linvel[1:], data.site_xpos, model.opt.gravity, normal))
    for ours, theirs in zip(*found, strict=True):
        np.testing.assert_allclose(theirs, mapped(ours), atol=1e-6)
    assert found[1][4][2] == pytest.approx(-scene.gravity)


def test_the_cameras_see_a_walk_from_its_right_and_bones_are_only_drawn():
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(load("walk56_person")))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    side = data.cam("side")
    _, upwards, backwards = side.xmat.reshape(3, 3).T
    np.testing.assert_allclose(-backwards, [0.0, 1.0, 0.0], atol=0.05)  # y is to the left
    np.testing.assert_allclose(upwards, [0.0, 0.0, 1.0], atol=0.05)
    assert side.xpos[1] < data.body("pelvis").xpos[1] - 3.0
    assert model.vis.global_.azimuth == 90.0
    np.testing.assert_allclose(model.stat.center[:2], data.body("pelvis").xpos[:2], atol=0.1)
    drawn = model.geom_contype == 0
    assert drawn.sum() > 14
    assert not model.geom_conaffinity[drawn].any()
    colors = {tuple(color) for color in model.geom_rgba[1:].round(3).tolist()}
    assert len(colors) == 5  # left, right, middle, feet, bones


def test_a_model_of_meshes_is_drawn_by_capsules():
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(chain("fixed", ())))
    capsules = model.geom_type == mujoco.mjtGeom.mjGEOM_CAPSULE
    assert capsules.sum() == 1  # from the joint into the base
    assert model.body_mass.sum() == 3.0
