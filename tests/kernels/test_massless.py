"""Joints in a row through massless bodies, and turned axes of inertia, against MuJoCo in double precision."""

import copy
import itertools

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.formats import mjcf
from warpmuscle.scene import Body, Character, Failure, Joint, Muscle, Scene, Sphere, ViaPoint
from warpmuscle.scene.topology import topology
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

NOTHING = Body(0.0, (0.0, 0.0, 0.0))
AXES = {"tx": (0.9, 0.1, 0.0), "flex": (1.0, 0.1, -0.2), "tilt": (0.1, 0.2, 1.0), "turn": (0.2, 1.0, 0.1)}


def scene_of(root_joint: str = "fixed") -> Scene:
    """A thigh on a slide and three hinges through massless bodies, which do not meet, and a shank."""
    thigh = Body(2.0, (0.03, 0.01, 0.02), inertia_axes=(0.3, -0.5, 0.2, 0.8))
    shank = Body(1.5, (0.02, 0.012, 0.03), inertia_axes=(0.0, 0.1, 0.7, -0.4))
    bodies = {"pelvis": Body(4.0, (0.1, 0.2, 0.3)), **{f"thigh_{name}": NOTHING for name in ("tx", "flex", "tilt")}}
    bodies |= {"thigh": thigh, "shank": shank}
    chain = ["pelvis", "thigh_tx", "thigh_flex", "thigh_tilt", "thigh"]
    places = [((0.1, -0.2, 0.05), (0.0, 0.03, 0.0)), ((0.0, 0.01, 0.0), (0.02, 0.0, 0.01))] * 2
    joints = {
        name: Joint("slide" if name == "tx" else "hinge", *pair, *place, [axis])
        for (name, axis), pair, place in zip(AXES.items(), itertools.pairwise(chain), places, strict=True)
    }
    joints["knee"] = Joint("hinge", "thigh", "shank", (0.0, -0.2, 0.02), (0.01, 0.2, 0.0), [(1.0, 0.0, 0.1)])
    return Scene("leg", Character("pelvis", bodies, joints, root_joint), failure=Failure(com_height=0.0, heading=0.0))


def in_mujoco(scene: Scene, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrices and accelerations (n, S), ours being of the joints, then the root's velocity in world axes."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    free = scene.character.root_joint == "free"
    matrices, rates = [], []
    for own_q, own_v in zip(q, v, strict=True):
        data = mujoco.MjData(model)
        data.qpos[7 * free :], data.qvel[6 * free :] = own_q[7:], own_v[6 * free :]
        if free:
            data.qpos[:7] = [*own_q[:3], own_q[6], *own_q[3:6]]
            data.qvel[:6] = [*own_v[:3], *rotate(own_q[3:7] * [-1, -1, -1, 1], own_v[3:6])]
        mujoco.mj_forward(model, data)
        matrix = np.empty((model.nv, model.nv))
        for column, unit in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, matrix[column], unit)
        matrices.append(matrix)
        rate = data.qacc.copy()
        if free:
            rate[3:6] = rotate(own_q[3:7], rate[3:6])  # w' is the same vector in both frames
        rates.append(rate)
    return np.array(matrices), np.array(rates)


def states(scene: Scene, count: int = 8) -> tuple[np.ndarray, np.ndarray]:
    rng, names = np.random.default_rng(7), topology(scene.character)
    q, v = rng.uniform(-1.0, 1.0, (count, names.coordinates)), rng.normal(size=(count, names.speeds))
    q[:, 3:7] = normalized(q[:, 3:7]) if scene.character.root_joint == "free" else [0.0, 0.0, 0.0, 1.0]
    q[:, :3] *= scene.character.root_joint == "free"
    return q, v * 2.0


@pytest.mark.parametrize("root_joint", ["fixed", "free"])
def test_joints_through_massless_bodies_are_several_joints_of_one_body(root_joint: str):
    scene = scene_of(root_joint)
    q, v = states(scene)
    matrices, rates = in_mujoco(scene, q, v)
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    found = stages.forward_dynamics()["speed_rate"]
    np.testing.assert_allclose(found, rates, atol=3e-5 * np.abs(rates).max())
    joints = slice(6 * (root_joint == "free"), None)
    np.testing.assert_allclose(stages.mass_matrix()[:, joints, joints], matrices[:, joints, joints], atol=2e-6)
    np.testing.assert_allclose(inverse_dynamics(scene, q, v, rates), 0.0, atol=1e-10)
    plain = copy.deepcopy(scene)
    for body in plain.character.bodies.values():
        body.inertia_axes = (0.0, 0.0, 0.0, 1.0)
    assert np.abs(inverse_dynamics(plain, q, v, rates)).max() > 0.01


def test_a_body_without_mass_that_is_held_fast_may_bear_points_of_muscles_in_mujoco():
    """As the base of OpenSim's arm26 does, from which its triceps comes."""
    scene = scene_of()
    character, place, own = scene.character, (0.1, -0.1, 0.0), (0.0, 0.1, -0.05)
    joints = {"base": Joint("fixed", "pelvis", "base", place, own), **character.joints}
    joints["tx"] = msgspec.structs.replace(joints["tx"], parent="base")
    muscle = Muscle(path=[ViaPoint("base", (0.0, 0.1, 0.0)), ViaPoint("shank", own)], f_max=1.0, l_opt=0.1, l_slack=0.1)
    bodies = character.bodies | {"base": NOTHING}
    scene.character = msgspec.structs.replace(character, bodies=bodies, joints=joints, muscles={"one": muscle})
    q, v = states(scene, 3)
    matrices, _ = in_mujoco(scene, q, v)
    stages = Stages(scene, len(q), "cpu")
    stages.state.coordinates.assign(q.astype(np.float32))
    stages.state.speeds.assign(v.astype(np.float32))
    stages.forward_dynamics()
    np.testing.assert_allclose(stages.mass_matrix(), matrices, atol=2e-6)


def test_the_step_moves_them_as_its_stages_do():
    scene = scene_of()
    q, v = states(scene, 3)
    _, rates = in_mujoco(scene, q, v)
    rollout = Rollout(scene, 3, "cpu")
    rollout.state.coordinates.assign(q.astype(np.float32))
    rollout.state.speeds.assign(v.astype(np.float32))
    rollout.step(1)
    np.testing.assert_allclose(rollout.state.accelerations.numpy(), rates, atol=3e-5 * np.abs(rates).max())


def test_what_mujoco_does_not_know_is_refused_in_a_sentence():
    scene = scene_of()
    character = scene.character
    point = ViaPoint("thigh_flex", (0.0, 0.1, 0.0))
    path = [ViaPoint("pelvis", (0.0, 0.1, 0.0)), point]
    character.muscles["odd"] = Muscle(path=path, f_max=1.0, l_opt=0.1, l_slack=0.1)
    with pytest.raises(SceneError, match="'thigh_flex' has no mass, so that MuJoCo knows no such body"):
        mjcf.dumps(scene)
    character.muscles.clear()
    character.bodies["thigh_flex"] = Body(0.0, (0.0, 0.0, 0.0), [Sphere((0.0, 0.0, 0.0), 0.1)])
    with pytest.raises(SceneError, match="only with one joint on it and no shapes") as caught:
        mjcf.dumps(scene)
    assert caught.value.key == "character.bodies.thigh_flex.mass"
