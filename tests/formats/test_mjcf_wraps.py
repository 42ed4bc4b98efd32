"""Tendons of MuJoCo that go round the surfaces of muscles are as long as our paths."""

import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.formats import mjcf
from warpmuscle.scene import CylinderSurface, EllipsoidSurface, Scene, SphereSurface, Surface, ViaPoint, Wrap
from warpmuscle.simulation.stages import Stages

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

TURN = (0.0, np.pi / 2.0, 0.0)  # z axis along the body's x axis
SURFACES: dict[str, Surface] = {
    "cylinder": CylinderSurface("base", (0.0, 0.0, 0.0), 0.05, 0.4, orientation=TURN),
    "sphere": SphereSurface("base", (0.0, 0.0, 0.0), 0.05),
    "cylinder on a side": CylinderSurface("base", (0.0, 0.0, 0.0), 0.05, 0.4, orientation=TURN, side="-x"),
}


def wrapped(surface: Surface) -> Scene:
    """An arm whose flexor runs over a surface in the middle of its upper body."""
    scene = arm()
    scene.character.surfaces = {"bulge": surface}
    flexor = scene.character.muscles["flexor"]
    flexor.path = [ViaPoint("base", (0.0, 0.2, 0.03)), ViaPoint("base", (0.0, -0.2, 0.03)), *flexor.path[-1:]]
    flexor.wraps = [Wrap("bulge")]
    return scene


@pytest.mark.parametrize("name", SURFACES)
def test_a_tendon_is_as_long_as_the_path(name: str):
    scene = wrapped(SURFACES[name])
    model = mujoco.MjModel.from_xml_string(mjcf.dumps(scene, up="y"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    length = float(Stages(scene, 1, "cpu").muscle_paths().length[0, 0])
    assert length > 0.4
    assert data.tendon("flexor").length[0] == pytest.approx(length, abs=2e-6)


def test_what_mujoco_does_not_know_is_named():
    scene = wrapped(EllipsoidSurface("base", (0.0, 0.0, 0.0), (0.05, 0.06, 0.07)))
    text = mjcf.dumps(scene)
    assert "<!-- flexor: the surface bulge left out -->" in text
    assert ElementTree.fromstring(text).find(".//spatial/geom") is None
