"""Models whose gravity does not point along -y are turned so that it does."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats import Ignored, load
from warpmuscle.formats.osim.frames import turned
from warpmuscle.formats.osim.placement import WORLD, world_axes
from warpmuscle.scene import CylinderSurface, Scene
from warpmuscle.scene.opensim_root import root_motion

DOWN = np.array([0.0, -1.0, 0.0])
PLACE, TURN = np.array([0.3, -0.2, 0.5]), np.array([0.4, -0.3, 0.2])  # m, rad: a pin's frame in a y-up ground


@pytest.mark.parametrize("gravity", ["0 0 -9.8", "-9.8 0 0", "0 9.8 0", "1 -9 2", "0 -9.8 0", "0 0 0"])
def test_the_ground_is_turned_and_nothing_else(gravity: str):
    found = np.array([float(word) for word in gravity.split()])
    axes = world_axes(tuple(found))
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes @ found, DOWN * np.linalg.norm(found), atol=1e-14)
    if found[0] == found[2] == 0.0 and found[1] <= 0.0:
        assert np.array_equal(axes, WORLD)


def angles(matrix: np.ndarray) -> str:
    """Body-fixed x-y-z angles of a rotation."""
    about_y = np.arcsin(matrix[0, 2])
    about_x, about_z = np.arctan2(-matrix[1, 2], matrix[2, 2]), np.arctan2(-matrix[0, 1], matrix[0, 0])
    return " ".join(f"{value:.17g}" for value in (about_x, about_y, about_z))


def arm(folder: Path, gravity: str) -> Scene:
    """A rod on a pin, a muscle from the ground round a cylinder that the ground has; all turned as gravity is."""
    turn = world_axes(tuple(float(word) for word in gravity.split())).T @ WORLD  # of a y-up ground in this one

    def place(values: np.ndarray) -> str:
        return " ".join(f"{value:.17g}" for value in turn @ values)

    joint = small.joint(
        "PinJoint", "pin", "ground", "rod", small.coordinate("q", "<default_value>0.4</default_value>"),
        place=place(PLACE), turn=angles(turn @ turned(TURN)),
    )  # fmt: skip
    drum = (
        f'<Ground name="ground"><WrapObjectSet><objects><WrapCylinder name="drum"><xyz_body_rotation>'
        f"{angles(turn @ turned(-TURN))}</xyz_body_rotation><translation>{place(PLACE + 0.05)}</translation>"
        "<radius>0.02</radius><length>0.1</length></WrapCylinder></objects></WrapObjectSet></Ground>"
    )
    wrap = '<PathWrap name="w"><wrap_object>drum</wrap_object></PathWrap>'
    points = small.point("a", "ground", place(PLACE + 0.1)) + small.point("b", "rod", "0 -0.4 0.02")
    return load(
        small.written(folder, small.model(
            small.body("rod", center="0 -0.5 0"), joint, small.muscle("m", points, wrap),
            defaults=f"<gravity>{gravity}</gravity>{drum}",
        )), ignored=[], hard_points=True,
    )  # fmt: skip


@pytest.mark.parametrize("gravity", ["0 0 -9.8", "-9.8 0 0", "0 9.8 0", "1 -9 2"])
def test_a_turned_model_is_the_same_scene(tmp_path: Path, gravity: str):
    """Places on the ground, the pin's axis and a surface are those of the model that has y up."""
    scene = arm(tmp_path, gravity)
    size = float(np.linalg.norm([float(word) for word in gravity.split()]))
    usual = arm(tmp_path, f"0 {-size:.17g} 0")
    assert scene.gravity == pytest.approx(size)
    for name in ("pin", "q"):
        if name in usual.character.joints:
            one, other = scene.character.joints[name], usual.character.joints[name]
            np.testing.assert_allclose(one.position_in_parent, other.position_in_parent, atol=1e-12)
            np.testing.assert_allclose(one.axes, other.axes, atol=1e-12)
    first, second = (one.character.muscles["m"].path[0].position for one in (scene, usual))
    np.testing.assert_allclose(first, second, atol=1e-12)
    one, other = (each.character.surfaces["drum"] for each in (scene, usual))
    assert isinstance(one, CylinderSurface)
    assert isinstance(other, CylinderSurface)
    np.testing.assert_allclose(one.position, other.position, atol=1e-12)
    axes = [rotate(from_rotation_vector(np.array(each.orientation)), np.eye(3)) for each in (one, other)]
    np.testing.assert_allclose(axes[0], axes[1], atol=1e-12)


@pytest.mark.filterwarnings("ignore:.*centre of mass starts")
def test_a_free_root_with_z_up_keeps_its_coordinates(tmp_path: Path):
    """Its third shift, along z of the model, lifts it here."""
    words = ("rx", "ry", "rz", "tx", "ty", "tz")
    notes: list[Ignored] = []
    text = small.model(
        small.body("trunk"),
        small.joint_of_six("root", "ground", "trunk", words),
        defaults="<gravity>0 0 -9.8</gravity>",
    )
    scene = load(small.written(tmp_path, text), ignored=notes)
    assert any("the model is turned" in note.reason for note in notes)
    assert scene.opensim is not None
    assert scene.character.root_joint == "free"
    values = np.array([[0.0, 0.0, 0.0, 0.2, 0.3, 1.1]])
    order = [scene.opensim.root_coordinates.index(word) for word in words]
    given = np.zeros((1, 6))
    given[:, order] = values
    np.testing.assert_allclose(root_motion(scene.opensim, given).position[0], [0.3, 1.1, 0.2], atol=1e-12)


def test_a_half_space_that_stands_upright_beside_gravity_is_left_out_with_a_note(tmp_path: Path):
    """Its matter is where x > 0 in its own axes: a wall, if it is not turned by a right angle about z."""
    shapes = (
        '<ContactGeometrySet><objects><ContactHalfSpace name="floor"><socket_frame>/ground</socket_frame>'
        "<orientation>TURN</orientation></ContactHalfSpace>"
        '<ContactSphere name="foot"><socket_frame>/bodyset/rod</socket_frame><radius>0.02</radius></ContactSphere>'
        "</objects></ContactGeometrySet>"
    )
    touch = (
        '<HuntCrossleyForce name="touch"><HuntCrossleyForce::ContactParametersSet name="contact_parameters"><objects>'
        "<HuntCrossleyForce::ContactParameters><geometry>floor foot</geometry></HuntCrossleyForce::ContactParameters>"
        "</objects></HuntCrossleyForce::ContactParametersSet></HuntCrossleyForce>"
    )
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))

    def touching(turn: str) -> tuple[int, list[str]]:
        ignored: list[Ignored] = []
        text = small.model(small.body("rod", center="0 -0.5 0"), joint, touch, shapes.replace("TURN", turn))
        scene = load(small.written(tmp_path, text), ignored=ignored)
        return sum(len(body.shapes) for body in scene.character.bodies.values()), [note.reason for note in ignored]

    count, reasons = touching("0 0 0")
    assert count == 0
    assert "half-space 'floor' is a wall or a ceiling beside gravity; left out" in reasons
    assert touching("0 0 -1.5707963267948966")[0] == 1
