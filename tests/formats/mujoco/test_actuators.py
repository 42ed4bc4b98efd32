"""Motors and servos on joints have the efforts of MuJoCo's, at any control, coordinate and speed."""

from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

from warpmuscle.formats import Ignored, load  # noqa: E402
from warpmuscle.scene.expressions.parse import evaluate, parse  # noqa: E402

ROBOT = """<mujoco>
  <worldbody><body name="arm"><inertial pos="0 0 -0.2" mass="1" diaginertia="0.1 0.1 0.1"/>
    <joint name="turn" axis="0 1 0"/>
    <body name="rod" pos="0 0 -0.4"><inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="push" type="slide" axis="0 0 1"/></body></body></worldbody>
  <actuator>
    <motor name="motor" joint="turn" gear="-3" ctrllimited="true" ctrlrange="-0.5 2"/>
    <position name="servo" joint="push" kp="40" kv="3" gear="1.5" forcelimited="true" forcerange="-60 90"/>
    <velocity name="speed" joint="turn" kv="7"/>
    <general name="general" joint="push" gainprm="5" biastype="affine" biasprm="1 -2 -3"/>
    <general name="slow" joint="push" dyntype="filter" dynprm="0.1"/>
  </actuator>
  <keyframe><key name="start" ctrl="0.8 0.3 -0.4 0.5 0"/></keyframe>
</mujoco>"""


def test_efforts_are_those_of_mujoco(tmp_path: Path):
    path = tmp_path / "robot.xml"
    path.write_text(ROBOT)
    lost: list[Ignored] = []
    scene = load(path, ignored=lost)
    assert list(scene.forces) == ["motor", "servo", "speed", "general"]
    model = mujoco.MjModel.from_xml_path(str(path))
    data, rng = mujoco.MjData(model), np.random.default_rng(1)
    bounded = 0
    for _ in range(50):
        data.qpos[:], data.qvel[:] = rng.uniform(-1.0, 1.0, (2, 2))
        controls = rng.uniform(-3.0, 3.0, 5)
        controls[0] = np.clip(controls[0], -0.5, 2.0)
        data.ctrl[:] = controls
        mujoco.mj_forward(model, data)
        for k, (name, force) in enumerate(scene.forces.items()):
            joint = model.joint(force.joint).id
            program = parse(force.expressions["effort"], ("q", "qdot", "t"), force.curves)
            own = {"control": lambda t, u=controls[k]: u}
            found = evaluate(program, {"q": data.qpos[joint], "qdot": data.qvel[joint], "t": 0.0}, own)
            expected = data.actuator_force[k] * model.actuator_gear[k, 0]
            assert float(found) == pytest.approx(expected, rel=1e-9, abs=1e-12), name
            bounded += name == "servo" and data.actuator_force[k] in (-60.0, 90.0)
    assert 5 < bounded < 45  # the limits of the servo's force count in some
    assert [force.curves["control"].y[0] for force in scene.forces.values()] == [0.8, 0.3, -0.4, 0.5]
    assert any(one.text == "actuator slow" and "is no muscle" in one.reason for one in lost)
