"""`warpmuscle view` draws a model with the meshes of its folder, or of a named one, and says what is missing."""

from pathlib import Path

import pytest

import osim_models as small
from command_line import run

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

OBJ = "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


@pytest.fixture
def model(tmp_path) -> Path:
    mesh = "<attached_geometry>" + "".join(
        f"<Mesh><mesh_file>{name}</mesh_file></Mesh>" for name in ("rod.obj", "cap.obj")
    )
    rod = small.body("rod", center="0 -0.5 0", more=f"{mesh}</attached_geometry>")
    joint = small.joint("PinJoint", "pin", "ground", "rod", small.coordinate("q"))
    return small.written(tmp_path, small.model(rod, joint))


def test_meshes_beside_the_model_and_those_of_a_folder_are_drawn_and_gaps_told(model, tmp_path):
    plain = run("view", "small.osim", "--duration", "0.02", "--export", "plain.html", folder=tmp_path)
    assert plain.returncode == 0
    assert "rod.obj" not in plain.stderr  # nobody asked for meshes
    for folder in (tmp_path / "Geometry", tmp_path / "elsewhere"):
        folder.mkdir()
        (folder / "rod.obj").write_text(OBJ)
        given = [] if folder.name == "Geometry" else ["--meshes", "elsewhere"]
        told = run("view", "small.osim", "--duration", "0.02", "--export", "bones.html", *given, folder=tmp_path)
        assert told.returncode == 0
        assert "1 mesh file of small, and not cap.obj" in told.stderr
        assert (tmp_path / "bones.html").read_bytes() != (tmp_path / "plain.html").read_bytes()


def test_a_folder_without_the_files_is_an_error(model, tmp_path):
    told = run("view", "small.osim", "--duration", "0.02", "--export", "a.html", "--meshes", "nowhere", folder=tmp_path)
    assert told.returncode != 0
    assert "there is no such folder of meshes" in told.stderr
    assert not (tmp_path / "a.html").exists()
