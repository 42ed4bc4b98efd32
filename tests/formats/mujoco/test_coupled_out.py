"""Coupled joints written for MuJoCo: where bodies are, how long tendons, and what is refused."""

import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.core.pose import rotate
from warpmuscle.formats import load, mjcf
from warpmuscle.scene import Body, Character, Displacement, Joint, JointState, Scene
from warpmuscle.scene.initial_pose import world_poses

sys.path.insert(0, str(Path(__file__).parent))
from small_models import ARM

ORIGIN, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BOWED = Displacement((0.6, 0.0, 0.8), polynomial=[0.02, 0.1, -0.05, 0.03, 0.01])


def knee(**change: list[Displacement]) -> Scene:
    """A shank that turns and moves by its knee's angle, and a patella that follows it."""
    bodies = {name: Body(1.0, (0.1, 0.2, 0.3)) for name in ("thigh", "shank", "patella", "foot")}
    own = {"rotations": [Displacement(X, slope=-1.0), BOWED], "translations": [BOWED, Displacement(Y, 0.03)]} | change
    joints = {
        "knee": Joint("coupled", "thigh", "shank", (0.0, -0.2, 0.0), (0.01, 0.2, 0.02), **own),
        "cap": Joint("coupled", "thigh", "patella", (0.0, -0.2, 0.03), (0.0, 0.01, -0.02), rotations=[BOWED],
            translations=[Displacement(Z, 0.01, 0.2)], follows="knee"),
        "ankle": Joint("hinge", "shank", "foot", (0.0, -0.2, 0.0), (0.0, 0.1, -0.1), [X]),
    }  # fmt: skip
    scene = Scene("knee", Character("thigh", bodies, joints, "fixed"))
    scene.initial_state.joints["knee"] = JointState(coordinate=0.7, speed=1.5)
    return scene


@pytest.mark.parametrize("angle", [0.7, -0.4, 1.2])
def test_bodies_are_where_they_start_and_the_equalities_hold(angle: float):
    scene = knee()
    scene.initial_state.joints["knee"] = JointState(coordinate=angle, speed=1.5)
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    data.qpos, data.qvel = model.key_qpos[0], model.key_qvel[0]
    mujoco.mj_forward(model, data)
    for name, (place, turn) in world_poses(scene).items():
        number = model.body(name).id
        np.testing.assert_allclose(data.xpos[number], place, atol=1e-9)
        np.testing.assert_allclose(data.xmat[number].reshape(3, 3), rotate(turn, np.eye(3)).T, atol=1e-9)
    assert model.neq == 5
    assert data.ne == 5
    np.testing.assert_allclose(data.efc_pos[:5], 0.0, atol=1e-9)
    np.testing.assert_allclose(data.efc_vel[:5], 0.0, atol=1e-9)


def test_a_model_of_mujoco_comes_back_with_its_couplings_and_paths(tmp_path: Path):
    kept = [line for line in ARM.splitlines() if not any(word in line for word in ('"belt"', '"flexor"'))]
    file = tmp_path / "arm.xml"
    file.write_text("\n".join(kept))
    scene = load(file, ignored=[])
    first = mujoco.MjModel.from_xml_path(str(file))
    again = mujoco.MjModel.from_xml_string(mjcf.dumps(scene))
    one, other = mujoco.MjData(first), mujoco.MjData(again)
    equality = {first.joint(int(first.eq_obj1id[k])).name: first.eq_data[k, :5] for k in range(first.neq)}
    for row in np.random.default_rng(3).uniform(-0.8, 0.8, (20, 4)):
        values = dict(zip(("flexion", "rotation", "elbow", "wrist"), row, strict=True))
        values |= {name: np.polynomial.Polynomial(c)(values["elbow"]) for name, c in equality.items()}
        for model, data in ((first, one), (again, other)):
            for number in range(model.njnt):
                name = model.joint(number).name
                data.qpos[model.jnt_qposadr[number]] = values[name.partition("_")[0]]
            mujoco.mj_forward(model, data)
            np.testing.assert_allclose(data.efc_pos[: data.ne], 0.0, atol=1e-9)
        for name in ("front", "back", "hole", "strap"):
            assert other.tendon(name).length == pytest.approx(one.tendon(name).length, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rotations": [BOWED], "translations": []}, "one turn or shift is the coordinate itself"),
        ({"translations": [Displacement(X, x=[-1.0, 0.0, 0.5, 1.0], y=[0.0, 0.3, -0.2, 0.1])]}, "miss this function"),
    ],
)
def test_what_mujoco_cannot_hold_is_refused(change: dict[str, list[Displacement]], said: str):
    with pytest.raises(SceneError, match=said):
        mjcf.dumps(knee(**change))
