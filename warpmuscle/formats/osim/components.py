"""Bodies, joints, forces and the like that stand among a model's loose components, put into the sets of their kind.

OpenSim runs a component wherever it stands (`Model::addComponent`): in the model's `components` or ComponentSet, or in
the `components` of another one, of a body for example.
"""

from __future__ import annotations

import posixpath

from warpmuscle.formats.osim.elements import Element

SETS = {  # by how the name of a class ends; without a set are frames, stations, reporters and probes
    "Body": "BodySet", "Joint": "JointSet", "Constraint": "ConstraintSet", "Controller": "ControllerSet",
    "Marker": "MarkerSet",
    **dict.fromkeys(("Force", "Muscle", "Actuator", "Ligament", "Spring"), "ForceSet"),
    **dict.fromkeys(
        ("ContactSphere", "ContactHalfSpace", "ContactMesh", "ContactCylinder", "ContactEllipsoid", "ContactTorus"),
        "ContactGeometrySet"),
}  # fmt: skip
HOLDERS = ("frames", "components")
HOLDER, LOOSE = "components", "ComponentSet"
SOCKET = "socket_"


def put_into_sets(model: Element) -> None:
    """Move loose components of known kinds to the ends of their sets, in place, and let addresses follow them.

    Args:
        model: whose bodies and joints are in sets already.
    """
    moved: dict[str, str] = {}  # old addresses, new ones
    parts = list(model.children)
    _within(model, model, "", moved)
    for part in parts:
        address = part.tag.lower()
        if part.tag == "Ground":
            _within(model, part, "/ground", moved)
        for holder in part.children if part.tag in (LOOSE, *SETS.values()) else ():
            if holder.tag == "objects" and part.tag == LOOSE:
                _empty(model, holder, f"/{address}", moved)
            elif holder.tag == "objects":
                for member in list(holder.children):
                    _within(model, member, f"/{address}/{member.name}", moved)
    if moved:
        for element in model.all():
            if element.text.lstrip().startswith("/"):
                element.text = " ".join(_followed(word, moved) for word in element.text.split())


def _within(model: Element, owner: Element, path: str, moved: dict[str, str]) -> None:
    for holder in list(owner.children):
        if holder.tag == HOLDER:
            _empty(model, holder, path, moved)


def _empty(model: Element, holder: Element, path: str, moved: dict[str, str]) -> None:
    """Move what a holder has, and what its members hold; `path` is that of the holder's owner."""
    for member in list(holder.children):
        own = f"{path}/{member.name}"
        _within(model, member, own, moved)
        kind = _kind(member.tag)
        if kind is None:
            continue
        _absolute(member, own)
        holder.children.remove(member)
        _objects(model, kind, member).append(member)
        moved[own] = f"/{kind.lower()}/{member.name}"


def _absolute(part: Element, path: str) -> None:
    """Let what a part at a path names by steps up from there be named by its address."""
    for child in part.children:
        text = child.text.strip()
        if child.tag.startswith(SOCKET) and text.startswith("."):
            child.text = posixpath.normpath(posixpath.join(path, text))
        for owned in child.children if child.tag in HOLDERS else ():
            _absolute(owned, f"{path}/{owned.name}")


def _kind(tag: str) -> str | None:
    """The set for a class."""
    tag = tag.removesuffix("_Deprecated")
    return next((kind for end, kind in SETS.items() if tag.endswith(end)), None)


def _objects(model: Element, name: str, near: Element) -> list[Element]:
    """The members of a set of a model, which gets one if it has none."""
    made = next((child for child in model.children if child.tag == name), None)
    if made is None:
        made = Element(name, near.file, near.line, name.lower(), used=True)
        model.children.append(made)
    objects = next((child for child in made.children if child.tag == "objects"), None)
    if objects is None:
        objects = Element("objects", near.file, near.line, used=True)
        made.children.append(objects)
    return objects.children


def _followed(word: str, moved: dict[str, str]) -> str:
    """An address, or the new one of the component that it begins with."""
    start = max((old for old in moved if word == old or word.startswith(f"{old}/")), key=len, default="")
    return moved[start] + word[len(start) :] if start else word
