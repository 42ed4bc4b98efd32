"""Tendons over pulleys become muscles with branches, which do what MuJoCo's do."""

import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco")
sys.path.append(str(Path(__file__).parent))

from mujoco_ours import computed  # noqa: E402
from mujoco_poses import Oracle  # noqa: E402
from small_models import ARM, HOPPER  # noqa: E402

import warpmuscle as wm  # noqa: E402
from warpmuscle.core.errors import SceneError  # noqa: E402
from warpmuscle.formats import load, mjcf  # noqa: E402
from warpmuscle.scene.initial_pose import initial_pose  # noqa: E402
from warpmuscle.scene.muscles import Branch  # noqa: E402
from warpmuscle.scene.wrapping.path import path_length  # noqa: E402
from warpmuscle.scene.wrapping.route import route_stops  # noqa: E402

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

OVER_PULLEYS = """<spatial name="tackle"><site site="o1"/><site site="u1"/><pulley divisor="2"/><site site="u1"/>
  <geom geom="ball"/><site site="h1"/><pulley divisor="4"/><site site="o2"/><geom geom="roll" sidesite="beside"/>
  <site site="c1"/><site site="p1"/></spatial><spatial name="half"><pulley divisor="2"/><site site="u2"/>
  <site site="c1"/></spatial>"""


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    """A file of the arm with two more tendons, with which muscles pull."""
    wide = ARM.replace('range="-1 1.2"', 'range="-50 60"')
    text = wide.replace("<fixed", f"{OVER_PULLEYS}<fixed").replace(
        "</actuator>",
        """<muscle name="tackle" tendon="tackle" force="400" lengthrange="0.2 0.6"/>
        <muscle name="half" tendon="half" force="100" lengthrange="0.05 0.2"/></actuator>""",
    )
    path = tmp_path_factory.mktemp("pulleys") / "arm.xml"
    path.write_text(text)
    return path


def test_paths_forces_and_accelerations_are_those_of_mujoco(model: Path):
    theirs = Oracle(model).poses(40, 5)
    scene = load(model, ignored=[])
    assert [(one.first, one.divisor) for one in scene.character.muscles["tackle"].branches] == [(3, 2.0), (5, 4.0)]
    length, speed, arm, force, acceleration = computed(scene, theirs)
    column = theirs.muscles.index("tackle")
    assert np.ptp(theirs.length[:, column]) > 0.01
    np.testing.assert_allclose(length, theirs.length, atol=1e-6)
    np.testing.assert_allclose(speed, theirs.speed, atol=2e-5)
    np.testing.assert_allclose(arm, theirs.arm, atol=2e-6)
    np.testing.assert_allclose(force, theirs.force, atol=2e-4 * np.abs(theirs.force).max())
    most = np.abs(theirs.acceleration).max(axis=0)
    np.testing.assert_allclose(acceleration / most, theirs.acceleration / most, atol=2e-4)


def test_the_host_measures_what_the_kernel_does(model: Path):
    scene = load(model, ignored=[])
    length = wm.simulation.stages.Stages(scene, 1, "cpu").muscle_paths().length[0]
    poses, angles = initial_pose(scene)
    for name in ("tackle", "half"):
        muscle = scene.character.muscles[name]
        found = path_length(route_stops(scene.character, muscle, poses, angles))
        assert length[list(scene.character.muscles).index(name)] == pytest.approx(found, abs=1e-6)


def test_branches_are_written_to_toml_and_to_mujoco(model: Path, tmp_path: Path):
    scene = load(model, ignored=[])
    wm.save(scene, tmp_path / "arm.toml")
    again = load(tmp_path / "arm.toml", ignored=[])
    assert again.character.muscles["tackle"].branches == scene.character.muscles["tackle"].branches


def test_a_pulley_is_written_for_mujoco(tmp_path: Path):
    path = tmp_path / "hopper.xml"
    path.write_text(HOPPER.replace('<site site="f1"/>', '<pulley divisor="2.5"/><site site="l1"/><site site="f1"/>'))
    scene = load(path, ignored=[])
    written = tmp_path / "again.xml"
    written.write_text(mjcf.dumps(scene))
    again = load(written, ignored=[])
    assert again.character.muscles["long"].branches == scene.character.muscles["long"].branches == [Branch(3, 2.5)]


@pytest.mark.parametrize(
    ("branches", "message"),
    [
        ([Branch(9)], "the path has points 1 to 7, not 9"),
        ([Branch(3, 2.0), Branch(4)], "two points at least"),
        ([Branch(2)], "two points at least"),
        ([Branch(3, 0.0)], "must be greater than 0"),
        ([Branch(4)], "between points of one branch"),
    ],
)
def test_branches_that_are_none_are_refused(model: Path, branches: list[Branch], message: str):
    scene = load(model, ignored=[])
    scene.character.muscles["tackle"].branches = branches
    with pytest.raises(SceneError, match=message):
        wm.Rollout(scene, 1, "cpu")
