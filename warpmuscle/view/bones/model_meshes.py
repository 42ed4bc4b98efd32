"""The bones of a model as its own files of triangles draw them, where a folder has these files."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.files import unreadable
from warpmuscle.core.plain_text import number_of
from warpmuscle.core.pose import from_rotation_vector, rotate
from warpmuscle.formats.meshes.read import read_mesh
from warpmuscle.formats.meshes.triangles import Triangles
from warpmuscle.scene import DrawnMesh, Scene
from warpmuscle.scene.anatomy import sides_of
from warpmuscle.scene.initial_pose import plain_vector
from warpmuscle.scene.validation.muscles import SceneWarning
from warpmuscle.view.bones.decimate import shaded, thinned
from warpmuscle.view.pieces import Hull, Piece

WITHIN = ("", "Geometry", "geometry", "meshes")  # of a folder, where meshes are looked for
CORNERS = 12_000  # of all meshes of a body: some 250 kB of a page
NAMED = 3  # files that a message names
READ_AT_ONCE = 3_000_000  # corners of all files together, beyond which the rest is not read


class MeshWarning(SceneWarning):
    """A file of triangles is missing or damaged, and a body is drawn without it."""


def mesh_folder(given: str | os.PathLike[str] | None, scene: Scene, beside: Path | None = None) -> Path | None:
    """The folder that has meshes of a scene, None if there is none.

    Args:
        given: what was asked for. beside: where the scene's file is, whose meshes nobody has asked for.

    Raises:
        Error: there is no such folder, it has none of the files, or the scene names none.
    """
    files = [] if scene.opensim is None else [mesh.file for mesh in scene.opensim.meshes]
    if given is None:
        return beside if beside is not None and files and _there(beside, files) else None
    folder = Path(given)
    if not files:
        raise Error(f"no meshes are named by {scene.name}; a model of OpenSim does, or `opensim.meshes` of a scene")
    if not folder.is_dir():
        raise Error(f"{folder}: there is no such folder of meshes")
    if not _there(folder, files):
        some = ", ".join(list(dict.fromkeys(files))[:NAMED])
        raise Error(f"{folder} has none of the {number_of(len(set(files)), 'mesh file')} of {scene.name}: {some}, ...")
    return folder


def with_meshes(pieces: list[Piece], scene: Scene, names: Sequence[str], folder: Path) -> list[Piece]:
    """A figure whose bodies have the bones of their files, where these are found and sound.

    Args:
        scene: without free parameters. names: of the bodies, as pieces number them.

    Warns:
        MeshWarning: files that are missing or damaged.
    """
    model = scene.opensim
    assert model is not None  # or there would be no folder
    found: list[tuple[DrawnMesh, Triangles]] = []
    missing, there = [], _files(folder)
    room = READ_AT_ONCE
    for mesh in (one for one in model.meshes if one.body in names):
        path = there.get(mesh.file.lower())
        if path is None:
            missing.append(mesh.file)
            continue
        try:
            surface = read_mesh(path)
        except Error as error:
            warnings.warn(f"{error}; it is left out", MeshWarning, stacklevel=2)
            continue
        room -= len(surface.corners)
        if room < 0:
            warnings.warn(f"{folder} has more meshes than are drawn, from {path.name} on", MeshWarning, stacklevel=2)
            break
        found.append((mesh, placed(mesh, surface)))
    if missing:
        some = ", ".join(list(dict.fromkeys(missing))[:NAMED]) + (", ..." if len(set(missing)) > NAMED else "")
        text = f"{folder} has {number_of(len(found), 'mesh file')} of {scene.name}, and not {some}"
        warnings.warn(text, MeshWarning, stacklevel=2)
    thin = thinned([surface for _, surface in found], CORNERS) if found else []
    sides = sides_of(scene.character)
    bones: list[Piece] = [
        Hull(names.index(mesh.body), sides[mesh.body], "bone", *shaded(surface))
        for (mesh, _), surface in zip(found, thin, strict=True)
        if len(surface.faces)
    ]
    drawn = {bone.body for bone in bones}
    return [one for one in pieces if one.layer not in ("bone", "hollow") or one.body not in drawn] + bones


def placed(mesh: DrawnMesh, surface: Triangles) -> Triangles:
    """A surface in the frame of its body; one that a scale mirrors keeps its outside."""
    scale = plain_vector(mesh.scale)
    turn = from_rotation_vector(plain_vector(mesh.orientation))
    corners: Floats = plain_vector(mesh.position) + rotate(turn, surface.corners * scale)
    return Triangles(corners, surface.faces if np.prod(scale) >= 0.0 else surface.faces[:, ::-1])


def _there(folder: Path, files: Sequence[str]) -> bool:
    found = _files(folder)
    return any(file.lower() in found for file in files)


def _files(folder: Path) -> Mapping[str, Path]:
    """Files of a folder and of those within it that meshes are kept in, by names in small letters."""
    found: dict[str, Path] = {}
    for name in WITHIN:
        try:
            with os.scandir(folder / name) as entries:
                for entry in entries:
                    found.setdefault(entry.name.lower(), Path(entry.path))
        except (FileNotFoundError, NotADirectoryError):
            continue
        except OSError as error:
            raise Error(f"{folder / name}: {unreadable(error)}") from None
    return found
