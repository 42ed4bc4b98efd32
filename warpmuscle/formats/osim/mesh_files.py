"""Files of triangles that bodies of a model are drawn with, by their names only; who draws looks for them."""

from __future__ import annotations

import numpy as np

from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import Frames, turned
from warpmuscle.formats.osim.placement import Placement, rotation_vector, vector
from warpmuscle.formats.osim.properties import Properties
from warpmuscle.formats.osim.records import DrawnMesh, Model, Vec3
from warpmuscle.scene import DrawnMesh as SceneMesh
from warpmuscle.scene import drawable

ONE: Vec3 = (1.0, 1.0, 1.0)
UNTURNED = (0.0,) * 6


def read_meshes(holder: Element, path: str, model: Model, own: Properties) -> None:
    """The meshes that a body, the ground or a frame is drawn with, in the layouts of versions 1 to 4."""
    attached = holder.child("attached_geometry") if _names(holder, "mesh_file") else None
    for mesh in attached.children if attached is not None else ():
        file = mesh.child("mesh_file")
        if file is not None:
            _add(model, path, mesh, file.word(), UNTURNED, own.vector(mesh, "scale_factors", ONE))
    shown = holder.child("VisibleObject") if _names(holder, "geometry_file", "geometry_files") else None
    if shown is None:
        return
    scale = own.vector(shown, "scale_factors", ONE)
    listed = shown.child("geometry_files")
    for name in listed.words() if listed is not None else ():
        _add(model, path, shown, name, UNTURNED, scale)
    geometry = shown.child("GeometrySet")
    for mesh in geometry.objects() if geometry is not None else ():
        file = mesh.child("geometry_file")
        if file is not None:
            placed = mesh.child("transform")
            transform = tuple(placed.numbers(6)) if placed is not None and placed.words() else UNTURNED
            x, y, z = (a * b for a, b in zip(scale, own.vector(mesh, "scale_factors", ONE), strict=True))
            _add(model, path, mesh, file.word(), transform, (x, y, z))


def build_meshes(model: Model, placement: Placement, bodies: set[str]) -> list[SceneMesh]:
    """The meshes of a scene's bodies, of which `ground` may be none."""
    found = []
    for mesh in model.meshes:
        body, position = placement.point(mesh.frame, mesh.translation)
        if body in bodies:
            turn = rotation_vector(placement.axes(mesh.frame) @ turned(mesh.rotation))
            found.append(SceneMesh(body, mesh.file, position, turn, vector(np.array(mesh.scale))))
    return found


def _names(holder: Element, *tags: str) -> bool:
    """Whether anything within an element names a file."""
    return any(one.tag in tags and one.text.strip() for one in holder.all())


def _add(model: Model, frame: str, element: Element, named: str, transform: tuple[float, ...], scale: Vec3) -> None:
    """Keep a mesh by the last part of its file's name, if it is one of a kind that is read."""
    for inner in element.all():
        inner.used = True  # colours, sockets and opacity
    file = named.replace("\\", "/").rpartition("/")[2]
    if drawable(file):
        rx, ry, rz, x, y, z = transform
        model.meshes.append(DrawnMesh(file, frame, (rx, ry, rz), (x, y, z), scale))


def read_all(holders: list[tuple[str, Element]], frames: Frames, model: Model, own: Properties) -> None:
    """The meshes of bodies and the ground, by their paths, and of the frames on them."""
    for path, holder in (*holders, *frames.offsets):
        read_meshes(holder, path, model, own)
