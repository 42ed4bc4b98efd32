"""The triangles of one file, whatever its format; damaged and hostile files give an error of one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.core.files import read_file, unreadable
from warpmuscle.core.limits import GREATEST_NUMBER, check_size
from warpmuscle.formats.meshes import obj, stl, vtp
from warpmuscle.formats.meshes.triangles import MeshError, Triangles

FORMATS = {".vtp": vtp.triangles, ".stl": stl.triangles, ".obj": obj.triangles}


def read_mesh(path: Path) -> Triangles:
    """The corners and triangles of a file, in the file's axes and units.

    Raises:
        Error: it cannot be read, is too large, damaged, or of another format; with its path.
    """
    if path.suffix.lower() not in FORMATS:
        raise Error(f"{path}: a mesh is a file of one of {', '.join(FORMATS)}")
    try:
        data = read_file(path, "mesh")
    except (OSError, ValueError) as error:
        raise Error(f"{path}: {unreadable(error)}") from None
    try:
        found = FORMATS[path.suffix.lower()](data)
        _check(found)
    except MeshError as error:
        raise Error(f"{path}: {error}") from None
    return found


def _check(found: Triangles) -> None:
    """That there are triangles, between corners that there are and that are somewhere."""
    check_size("triangles", len(found.faces), MeshError)
    if not len(found.faces):
        raise MeshError("there are no triangles in it")
    if found.faces.min() < 0 or found.faces.max() >= len(found.corners):
        raise MeshError("a triangle names a corner that does not exist")
    if not np.all(np.abs(found.corners) < GREATEST_NUMBER):  # so are what is not a number, and infinite ones
        raise MeshError("a corner is at no finite place")
