"""Joints of an OpenSim model with their frames on the bodies of the scene that is made of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.build import root_of
from warpmuscle.formats.osim.build_skeleton import build_skeleton
from warpmuscle.formats.osim.frames import GROUND
from warpmuscle.formats.osim.moves import Coordinates
from warpmuscle.formats.osim.placement import Placement
from warpmuscle.formats.osim.read import read
from warpmuscle.formats.osim.records import Model
from warpmuscle.formats.osim.tree import branches, joined


@dataclass(frozen=True)
class FrameOnBody:
    """A frame on a body of a scene, in the body's own axes there."""

    body: str
    origin: Floats  # (3,) m, from its centre of mass
    axes: Floats  # (3, 3) the axes of OpenSim's body as columns
    center: Floats  # (3,) m, its centre of mass in OpenSim's body


@dataclass(frozen=True)
class JointFrames:
    """A joint of a model between two bodies."""

    name: str
    parent: FrameOnBody
    child: FrameOnBody


def body_frames(path: str | Path) -> dict[str, FrameOnBody]:
    """Frames of all bodies of a model file, by their names there; see `joint_frames`."""
    _, placement = _placement(path)

    def frame(name: str) -> FrameOnBody:
        on = placement.body(name)
        return FrameOnBody(on.name, on.point(np.zeros(3)), on.axes, on.center)

    return {path.rpartition("/")[2]: frame(path) for path in placement.bodies if path != GROUND}


def joint_frames(path: str | Path) -> list[JointFrames]:
    """All joints of a model file, in the order of the file.

    Raises:
        SceneError: it cannot be read or represented; with file and line.
    """
    model, placement = _placement(path)

    def frame(name: str) -> FrameOnBody:
        body, point = placement.point(name, np.zeros(3))
        on = placement.body(name)
        return FrameOnBody(body, np.array(point), on.axes, on.center)

    return [JointFrames(one.name, frame(one.parent), frame(one.child)) for one in model.joints]


def _placement(path: str | Path) -> tuple[Model, Placement]:
    """A model file, and where its bodies are among those of the scene that is made of it."""
    notes = Notes()
    model = read(Path(path), notes)
    joined(model)
    coordinates = Coordinates(model)
    tree = branches(model, coordinates)
    return model, build_skeleton(model, tree, root_of(model, tree, coordinates), coordinates, notes).placement
