"""What is refused about what a scene keeps of an OpenSim model, and that the rest is read back."""

from pathlib import Path

import pytest

from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.scene import Coupling, Displacement, Joint, Marker, OpenSim
from warpmuscle.scene.validation.scene import check_scene


def kept() -> OpenSim:
    """A root that turns about one axis and moves along another one."""
    root = Joint("coupled", "ground", "base", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    root.rotations = [Displacement((-1.0, 0.0, 0.0), slope=1.0)]
    root.translations = [Displacement((0.0, 1.0, 0.0), slope=1.0)]
    markers = {"tip": Marker("tip", (0.0, 0.1, 0.0))}
    return OpenSim(
        "arm.osim", root, ["tilt", "ty"], {"tx": 0.1}, {"patella": Coupling(joint="elbow", slope=0.5)}, markers
    )


def test_it_is_read_back_as_it_was_written(tmp_path: Path):
    scene = arm()
    scene.opensim = kept()
    save(scene, tmp_path / "arm.toml")
    assert load(tmp_path / "arm.toml").opensim == scene.opensim


def test_each_displacement_of_the_root_has_a_name():
    scene = arm()
    scene.opensim = kept()
    scene.opensim.root_coordinates = ["tilt"]
    with pytest.raises(SceneError, match=r"opensim\.root_coordinates: 1 name for 2 displacements of the root"):
        check_scene(scene)


def test_a_marker_is_on_a_body():
    scene = arm()
    scene.opensim = kept()
    scene.opensim.markers["tip"].body = "top"
    with pytest.raises(SceneError, match=r"opensim\.markers\.tip\.body: no body is called 'top'.*'tip'"):
        check_scene(scene)


def test_a_coupled_coordinate_is_a_function_of_that_of_a_joint():
    scene = arm()
    scene.opensim = kept()
    scene.opensim.couplers["patella"].joint = "knee"
    with pytest.raises(SceneError, match=r"opensim\.couplers\.patella\.joint: no joint is called 'knee'"):
        check_scene(scene)
