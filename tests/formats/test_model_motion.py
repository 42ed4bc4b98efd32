"""Motions of scenes made of OpenSim models in the coordinates of those models, and ground forces as external loads."""

from pathlib import Path
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest

from opensim_table import table
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import normalized
from warpmuscle.formats import load, sto
from warpmuscle.formats.external_loads import write_loads
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Coupling, Displacement, Joint, OpenSim, Scene
from warpmuscle.scene.opensim_root import root_motion
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.studies.ground_loads import ground_loads
from warpmuscle.studies.inverse_dynamics import inverse_dynamics

FORWARD, UP, RIGHT = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)  # OpenSim's axes in ours


@pytest.fixture(scope="module")
def walk() -> tuple[Recording, Scene]:
    """A walk on torques that stands on each foot, in the words of a model."""
    scene = msgspec.structs.replace(load("fwalk"), duration=1.2)
    root = Joint("coupled", "ground", "pelvis", (0.0, 0.0, 0.0), (0.0, -0.05, 0.02))
    root.rotations = [Displacement(axis, slope=1.0) for axis in (RIGHT, FORWARD, UP)]
    root.translations = [Displacement(axis, slope=1.0) for axis in (FORWARD, UP, RIGHT)]
    scene.opensim = OpenSim("walk.osim", root, ["tilt", "list", "rotation", "tx", "ty", "tz"])
    scene.opensim.angles = ["tilt", "list", "rotation", "lKnee", "toes"]
    scene.opensim.locked = {"toes": 0.25}
    scene.opensim.couplers = {"patella": Coupling(joint="lKnee", x=[-3.0, 0.0, 3.0], y=[0.0, 0.2, 0.1], ends="linear")}
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    return rollout.recording(), scene


def test_the_coordinates_are_those_of_the_model(walk, tmp_path: Path):
    motion, scene = walk
    sto.write(motion, scene, tmp_path / "walk.mot")
    _, names, rows = table(tmp_path / "walk.mot")
    values = {name: rows[:, k] for k, name in enumerate(names)}
    root = np.stack([values[name] for name in scene.opensim.root_coordinates], axis=1)
    found = root_motion(scene.opensim, np.concatenate([np.radians(root[:, :3]), root[:, 3:]], axis=1))
    np.testing.assert_allclose(found.position, motion.root_position, atol=1e-6)
    same = np.abs(np.sum(found.orientation * normalized(motion.root_orientation), axis=1))
    np.testing.assert_allclose(same, 1.0, atol=1e-9)
    knee = motion.coordinate[:, motion.coordinate_names.index("lKnee")]
    np.testing.assert_allclose(np.radians(values["lKnee"]), knee, atol=1e-6)
    np.testing.assert_allclose(values["patella"], np.interp(knee, [-3.0, 0.0, 3.0], [0.0, 0.2, 0.1]), atol=1e-6)
    np.testing.assert_allclose(values["toes"], np.degrees(0.25))


def test_loads_carry_the_body_as_its_motion_asks_for(walk):
    motion, scene = walk
    loads = ground_loads(motion, scene)
    assert {one.body for one in loads} >= {"lFoot", "rFoot"}
    needed = inverse_dynamics(scene, motion.coordinate, motion.speed, np.gradient(motion.speed, motion.time, axis=0))
    force = sum(one.force for one in loads)
    moment = sum(np.cross(one.point - motion.root_position, one.force) + one.torque for one in loads)
    late = motion.time > 0.5  # when it has come down on its feet
    scale = np.abs(needed[late]).max()
    assert np.median(np.abs(force - needed[:, :3])[late]) < 0.01 * scale
    assert np.median(np.abs(moment - needed[:, 3:6])[late]) < 0.01 * scale
    for one in loads:
        loaded = one.force[:, 1] > 0.0
        np.testing.assert_allclose(one.point[loaded, 1], 0.0, atol=1e-9)
        assert not one.torque[:, [0, 2]].any()


def test_loads_are_written_in_the_axes_of_opensim_with_a_description(walk, tmp_path: Path):
    motion, scene = walk
    loads = ground_loads(motion, scene)
    described = write_loads(loads, motion.time, tmp_path / "forces.mot")
    _, names, rows = table(tmp_path / "forces.mot")
    right = next(one for one in loads if one.body == "rFoot")
    for axis, column in {"x": right.force[:, 2], "y": right.force[:, 1], "z": -right.force[:, 0]}.items():
        np.testing.assert_allclose(rows[:, names.index(f"rFoot_ground_force_v{axis}")], column, rtol=1e-6, atol=1e-6)
    entries = ElementTree.parse(described).getroot().findall(".//ExternalForce")
    assert [entry.findtext("applied_to_body") for entry in entries] == [one.body for one in loads]
    for entry in entries:
        for what in ("force", "point", "torque"):
            assert f"{entry.findtext(f'{what}_identifier')}z" in names
    assert ElementTree.parse(described).getroot().findtext(".//datafile") == "forces.mot"


def test_what_was_recorded_without_coordinates_has_no_loads(walk):
    motion, scene = walk
    with pytest.raises(Error, match="recorded without coordinates"):
        ground_loads(_without_coordinates(motion), scene)


def _without_coordinates(motion: Recording) -> Recording:
    arrays = {
        name: motion[name] for name in motion.__dataclass_fields__ if isinstance(getattr(motion, name), np.ndarray)
    }
    del arrays["coordinate"], arrays["speed"], arrays["joint_angle"]
    return Recording.of(arrays, motion.joint_names, motion.body_names, motion.muscle_names)
