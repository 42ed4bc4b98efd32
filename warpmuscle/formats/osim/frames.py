"""Frames of a model by their paths, and what sockets, in all spellings of five versions, mean by a frame."""

from __future__ import annotations

import posixpath

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.records import Frame, Joint, Model, Muscle, OsimForce, Vec3

GROUND = "/ground"
OFFSETS = "PhysicalOffsetFrame"
BY_STATIONS = "StationDefinedFrame"
FRAMES = (OFFSETS, BY_STATIONS)
SIGNED_AXES = {sign + letter: (k, -1.0 if sign == "-" else 1.0) for sign in ("", "+", "-") for k, letter in
    enumerate("xyz")}  # fmt: skip
FLAT = 1.0e-9  # m^2, twice the area of a triangle that gives a frame no axes


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
        self._by_stations: dict[str, Element] = {}  # elements of frames that stations define, by path
        self._stations: dict[str, Element] = {}  # by path
        self._by_name: dict[str, list[str]] = {}

    def add(self, path: str, element: Element) -> None:
        """A body or the ground, and the frames within it."""
        self._put(path, Frame(path, element.line, "", np.eye(3), np.zeros(3)), element)
        self.add_owned(path, element)

    def add_owned(self, path: str, owner: Element) -> None:
        """The frames that an element owns, and theirs; `path` is that of the owner."""
        for holder in (owner.child("frames"), owner.child("components")):
            for child in holder.children if holder is not None else ():
                self.add_component(f"{path}/{child.name}", child)

    def add_component(self, path: str, element: Element) -> None:
        """A frame and those that it owns, or a station; other components are left alone."""
        if element.tag == OFFSETS:
            self._add_offset(path, element)
        elif element.tag == BY_STATIONS:
            element.used = True
            self._put(path, Frame(path, element.line, "?", np.eye(3), np.zeros(3)), element)
            self._by_stations[path] = element
            self.add_owned(path, element)
        elif element.tag in ("Station", "Marker"):
            self.add_station(path, element)

    def add_station(self, path: str, element: Element) -> None:
        """A point that may define a frame."""
        element.used = True
        self._stations[path] = element

    def _add_offset(self, path: str, element: Element) -> None:
        element.used = True
        rotation = turned(_three(element, "orientation"))
        translation = np.array(_three(element, "translation"))
        self._put(path, Frame(path, element.line, "?", rotation, translation), element)
        self.offsets.append((path, element))
        self.add_owned(path, element)

    def _put(self, path: str, frame: Frame, element: Element) -> None:
        if path in self._frames:
            element.fail(f"there is a frame {path!r} already, in line {self._frames[path].line}")
        self._frames[path] = frame
        self._by_name.setdefault(frame.name, []).append(path)

    def connect(self) -> None:
        """Give offset frames their parents, and frames that stations define their axes.

        Raises:
            SceneError: a frame hangs on none, or on itself; or stations are none, on several bodies, or on a line.
        """
        for path, element in self.offsets:
            frame = self._frames[path]
            parent = self.socket(element, path, "parent")
            self._frames[path] = Frame(path, frame.line, parent, frame.rotation, frame.translation)
        for path in self._by_stations:
            self._place(path, [])
        for path, element in self.offsets:
            self._base(path, element, [])

    def _base(self, path: str, element: Element, visited: list[str]) -> tuple[str, Floats, Floats]:
        """The body that a frame is fixed to, and its axes and origin there; `element` is who asks."""
        rotation, translation = np.eye(3), np.zeros(3)
        while self._frames[path].parent:
            if path in visited:
                element.fail("hangs on itself, by way of its parents")
            if self._frames[path].parent == "?":
                self._place(path, visited)
            visited = [*visited, path]
            frame = self._frames[path]
            translation = frame.translation + frame.rotation @ translation
            rotation = frame.rotation @ rotation
            path = frame.parent
        return path, rotation, translation

    def _place(self, path: str, visited: list[str]) -> None:
        """Find the axes and the origin of a frame that stations define, on their body."""
        if self._frames[path].parent != "?":
            return
        element = self._by_stations[path]
        if path in visited:
            element.fail("hangs on itself, by way of its stations")
        names = ("point_a", "point_b", "point_c", "origin_point")
        found = [self._station(element, path, name, [*visited, path]) for name in names]
        bodies = list(dict.fromkeys(body for body, _ in found))
        if len(bodies) > 1:
            element.fail(f"its stations are on different bodies, {bodies[0]} and {bodies[1]}")
        a, b, c, origin = (place for _, place in found)
        rotation = _axes_of(element, b - a, np.cross(b - a, c - a))
        self._frames[path] = Frame(path, element.line, bodies[0], rotation, origin)

    def _station(self, owner: Element, path: str, name: str, visited: list[str]) -> tuple[str, Floats]:
        """The body of a station that a frame at `path` names, and its place there."""
        socket = owner.child(f"socket_{name}")
        text = socket.word() if socket is not None else ""
        inside = posixpath.normpath(posixpath.join(path, text))
        last = text.rpartition("/")[2]
        named = [one for one in self._stations if one.rpartition("/")[2] == last]
        where = next((one for one in (inside, f"/{text}", *named) if text and one in self._stations), "")
        if not where:
            owner.fail(f"there is no station {text!r}, which <socket_{name}> names" if text else f"names no {name}")
        station = self._stations[where]
        body, rotation, translation = self._base(self.socket(station, where, "parent_frame"), owner, visited)
        return body, translation + rotation @ np.array(_three(station, "location"))

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


def _three(element: Element, tag: str) -> list[float]:
    """The three numbers of a child, 0 where there is none or an empty one."""
    found = element.child(tag)
    return [0.0, 0.0, 0.0] if found is None or not found.words() else found.numbers(3)


def _axes_of(element: Element, ab: Floats, normal: Floats) -> Floats:
    """The axes (3, 3) of a frame, one along an edge of a triangle and one along its normal."""
    if not np.linalg.norm(normal) > FLAT:
        element.fail("its points a, b and c lie on a line")
    axes = np.zeros((3, 3))
    taken = []
    for tag, usual, along in (("ab_axis", "+x", ab), ("ab_x_ac_axis", "+y", normal)):
        given = element.child(tag)
        word = (given.word() if given is not None else "").lower() or usual
        if word not in SIGNED_AXES:
            element.fail(f"<{tag}> is one of +x, -x, +y, -y, +z and -z, not {word!r}")
        column, sign = SIGNED_AXES[word]
        axes[:, column] = sign * along / np.linalg.norm(along)
        taken.append(column)
    if taken[0] == taken[1]:
        element.fail("<ab_axis> and <ab_x_ac_axis> must be different axes")
    last = 3 - sum(taken)
    axes[:, last] = np.cross(axes[:, (last + 1) % 3], axes[:, (last + 2) % 3])
    return axes


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


def note(notes: Notes, model: Model, record: Joint | Muscle | OsimForce, reason: str) -> None:
    """Note that something of a model is left out, or otherwise than in OpenSim, and why."""
    notes.ignore(model.file, record.line, f"{record.kind} {record.name}", reason)
