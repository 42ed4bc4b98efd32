"""Side sites on another body than the surface: the surface goes to that body, where it lies as well."""

import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
sys.path.append(str(Path(__file__).parent))

from mujoco_ours import computed  # noqa: E402
from mujoco_poses import Oracle  # noqa: E402

from warpmuscle.formats import Ignored, load  # noqa: E402

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


def arm(place: str = "0 0 0", turn: str = "0 0 1") -> str:
    """Two links whose extensors go round surfaces on the outer bodies, with side sites on the inner ones."""
    quat = f'zaxis="{turn}"'
    return f"""<mujoco><worldbody><site name="o" pos="-0.15 0.01 0.02"/><site name="behind" pos="0 -0.15 0"/>
    <body name="upper"><joint name="shoulder" axis="0 0 1" range="-10 120" limited="true"/>
      <geom type="capsule" size="0.04" fromto="0 0 0 0.5 0 0"/>
      <geom name="roll" type="cylinder" size="0.1 0.05" mass="0" pos="{place}" {quat}/>
      <site name="u" pos="0.15 -0.06 -0.01"/><site name="elbow_side" pos="0.5 -0.15 0"/>
      <body name="fore" pos="0.5 0 0"><joint name="elbow" axis="0 0 1" range="0 120" limited="true"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>
        <geom name="ball" type="sphere" size="0.08" mass="0"/><site name="f" pos="0.11 -0.05 0.01"/>
      </body></body></worldbody>
    <tendon><spatial name="one"><site site="o"/><geom geom="roll" sidesite="behind"/><site site="u"/></spatial>
      <spatial name="two"><site site="o"/><geom geom="roll" sidesite="behind"/><site site="u"/>
        <geom geom="ball" sidesite="elbow_side"/><site site="f"/></spatial></tendon>
    <actuator><muscle name="one" tendon="one" lengthrange="0.2 0.9"/>
      <muscle name="two" tendon="two" lengthrange="0.5 1.5"/></actuator></mujoco>"""


def test_lengths_and_arms_are_those_of_mujoco(tmp_path: Path):
    path = tmp_path / "arm.xml"
    path.write_text(arm())
    ignored: list[Ignored] = []
    scene = load(path, ignored=ignored)
    assert [surface.body for surface in scene.character.surfaces.values()] == ["ground", "upper"]
    assert not any("side site" in note.reason for note in ignored)
    theirs = Oracle(path).poses(60, 3)
    length, _, moment_arm, _, _ = computed(scene, theirs)
    assert np.ptp(theirs.length, axis=0).max() > 0.3
    np.testing.assert_allclose(length, theirs.length, atol=1e-6)
    np.testing.assert_allclose(moment_arm, theirs.arm, atol=1e-5)


@pytest.mark.parametrize(("place", "turn"), [("0.02 0 0", "0 0 1"), ("0 0 0", "0 1 1")])
def test_a_surface_that_a_hinge_moves_stays_and_its_side_is_told(tmp_path: Path, place: str, turn: str):
    path = tmp_path / "arm.xml"
    path.write_text(arm(place=place, turn=turn))
    ignored: list[Ignored] = []
    scene = load(path, ignored=ignored)
    assert [surface.body for surface in scene.character.surfaces.values()] == ["upper", "upper"]
    assert [note.text for note in ignored if "side site is on another body" in note.reason] == ["geom roll_behind"]
