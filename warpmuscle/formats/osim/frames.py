"""Frames of a model by their paths, and what sockets, in all spellings of five versions, mean by a frame."""

from __future__ import annotations

import posixpath

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.records import Force, Frame, Joint, Model, Muscle, Vec3

GROUND = "/ground"
OFFSETS = "PhysicalOffsetFrame"


def turned(angles: Vec3 | list[float]) -> Floats:
    """The matrix of turns about x, the new y and the newer z axis, rad: OpenSim's `orientation`."""
    matrix = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        j, k = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[j, j], turn[j, k], turn[k, j], turn[k, k] = c, -s, s, c
        matrix = matrix @ turn
    return matrix


class Frames:
    """All frames, found first and connected afterwards, since they may name each other in any order."""

    def __init__(self, model: Model) -> None:
        self._frames = model.frames
        self.offsets: list[tuple[str, Element]] = []  # paths and elements of frames that hang on others
        self._by_name: dict[str, list[str]] = {}

    def add(self, path: str, element: Element) -> None:
        """A body or the ground, and the frames within it."""
        self._put(path, Frame(path, element.line, "", np.eye(3), np.zeros(3)), element)
        self.add_owned(path, element)

    def add_owned(self, path: str, owner: Element) -> None:
        """The frames that an element owns, and theirs; `path` is that of the owner."""
        for holder in (owner.child("frames"), owner.child("components")):
            for child in holder.children if holder is not None else ():
                if child.tag == OFFSETS:
                    self.add_offset(f"{path}/{child.name}", child)

    def add_offset(self, path: str, element: Element) -> None:
        """An offset frame and those that it owns."""
        element.used = True
        place, turn = element.child("translation"), element.child("orientation")
        rotation = turned(turn.numbers(3)) if turn is not None else np.eye(3)
        translation = np.array(place.numbers(3)) if place is not None else np.zeros(3)
        self._put(path, Frame(path, element.line, "?", rotation, translation), element)
        self.offsets.append((path, element))
        self.add_owned(path, element)

    def _put(self, path: str, frame: Frame, element: Element) -> None:
        if path in self._frames:
            element.fail(f"there is a frame {path!r} already, in line {self._frames[path].line}")
        self._frames[path] = frame
        self._by_name.setdefault(frame.name, []).append(path)

    def connect(self) -> None:
        """Give offset frames their parents.

        Raises:
            SceneError: a frame hangs on none, or on itself.
        """
        for path, element in self.offsets:
            frame = self._frames[path]
            parent = self.socket(element, path, "parent")
            self._frames[path] = Frame(path, frame.line, parent, frame.rotation, frame.translation)
        for path, element in self.offsets:
            visited = [path]
            while self._frames[visited[-1]].parent:
                visited.append(self._frames[visited[-1]].parent)
                if visited[-1] in visited[:-1] or len(visited) > len(self._frames):
                    element.fail("hangs on itself, by way of its parents")

    def socket(self, element: Element, path: str, name: str) -> str:
        """Path of the frame that a socket of an element at `path` names."""
        socket = element.child(f"socket_{name}")
        if socket is None or not socket.word():
            element.fail(f"names no frame: there is no <socket_{name}>")
        return self.meant(socket, path)

    def meant(self, socket: Element, path: str) -> str:
        """Path of the frame that the text of an element names, which an element at `path` holds."""
        text = socket.word()
        inside = posixpath.normpath(posixpath.join(path, text))
        for candidate in (inside, f"/{text}", f"/bodyset/{text}", f"/componentset/{text}"):
            if candidate in self._frames:
                return candidate
        named = self._by_name.get(text.rpartition("/")[2], [])
        bodies = [found for found in named if not self._frames[found].parent]
        if len(bodies) == 1 or len(named) == 1:
            return (bodies or named)[0]
        socket.fail(f"there is no frame {text!r}" if not named else f"{text!r} may be {' or '.join(named[:4])}")


def on_body(model: Model, path: str) -> tuple[str, Floats, Floats]:
    """The body or ground that a frame is fixed to, and the frame's axes (3, 3) and origin (3,) in the body's frame."""
    frame = model.frames[path]
    rotation, translation = frame.rotation, frame.translation
    while frame.parent:
        frame = model.frames[frame.parent]
        translation = frame.translation + frame.rotation @ translation
        rotation = frame.rotation @ rotation
    return frame.path, rotation, translation


def refused(model: Model, line: int, message: str) -> SceneError:
    """An error at a line of a model's file."""
    return SceneError(message, file=model.file, line=line)


def note(notes: Notes, model: Model, record: Joint | Muscle | Force, reason: str) -> None:
    """Note that something of a model is left out, or otherwise than in OpenSim, and why."""
    notes.ignore(model.file, record.line, f"{record.kind} {record.name}", reason)
