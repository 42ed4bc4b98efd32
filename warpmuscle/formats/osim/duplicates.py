"""Names that a model has twice: the later ones get others, before anything is read."""

from __future__ import annotations

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import FRAMES
from warpmuscle.formats.osim.upgrade import joints_of

SETS = ("JointSet", "ForceSet", "ContactGeometrySet", "MarkerSet", "ComponentSet", "ConstraintSet")
HOLDERS = ("frames", "components")


def rename_duplicates(model: Element, notes: Notes) -> None:
    """Give what has the name of another one beside it the name that OpenSim gives it, and coordinates their body's.

    OpenSim calls the second `back` of a set `back_0`. It lets coordinates of two joints have one name, which stands
    for different columns of a motion: here the later one is called after the body that its joint carries.

    Args:
        model: in the layout of version 4.
        notes: gets every new name.
    """
    for element in list(model.all()):
        if element.tag in HOLDERS:
            _rename(element.children, notes)
    for child in model.children:
        if child.tag in SETS:
            for holder in child.children:
                if holder.tag == "objects":
                    _rename(holder.children, notes)
    _rename_coordinates(model, notes)


def _rename(members: list[Element], notes: Notes) -> None:
    taken = {member.name for member in members}
    seen: set[str] = set()
    for member in members:
        if member.name and member.name in seen:
            old, member.name = member.name, _unused(member.name, taken)
            _tell(member, old, notes)
            taken.add(member.name)
        seen.add(member.name)


def _unused(name: str, taken: set[str]) -> str:
    number = 0
    while f"{name}_{number}" in taken:
        number += 1
    return f"{name}_{number}"


def _rename_coordinates(model: Element, notes: Notes) -> None:
    owners: dict[str, Element] = {}
    joints = joints_of(model)
    taken = {coordinate.name for joint in joints for coordinate in _coordinates(joint)}
    for joint in joints:
        for coordinate in _coordinates(joint):
            old = coordinate.name
            if not old or owners.setdefault(old, joint) is joint:
                continue
            new = f"{_carried(model, joint)}_{old}"
            coordinate.name = new if new not in taken else _unused(new, taken)
            taken.add(coordinate.name)
            _tell(coordinate, old, notes)
            _refer(model, joint, old, coordinate.name)


def _coordinates(joint: Element) -> list[Element]:
    return [one for holder in joint.children if holder.tag == "coordinates" for one in holder.children]


def _carried(model: Element, joint: Element) -> str:
    """The name of the body that a joint carries, as far as names alone tell."""
    frames: dict[str, tuple[Element, Element]] = {}  # by name, with the element that owns it
    stations: dict[str, Element] = {}
    for owner in (*model.all(), *joint.all()):
        for holder in owner.children if owner.tag not in HOLDERS else ():
            for child in holder.children if holder.tag in HOLDERS else ():
                if child.tag in FRAMES:
                    frames[child.name] = child, owner
                elif child.tag == "Station":
                    stations[child.name] = child
    name = _named(joint, "child_frame")
    for _ in range(len(frames)):
        if name not in frames:
            break
        frame, owner = frames[name]
        station = stations.get(_named(frame, "point_a"), frame)
        name = _named(frame, "parent") or _named(station, "parent_frame")
        name = owner.name if name == ".." else name
    return name or joint.name


def _named(element: Element, socket: str) -> str:
    """The last name in a socket of an element."""
    text = next((child.text for child in element.children if child.tag == f"socket_{socket}"), "")
    return text.strip().rpartition("/")[2]


def _refer(model: Element, joint: Element, old: str, new: str) -> None:
    """Let axes of the joint, and paths of the whole model to its coordinate, name that by its new name."""
    for element in joint.all():
        if element.tag == "coordinates" and not element.children:
            element.text = " ".join(new if word == old else word for word in element.text.split())
    end = f"{joint.name}/{old}"
    for element in model.all():
        if element.text and end in element.text:
            words = element.text.split()
            if any(_ends(word, end) for word in words):
                element.text = " ".join(word.removesuffix(old) + new if _ends(word, end) else word for word in words)


def _ends(word: str, path: str) -> bool:
    return word == path or word.endswith(f"/{path}")


def _tell(element: Element, old: str, notes: Notes) -> None:
    reason = f"there is another one of this name before it; it is called {element.name!r} here"
    notes.ignore(element.file, element.line, f"{element.tag} {old}", reason)
