"""What a scene that was made of an OpenSim model keeps of it."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.character.tree import Joint
from warpmuscle.scene.displacement import Coupling
from warpmuscle.scene.number import Vector
from warpmuscle.scene.part import Part


class Marker(Part):
    """A point on a body, as on a subject's skin."""

    body: str
    position: Annotated[Vector, "m"]  # in the body's frame


class DrawnMesh(Part):
    """A file of triangles that a body is drawn with, where a folder has it; nothing is computed with it."""

    body: str
    file: str  # its name, without a folder: .vtp, .stl or .obj
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of the file's origin, in the body's frame
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)  # of the file's axes, as a rotation vector
    scale: Annotated[Vector, "1"] = (1.0, 1.0, 1.0)  # along the file's axes


def drawable(file: str) -> bool:
    """Whether this may be the name of a mesh: of a file of a known kind, in no other folder."""
    plain = bool(file) and len(file) < 256 and not file.startswith(".") and file.isprintable()
    return plain and not set(file) & set('/\\:*?"<>|') and file.lower().endswith((".vtp", ".stl", ".obj"))


class BallCoordinates(Part):
    """Coordinates of a model that are angles of a ball joint here: about its axes swing, swing x twist and twist."""

    names: tuple[str, str, str]
    turned_round: bool = False  # whether the second one counts the other way


class OpenSim(Part):
    """What a scene that was made of an OpenSim model keeps of it, so that motions can go back in the model's words.

    The root's joint is given as a coupled one would be, but each of its displacements is a line over a coordinate of
    its own, named in `root_coordinates`: first those of its rotations, then those of its translations. Of all other
    joints a coordinate of the model has the name and the value of the joint.
    """

    file: str = ""
    root: Joint | None = None  # from `ground`, whose axes are the world's, to the root body; none: the root is fixed
    root_coordinates: list[str] = []
    locked: Annotated[dict[str, float], "rad or m"] = {}  # coordinates that do not move, and where they are
    couplers: dict[str, Coupling] = {}  # coordinates that are functions of that of a joint
    markers: dict[str, Marker] = {}
    angles: list[str] = []  # coordinates that OpenSim's files have in degrees
    balls: dict[str, BallCoordinates] = {}  # by ball joint; of all other joints coordinates have the joint's name
    ranges: Annotated[dict[str, tuple[float, float]], "rad or m"] = {}  # within which inverse kinematics keeps them
    controls: Annotated[dict[str, tuple[float, float]], "1"] = {}  # of muscles, least and greatest; of others the least
    # activation and 1: within which static optimisation keeps activations
    meshes: list[DrawnMesh] = []  # that it is drawn with
    sideways: Annotated[float, "m"] = 0.0  # of a planar root: how far to the left of the plane x = 0 the model has it
