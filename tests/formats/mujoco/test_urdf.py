"""A URDF's skeleton is read as MuJoCo compiles it; meshes and programmes in it are left out, errors are one line."""

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

import warpmuscle as wm  # noqa: E402
from warpmuscle.core.errors import SceneError  # noqa: E402
from warpmuscle.formats import Ignored, load  # noqa: E402
from warpmuscle.studies.inverse_dynamics import inverse_dynamics  # noqa: E402


def link(name: str, mass: str, moments: str, more: str = "") -> str:
    x, y, z = moments.split()
    inertia = f'<mass value="{mass}"/><inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/>'
    return f'<link name="{name}"><inertial><origin xyz="0 0.01 -0.1"/>{inertia}</inertial>{more}</link>'


def joint(name: str, kind: str, parent: str, child: str, more: str) -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{more}</joint>\n'


MESH = '<geometry><mesh filename="package://robot/arm.dae"/></geometry>'
ARM = f"""<?xml version="1.0"?>
<!-- made by -- a converter -->
<robot name="arm">
<link name="base"/>
{link("upper", "1", "0.01 0.01 0.002", f"<visual>{MESH}</visual><collision>{MESH}</collision>")}
{link("fore", "0.7", "0.006 0.006 0.001", '<collision><geometry><sphere radius="0.03"/></geometry></collision>')}
{link("finger", "0.1", "1e-4 1e-4 1e-4")}
{joint("shoulder", "continuous", "base", "upper", '<origin xyz="0 0 1"/><axis xyz="0 1 0"/><dynamics damping="0.1"/>')}
{
    joint(
        "elbow",
        "revolute",
        "upper",
        "fore",
        '<origin xyz="0 0 -0.3" rpy="0.1 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="2.5" effort="10" velocity="3"/>',
    )
}
{
    joint(
        "grip",
        "prismatic",
        "fore",
        "finger",
        '<origin xyz="0 0 -0.25"/><axis xyz="1 0 0"/><limit lower="0" upper="0.1"'
        ' effort="5" velocity="1"/><mimic joint="elbow" multiplier="0.02" offset="0.01"/>',
    )
}
<transmission name="t"><actuator name="m"/></transmission>
<gazebo><plugin name="p" filename="lib.so"/></gazebo> <sensor:camera name="c"/>
<link name="camera"><inertial><mass value="0"/></inertial></link>
{joint("mount", "fixed", "finger", "camera", "")}
</robot>"""


def written(folder: Path, text: str) -> Path:
    path = folder / "arm.urdf"
    path.write_text(text)
    return path


def test_a_skeleton_moves_as_in_mujoco(tmp_path: Path):
    ignored: list[Ignored] = []
    scene = load(written(tmp_path, ARM), ignored=ignored)
    joints = scene.character.joints
    assert {name: one.type for name, one in joints.items()} == {
        "shoulder": "hinge",
        "elbow": "hinge",
        "grip": "coupled",
    }
    assert (joints["grip"].follows, joints["elbow"].limits, joints["shoulder"].limits) == ("elbow", [(0.0, 2.5)], [])
    assert float(joints["shoulder"].damping) == 0.1
    plain = ARM.replace(MESH, "").replace("<visual></visual>", "").replace("<collision></collision>", "")
    model = mujoco.MjModel.from_xml_string(plain[: plain.index("<transmission")] + "</robot>")
    data = mujoco.MjData(model)
    data.qpos[:] = 0.4, 0.9, 0.01 + 0.02 * 0.9
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    along = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.02]])
    at, still = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.4, 0.9]]), np.zeros((1, 2))
    gravity = inverse_dynamics(scene, at, still, still)
    mass = np.concatenate([inverse_dynamics(scene, at, still, one[None]) - gravity for one in np.eye(2)])
    np.testing.assert_allclose(mass, along.T @ full @ along, rtol=1e-9)
    np.testing.assert_allclose(gravity[0], along.T @ data.qfrc_bias, rtol=1e-9)


def test_a_joint_that_an_older_mujoco_would_leave_free_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def without_mimics(text: str) -> Any:
        """As MuJoCo 3 reads it."""
        return mujoco.MjModel.from_xml_string(re.sub("<mimic[^>]*>", "", text))

    old = SimpleNamespace(**vars(mujoco) | {"MjModel": SimpleNamespace(from_xml_string=without_mimics)})
    monkeypatch.setattr("warpmuscle.formats.mujoco.compiled.mujoco_package", lambda: old)
    with pytest.raises(SceneError, match=r"arm\.urdf: joint 'grip' mimics another, which MuJoCo \S+ does not know"):
        load(written(tmp_path, ARM))


def test_a_floating_base_is_the_root(tmp_path: Path):
    floats = joint("float", "floating", "world", "trunk", "")
    scene = load(
        written(tmp_path, f'<robot name="r"><link name="world"/>{link("trunk", "2", "1 1 1")}{floats}</robot>')
    )
    assert (scene.character.root, scene.character.root_joint) == ("trunk", "free")
    assert scene.gravity == pytest.approx(9.81)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco/>", "a URDF begins with <robot>, not <mujoco>"), ("<robot", "not sound XML"),
        ("<!DOCTYPE a><robot/>", "a model has no document type"),
        ("<robot>" + "<a>" * 60 + "</a>" * 60 + "</robot>", "the limit `nesting`"),
        (ARM.replace('"elbow" multiplier', '"knee" multiplier'), "joint 'grip' mimics 'knee', which is not a joint"),
        (ARM.replace('value="0.7"', 'value="x"'), "MuJoCo cannot compile it"),
        ('<robot name="r"><link name="a"/></robot>', "nothing in it moves|cannot compile"),
    ],
)  # fmt: skip
def test_what_is_no_skeleton_is_refused_in_one_line(tmp_path: Path, text: str, message: str):
    with pytest.raises(SceneError, match=message) as error:
        wm.load(written(tmp_path, text))
    assert "\n" not in str(error.value)
