"""A model is drawn by its own meshes where a folder has them, thinned to fit a page, and by ours where not."""

import warnings
from pathlib import Path

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats import load, toml
from warpmuscle.formats.meshes.triangles import Triangles
from warpmuscle.scene import DrawnMesh, OpenSim, Scene
from warpmuscle.scene.topology import topology
from warpmuscle.view.bones.decimate import shaded, thinned
from warpmuscle.view.bones.model_meshes import CORNERS, MeshWarning, mesh_folder, placed, with_meshes
from warpmuscle.view.figure import figure_of
from warpmuscle.view.page import replay_html
from warpmuscle.view.pieces import Hull
from warpmuscle.view.waiting import first_pose

OBJ = "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def sphere(rows: int = 150, radius: float = 0.1) -> Triangles:
    """A fine mesh of a sphere."""
    a, b = np.linspace(0.0, np.pi, rows), np.linspace(0.0, 2.0 * np.pi, 2 * rows, endpoint=False)
    corners = radius * np.stack(
        [np.outer(np.sin(a), np.cos(b)), np.outer(np.cos(a), np.ones(2 * rows)), np.outer(np.sin(a), np.sin(b))], -1
    )
    k, j = np.meshgrid(np.arange(rows - 1), np.arange(2 * rows), indexing="ij")
    at = lambda row, column: row * 2 * rows + column % (2 * rows)  # noqa: E731
    quads = [(at(k, j), at(k, j + 1), at(k + 1, j)), (at(k, j + 1), at(k + 1, j + 1), at(k + 1, j))]
    return Triangles(corners.reshape(-1, 3), np.concatenate([np.stack(q, -1).reshape(-1, 3) for q in quads]))


def volume(corners: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (corners[faces[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def arm(*meshes: DrawnMesh) -> Scene:
    scene = load("throw")
    scene.opensim = OpenSim(meshes=list(meshes))
    return scene


def figure(scene: Scene, folder: Path) -> tuple[list[str], list[Hull]]:
    names = list(topology(scene.character).bodies)
    pieces = with_meshes(figure_of(scene.character, (), names), scene, names, folder)
    return names, [one for one in pieces if isinstance(one, Hull) and one.layer == "bone"]


def test_a_fine_sphere_becomes_a_coarse_one_of_its_volume_with_normals_outwards():
    fine = sphere()
    coarse = thinned([fine], 1500)[0]
    assert 500 < len(coarse.corners) <= 1500
    assert volume(*coarse) == pytest.approx(volume(*fine), rel=0.03)
    corners, normals, _ = shaded(coarse)
    unit = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    sign = np.sign(volume(*fine))
    assert np.sum(unit * normals, axis=1).min() * sign > 0.8


def test_small_meshes_stay_as_they_are_and_all_get_cells_of_one_size():
    small, large = sphere(20, 0.01), sphere(150, 0.2)
    assert thinned([small], CORNERS)[0] is small
    thin = thinned([small, large], 3000)
    assert sum(len(one.corners) for one in thin) <= 3000
    assert len(thin[0].corners) < 30


def test_a_mesh_is_scaled_turned_and_put_where_it_is_said_to_be():
    surface = Triangles(np.array([[0.1, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.3]]), np.array([[0, 1, 2]]))
    mesh = DrawnMesh("a", "a.stl", (1.0, 2.0, 3.0), (0.0, 0.0, 0.5 * np.pi), (2.0, 1.0, -1.0))
    found = placed(mesh, surface)
    turn = from_rotation_vector(np.array([0.0, 0.0, 0.5 * np.pi]))
    assert found.corners[0] == pytest.approx(np.array([1.0, 2.0, 3.0]) + rotate(turn, np.array([0.2, 0.0, 0.0])))
    assert found.corners[0] == pytest.approx([1.0, 2.2, 3.0])
    assert found.faces.tolist() == [[2, 1, 0]]  # mirrored


def test_bodies_with_files_have_these_bones_and_others_ours(tmp_path):
    (tmp_path / "Geometry").mkdir()
    (tmp_path / "Geometry" / "HUMERUS.obj").write_text(OBJ)
    (tmp_path / "broken.vtp").write_text("<VTKFile")
    names = list(topology(load("throw").character).bodies)
    scene = arm(
        DrawnMesh(names[1], "humerus.obj"), DrawnMesh(names[2], "broken.vtp"), DrawnMesh(names[3], "lost.stl")
    )  # fmt: skip
    with pytest.warns(MeshWarning) as told:
        _, bones = figure(scene, tmp_path)
    own = [bone for bone in bones if bone.body == 1]
    assert [len(bone.faces) for bone in own] == [4]
    assert {bone.body for bone in bones} >= {1, 2}
    texts = [str(one.message) for one in told]
    assert any("broken.vtp: line 1" in text for text in texts)
    assert any("lost.stl" in text for text in texts)


def test_a_folder_asked_for_must_have_meshes_and_one_beside_may(tmp_path):
    scene = arm(DrawnMesh("thorax", "thorax.vtp"))
    assert mesh_folder(None, scene, tmp_path) is None
    for folder, words in ((tmp_path / "none", "no such folder"), (tmp_path, "has none of the 1 mesh file of")):
        with pytest.raises(Error, match=words):
            mesh_folder(folder, scene)
    with pytest.raises(Error, match="no meshes are named"):
        mesh_folder(tmp_path, load("fwalk"))
    (tmp_path / "thorax.vtp").touch()
    assert mesh_folder(None, scene, tmp_path) == tmp_path == mesh_folder(tmp_path, scene)


@pytest.mark.parametrize("name", ["../a.vtp", "/etc/a.stl", "..\\a.obj", "C:a.obj", ".vtp", "a.exe", "a\n.vtp", ""])
def test_a_scene_names_no_file_of_another_folder(name: str):
    scene = arm(DrawnMesh(load("throw").character.root, "a.vtp"))
    scene.opensim.meshes[0].file = name
    with pytest.raises(Error, match=r"opensim\.meshes\.0\.file"):
        toml.loads(toml.dumps(scene))


def test_a_page_with_100_000_triangles_stays_small(tmp_path):
    fine = sphere(160)
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in fine.corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in fine.faces]
    names = list(topology(load("throw").character).bodies)
    (tmp_path / "fine.obj").write_text("\n".join(lines))
    scene = arm(*(DrawnMesh(name, "fine.obj") for name in names[:1]))
    pose = first_pose(scene)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        page = replay_html(pose, scene, meshes=tmp_path)
    assert len(page.encode()) < 1_000_000
    assert len(page) > len(replay_html(pose, msgspec.structs.replace(scene, opensim=None)))
