"""Scenes written as OpenSim models: what is read again has the same bodies, paths and muscles.

That OpenSim 4.6 loads these files was tried by hand: of gait2392, Rajagopal2016 and arm26, written from what was read,
its path lengths and kinetic energies agree with those of the originals to 1e-9.
"""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from fuzzing.models import LEG

from muscle_arm import arm
from warpmuscle.core.pose import rotate
from warpmuscle.formats import Ignored, load, save
from warpmuscle.formats.osim.frames import turned
from warpmuscle.formats.osim.xml_text import angles_of
from warpmuscle.scene import Body, Character, ContactMaterial, Displacement, Ground, InitialState, Pulley, Scene, Sphere
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.validation.muscles import initial_path_lengths
from warpmuscle.simulation.stages import Stages

QUIET = pytest.mark.filterwarnings("ignore")


def again(scene: Scene, folder: Path) -> Scene:
    """The scene after it was written and read."""
    path = folder / "again.osim"
    save(scene, path, [])
    return load(path, ignored=[])


def same_start(before: Scene, after: Scene) -> None:
    """Every body of the first is in the same place, with the same mass and inertia, in the second."""
    first, second = world_poses(substitute(before, start_values(before))), world_poses(after)
    for name, body in before.character.bodies.items():
        other = after.character.bodies[name]
        np.testing.assert_allclose(second[name][0], first[name][0], atol=1e-9, err_msg=name)
        assert other.mass == body.mass
        matrices = [
            axes @ np.diag(inertia) @ axes.T
            for axes, inertia in (
                (rotate(poses[name][1], rotate(one.inertia_axes, np.eye(3))).T, one.inertia)
                for poses, one in ((first, body), (second, other))
            )
        ]
        np.testing.assert_allclose(*matrices, atol=1e-9 * max(np.max(np.abs(matrices[0])), 1e-9), err_msg=name)


@pytest.mark.parametrize("name", ["walk56", "bigbird_walk", "throw", "wang2012"])
@QUIET
def test_a_shipped_scene_is_the_same_when_it_is_read_again(name: str, tmp_path: Path):
    scene = load(name)
    after = again(scene, tmp_path)
    same_start(scene, after)
    plain = substitute(scene, start_values(scene))
    lengths, others = initial_path_lengths(plain), initial_path_lengths(after)
    for muscle, length in lengths.items():
        if after.character.muscles[muscle].polynomial is None:
            np.testing.assert_allclose(others[muscle], length, atol=1e-9)
        own, other = plain.character.muscles[muscle], after.character.muscles[muscle]
        assert (other.f_max, other.l_opt, other.l_slack) == (own.f_max, own.l_opt, own.l_slack)


@QUIET
def test_a_model_that_was_read_is_the_same_when_it_is_written_and_read(tmp_path: Path):
    path = tmp_path / "leg.osim"
    path.write_text(LEG)
    scene = load(path, ignored=[])
    after = again(scene, tmp_path)
    same_start(scene, after)
    assert after.opensim is not None
    assert scene.opensim is not None
    assert after.opensim.root_coordinates == scene.opensim.root_coordinates
    assert after.opensim.couplers == scene.opensim.couplers
    assert set(after.opensim.markers) == {"toe"}
    assert after.muscle_model == scene.muscle_model
    for name, muscle in scene.character.muscles.items():
        other = after.character.muscles[name]
        assert [point.body for point in other.path] == [point.body for point in muscle.path]
        for mine, theirs in zip(muscle.path, other.path, strict=True):
            assert (mine.condition is None) == (theirs.condition is None)
        assert other.wraps == muscle.wraps
        assert other.curve_shape == muscle.curve_shape
    assert [d.ends for d in after.character.joints["bend"].translations] == ["simm", "simm"]
    assert after.character.joints["glide"].follows == "bend"


@QUIET
def test_pulleys_become_polynomials_and_what_a_model_does_not_hold_is_told(tmp_path: Path):
    scene, lost = arm(), list[Ignored]()
    scene.character.muscles["flexor"].path = []
    (name, joint), *_ = scene.character.joints.items()
    assert joint.type == "hinge"
    scene.character.muscles["flexor"].pulleys = [Pulley(name, 0.03, 0.4)]
    scene.character.muscles["flexor"].rest_length = 0.3
    save(scene, tmp_path / "arm.osim", lost)
    polynomial = load(tmp_path / "arm.osim", ignored=[]).character.muscles["flexor"].polynomial
    assert polynomial is not None
    assert polynomial.joints == [name]
    np.testing.assert_allclose(np.dot(polynomial.coefficients, [0.5 ** row[0] for row in polynomial.exponents]), 0.297)
    assert any(one.text.endswith(".curves") for one in lost)


def test_functions_keep_their_kind(tmp_path: Path):
    path = tmp_path / "leg.osim"
    path.write_text(LEG)
    scene = load(path, ignored=[])
    natural = Displacement((0.0, 1.0, 0.0), x=[-2.0, -1.0, 0.0, 0.3], y=[0.0, 0.1, 0.3, 0.2], ends="natural")
    scene.character.joints["bend"].translations = [natural]
    (found,) = again(scene, tmp_path).character.joints["bend"].translations
    assert (found.x, found.y, found.ends) == (natural.x, natural.y, "natural")


def test_angles_of_a_matrix_make_the_matrix():
    matrix = turned([0.3, -0.7, 1.2])
    np.testing.assert_allclose(turned(list(angles_of(matrix))), matrix, atol=1e-15)


@pytest.mark.parametrize("law", ["hunt_crossley", "smooth_hunt_crossley"])
def test_materials_of_spheres_are_written_and_push_in_opensim_as_here(law: str, tmp_path: Path):
    """5 mm deep: the force of OpenSim, where there is one."""
    soft, hard = ContactMaterial(2e5, 1.0, 0.9, 0.7, 0.2, 0.1), ContactMaterial(3e6, 0.5)
    body = Body(2.0, (0.02, 0.02, 0.02), [Sphere((0.0, 0.0, 0.0), 0.05, soft), Sphere((0.0, 0.01, 0.0), 0.05, hard)])
    scene = Scene("ball", Character("ball", {"ball": body}), ground=Ground(law=law), gravity=0.0)
    scene.initial_state = InitialState((0.0, 0.035, 0.0))
    after = again(scene, tmp_path)
    assert after.ground.law == law
    assert [shape.material for shape in after.character.bodies["ball"].shapes] == [soft, hard]
    osim = pytest.importorskip("opensim")
    osim.Logger.setLevelString("off")
    model = osim.Model(str(tmp_path / "again.osim"))
    state = model.initSystem()
    model.realizeAcceleration(state)
    up = model.getBodySet().get("ball").getAccelerationInGround(state).get(1).get(1)
    np.testing.assert_allclose(Stages(scene, 1, "cpu").contact_forces()[0][0, 0, 1], 2.0 * up, rtol=1e-4)
    assert up > 10.0


@pytest.mark.parametrize("second", [np.pi / 2.0, -np.pi / 2.0, 0.7])
def test_angles_give_the_matrix_also_where_two_axes_are_one(second: float):
    for first, third in np.random.default_rng(0).uniform(-3.0, 3.0, (20, 2)):
        matrix = turned((first, second, third))
        np.testing.assert_allclose(turned(angles_of(matrix)), matrix, atol=1e-7)


@QUIET
def test_characters_that_no_xml_may_hold_leave_a_file_that_can_be_read(tmp_path: Path):
    found = again(msgspec.structs.replace(arm(), description="an\x1b[31m arm & more\x07"), tmp_path)
    assert "tip" in found.character.bodies
    assert "an\ufffd[31m arm &amp; more\ufffd" in (tmp_path / "again.osim").read_text()
