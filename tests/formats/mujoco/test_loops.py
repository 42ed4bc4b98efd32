"""Connections and welds hold what MuJoCo's do, and scenes start where they are met."""

from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")

from warpmuscle.formats import Ignored, load  # noqa: E402
from warpmuscle.formats.mujoco.reference import Z_UP  # noqa: E402
from warpmuscle.scene.constraints.pose import constraint_errors, start_coordinates  # noqa: E402
from warpmuscle.scene.topology import topology  # noqa: E402

MASS = '<inertial pos="0 0 -0.1" mass="1" diaginertia="0.01 0.01 0.01"/>'
BARS = f"""<mujoco>
  <worldbody>
    <body name="left" pos="0 0 1" euler="0 15 0">{MASS}<joint name="a" axis="0 1 0"/>
      <body name="bar" pos="0 0 -0.4" euler="0 -80 0">{MASS}<joint name="b" axis="0 1 0"/>
        <site name="end" pos="0 0.02 -0.6"/></body></body>
    <body name="right" pos="0.7 0 1">{MASS}<joint name="c" axis="0 1 0"/><site name="hook" pos="0 0.02 -0.5"/></body>
  </worldbody>
  <equality>EQUALITY</equality>
</mujoco>"""


def loaded(folder: Path, equality: str, bars: str = BARS):
    path = folder / "bars.xml"
    path.write_text(bars.replace("EQUALITY", equality))
    lost: list[Ignored] = []
    return load(path, ignored=lost), mujoco.MjModel.from_xml_path(str(path)), [one.reason for one in lost]


@pytest.mark.parametrize(
    "equality",
    [
        '<connect name="loop" body1="bar" body2="right" anchor="0.01 0.02 -0.5"/>',
        '<connect name="loop" site1="end" site2="hook"/>',
        '<weld name="loop" body1="bar" body2="right" anchor="0.1 0 -0.2"/>',
    ],
)
def test_places_that_miss_each_other_are_those_of_mujoco(tmp_path: Path, equality: str):
    scene, model, _ = loaded(tmp_path, equality)
    assert list(scene.character.constraints) == ["loop"]
    data, names = mujoco.MjData(model), topology(scene.character)
    data.qpos[:] = (0.3, -0.2, 0.15)
    mujoco.mj_forward(model, data)
    q = start_coordinates(scene, names)
    for name, value in zip("abc", data.qpos, strict=True):
        q[0, names.coordinate_start[names.body_of_joint(name)]] = value
    found = constraint_errors(scene.character, names, q)[0]
    np.testing.assert_allclose(found[:3], Z_UP @ data.efc_pos[:3], atol=1e-9)
    if "weld" in equality:  # MuJoCo has the vector of a quaternion, about the second body's axes
        assert np.linalg.norm(found[3:]) == pytest.approx(2.0 * np.linalg.norm(data.efc_pos[3:6]), rel=1e-6)


def test_a_scene_starts_where_its_loops_are_closed_and_says_so(tmp_path: Path):
    scene, _, reasons = loaded(tmp_path, '<connect name="loop" site1="end" site2="hook"/>')
    names = topology(scene.character)
    errors = constraint_errors(scene.character, names, start_coordinates(scene, names))
    assert np.abs(errors).max() < 1e-9
    assert any("starts where constraints are met" in reason for reason in reasons)
    assert any("MuJoCo's gives way" in reason for reason in reasons)


def test_what_cannot_be_met_holds_nothing_and_is_told(tmp_path: Path):
    far = BARS.replace('name="right" pos="0.7 0 1"', 'name="right" pos="9 0 1"')
    scene, _, reasons = loaded(tmp_path, '<connect name="loop" site1="end" site2="hook"/>', far)
    assert not scene.character.constraints
    assert any("cannot be met near the pose" in reason for reason in reasons)
