"""Meshes of a model keep their names and lie where OpenSim draws them, in the layouts of versions 1 to 4."""

from pathlib import Path

import numpy as np
import pytest

import osim_models as small
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats import load, toml
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.opensim_scale import scaled_model
from warpmuscle.formats.osim.build import build
from warpmuscle.formats.osim.read import read
from warpmuscle.scene import DrawnMesh

MESH = "<Mesh><Appearance><opacity>1</opacity></Appearance><mesh_file>{}</mesh_file>{}</Mesh>"
NEW = "<attached_geometry>" + MESH.format("Rod.vtp", "<scale_factors>1 2 3</scale_factors>") + "</attached_geometry>"
OLD = """<VisibleObject><GeometrySet><objects><DisplayGeometry><geometry_file>rod.vtp</geometry_file>
<color>1 1 1</color><transform> 0 0 1.5707963267948966 0.1 0.2 0.3</transform><scale_factors>1 1 2</scale_factors>
</DisplayGeometry></objects></GeometrySet><scale_factors>2 1 1</scale_factors></VisibleObject>"""
OLDEST = """<VisibleObject><geometry_files> rod.vtp cap.obj </geometry_files><scale_factors>1 1 1</scale_factors>
</VisibleObject>"""


def meshes(folder: Path, more: str) -> list[DrawnMesh]:
    """Of a rod whose centre of mass is 0.5 m below its pin."""
    rod = small.body("rod", center="0 -0.5 0", more=more)
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    notes = Notes()
    scene = build(read(small.written(folder, small.model(rod, joint)), notes), notes)
    assert not [note for note in notes.ignored if "Geometry" in note.text or "geometry" in note.text]
    return scene.opensim.meshes


def at(mesh: DrawnMesh, point: tuple[float, float, float]) -> np.ndarray:
    """Where a point of the file is in our body's frame."""
    turn = from_rotation_vector(np.array(mesh.orientation))
    return np.array(mesh.position) + rotate(turn, np.array(mesh.scale) * point)


def test_a_mesh_is_turned_to_our_axes_about_the_centre_of_mass(tmp_path):
    (mesh,) = meshes(tmp_path, NEW)
    assert (mesh.body, mesh.file, mesh.scale) == ("rod", "Rod.vtp", (1.0, 2.0, 3.0))
    # OpenSim's x is ahead, our z; its z is to the right, against our x; the origin is half a metre above the centre
    assert at(mesh, (0.1, 0.2, 0.3)) == pytest.approx([-0.9, 0.5 + 0.4, 0.1], abs=1e-12)


def test_version_3_places_and_scales_a_mesh_itself(tmp_path):
    (mesh,) = meshes(tmp_path, OLD)
    assert mesh.scale == (2.0, 1.0, 2.0)
    # about z by a right angle: (0.1 * 2, 0, 0) comes to (0, 0.2, 0), and then goes by (0.1, 0.2, 0.3)
    assert at(mesh, (0.1, 0.0, 0.0)) == pytest.approx([-0.3, 0.5 + 0.4, 0.1], abs=1e-12)


def test_version_1_lists_files(tmp_path):
    assert [mesh.file for mesh in meshes(tmp_path, OLDEST)] == ["rod.vtp", "cap.obj"]


@pytest.mark.parametrize(("named", "kept"), [
    ("../../etc/rod.vtp", ["rod.vtp"]), ("C:\\Geometry\\rod.stl", ["rod.stl"]), ("/etc/passwd", []), ("rod.exe", []),
    (".vtp", []),
])  # fmt: skip
def test_of_a_name_with_folders_only_the_last_part_is_kept(tmp_path, named: str, kept: list[str]):
    text = f"<attached_geometry>{MESH.format(named, '')}</attached_geometry>"
    assert [mesh.file for mesh in meshes(tmp_path, text)] == kept


def test_a_scaled_body_has_a_scaled_mesh(tmp_path):
    rod = small.body("rod", center="0 -0.5 0", more=OLD)
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    record = read(small.written(tmp_path, small.model(rod, joint)), Notes())
    (mesh,) = scaled_model(record, {"rod": np.array([1.0, 2.0, 1.0])}).meshes
    assert mesh.scale == (2.0, 2.0, 2.0)
    assert mesh.translation == pytest.approx((0.1, 0.4, 0.3))


def test_a_scene_of_the_model_names_its_meshes_as_well(tmp_path):
    rod = small.body("rod", center="0 -0.5 0", more=NEW)
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    scene = load(small.written(tmp_path, small.model(rod, joint)), ignored=[])
    assert toml.loads(toml.dumps(scene)).opensim.meshes == scene.opensim.meshes
