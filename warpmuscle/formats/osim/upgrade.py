"""Old layouts brought into that of version 4, and names given once each, before anything is read."""

from __future__ import annotations

from warpmuscle.formats.lines import Notes
from warpmuscle.formats.osim.components import HOLDERS, put_into_sets
from warpmuscle.formats.osim.elements import Element
from warpmuscle.formats.osim.frames import FRAMES

RENAMED = {  # classes and sets, as OpenSim itself takes them
    "ActuatorSet": "ForceSet", "MuscleWrap": "PathWrap", "MuscleWrapSet": "PathWrapSet", "MusclePoint": "PathPoint",
    "MuscleViaPoint": "ConditionalPathPoint", "MovingMusclePoint": "MovingPathPoint",
    "MusclePointSet": "PathPointSet", "attachments": "PathPointSet",
}  # fmt: skip
SOCKETS = {  # what names a frame or coordinate in an old layout: its socket
    "PathPoint": {"body": "parent_frame"},
    "ConditionalPathPoint": {"body": "parent_frame", "coordinate": "coordinate"},
    "MovingPathPoint": {
        "body": "parent_frame", "x_coordinate": "x_coordinate", "y_coordinate": "y_coordinate",
        "z_coordinate": "z_coordinate",
    },
    "Marker": {"body": "parent_frame"},
    "ContactSphere": {"body_name": "frame"}, "ContactHalfSpace": {"body_name": "frame"},
    "ContactMesh": {"body_name": "frame"},
    **{key: {"body_1": "body_1", "body_2": "body_2"} for key in ("PointConstraint", "ConstantDistanceConstraint")},
    "PointOnLineConstraint": {"line_body": "line_body", "follower_body": "follower_body"},
}  # fmt: skip
WITH_PLACES = ("WeldConstraint", "BushingForce", "ExpressionBasedBushingForce", "FunctionBasedBushingForce")
CONSTRAINTS = ("CoordinateCouplerConstraint", "PointConstraint", "WeldConstraint", "PointOnLineConstraint",
    "ConstantDistanceConstraint", "RollingOnSurfaceConstraint")  # fmt: skip

SETS = ("JointSet", "ForceSet", "ContactGeometrySet", "MarkerSet", "ComponentSet", "ConstraintSet")
UNREVERSED = 40000  # version of the file from which on a joint has no `reverse`
BODIES = "BodySet"


def upgraded(model: Element, version: int) -> None:
    """Bring a model into the layout of version 4, in place; one that has it stays as it is.

    Raises:
        SceneError: the model has an engine that OpenSim itself no longer reads.
    """
    _engine(model)
    for element in list(model.all()):
        element.tag = RENAMED.get(element.tag, element.tag)
        _connectors(element)
        _within_path(element)
        for old, socket in SOCKETS.get(element.tag, {}).items():
            _rename(element, old, f"socket_{socket}")
    for element in list(model.all()):
        if version <= 20301:
            _loose_path(element)
        if element.tag in WITH_PLACES:
            _places(element)
        _enabled(element)
    _bodies(model)
    put_into_sets(model)
    for joint in joints_of(model):
        _joint(joint, version)


def joints_of(model: Element) -> list[Element]:
    """The joints of a model in its layout of version 4."""
    joint_set = next((child for child in model.children if child.tag == "JointSet"), None)
    return [] if joint_set is None else joint_set.objects()


def _first(element: Element, tag: str) -> Element | None:
    return next((child for child in element.children if child.tag == tag), None)


def _rename(element: Element, old: str, new: str) -> None:
    for child in element.children:
        if child.tag == old and not child.children:
            child.tag = new


def _made(tag: str, near: Element, text: str = "", name: str = "", children: list[Element] | None = None) -> Element:
    """An element that the file does not have, at the place of one that it has."""
    return Element(tag, near.file, near.line, name, text, children or [], used=True)


def _engine(model: Element) -> None:
    """Version 1 keeps bodies and constraints in an engine within the model."""
    engine = _first(model, "DynamicsEngine")
    if engine is None:
        return
    for kind in engine.children:
        if kind.tag != "SimbodyEngine":
            kind.fail("a model with this engine is older than version 1.6; OpenSim 2 or 3 can convert it")
        model.children.extend(kind.children)
    model.children.remove(engine)


def _connectors(element: Element) -> None:
    """Before version 4.0 was out, sockets were called connectors, and `_connectee_name`."""
    connectors = _first(element, "connectors")
    if connectors is not None:
        for connector in connectors.children:
            named = [child for child in connector.children if child.tag in ("connectee_name", "connected_to_name")]
            if named:
                element.children.append(_made(f"socket_{connector.name}", connector, named[0].text))
        element.children.remove(connectors)
    for child in element.children:
        if child.tag.startswith("socket_"):
            child.tag = child.tag.removesuffix("_connectee_name")


def _within_path(element: Element) -> None:
    """A path may stand in an element of its property's name."""
    holder = _first(element, "path")
    if holder is not None and holder.children:
        element.children[element.children.index(holder)] = holder.children[-1]


def _loose_path(element: Element) -> None:
    """Points and wraps of a muscle stood in itself, not in a path; and its pennation had another name."""
    loose = [child for child in element.children if child.tag in ("PathPointSet", "PathWrapSet")]
    if loose and element.tag != "GeometryPath":
        element.children = [child for child in element.children if child not in loose]
        element.children.append(_made("GeometryPath", loose[0], name="geometrypath", children=loose))
    _rename(element, "pennation_angle", "pennation_angle_at_optimal")


def _enabled(element: Element) -> None:
    """What was disabled is not applied, or not enforced."""
    for child in element.children:
        if child.tag == "isDisabled":
            child.tag = "isEnforced" if element.tag in CONSTRAINTS else "appliesForce"
            child.text = str(not child.truth()).lower() if child.words() else ""
            child.used = False


def _places(element: Element) -> None:
    """What is between two frames named bodies, and places and orientations on them."""
    for number in ("1", "2"):
        body = _first(element, f"body_{number}")
        if body is None:
            continue
        frame = _offset(element, f"{body.text.strip()}_offset_{number}", body.text.strip(),
            f"location_body_{number}", f"orientation_body_{number}")  # fmt: skip
        _frames(element).append(frame)
        element.children.remove(body)
        element.children.append(_made(f"socket_frame{number}", body, frame.name))


def _bodies(model: Element) -> None:
    """Joints stood in the bodies that they carry, and the ground was a body among the others."""
    bodies = _first(model, "BodySet")
    objects = _first(bodies, "objects") if bodies is not None else None
    if objects is None:
        return
    found: list[Element] = []
    for body in list(objects.children):
        holder = _first(body, "Joint")
        if holder is not None:
            body.children.remove(holder)
            for joint in holder.children:
                found.append(joint)
                joint.children.append(_made("socket_child_frame", joint, body.name))
        if body.name == "ground" and _first(model, "Ground") is None:
            objects.children.remove(body)
            body.tag = "Ground"
            model.children.append(body)
    if found:
        model.children.append(_made("JointSet", found[0], children=[_made("objects", found[0], children=found)]))


def _joint(joint: Element, version: int) -> None:
    """A joint had places and orientations on its bodies, and its coordinates in a set."""
    coordinate_set = _first(joint, "CoordinateSet")
    if coordinate_set is not None:
        joint.children.remove(coordinate_set)
        joint.children.append(_made("coordinates", coordinate_set, children=coordinate_set.objects()))
    _rename(joint, "parent_body", "socket_parent_frame")
    _rename(joint, "socket_parent_body", "socket_parent_frame")
    _rename(joint, "socket_child_body", "socket_child_frame")
    for end, places, turns in (
        ("parent", ("location_in_parent",), ("orientation_in_parent",)),
        ("child", ("location", "location_in_child"), ("orientation", "orientation_in_child")),
    ):
        socket = _first(joint, f"socket_{end}_frame")
        given = [child.tag for child in joint.children if child.tag in (*places, *turns)]
        if socket is None or not given:
            continue
        place = next((tag for tag in given if tag in places), places[0])
        turn = next((tag for tag in given if tag in turns), turns[0])
        frame = _offset(joint, f"{end}_offset", socket.text.strip(), place, turn)
        _frames(joint).append(frame)
        socket.text = frame.name
    if version < UNREVERSED:
        _reverse(joint)
    _axes(joint)


def _reverse(joint: Element) -> None:
    """A joint that moved its parent from its child has the two the other way round."""
    reverse = _first(joint, "reverse")
    ends = [_first(joint, f"socket_{end}_frame") for end in ("parent", "child")]
    if reverse is not None and reverse.words() and reverse.truth() and None not in ends:
        parent, child = ends
        parent.tag, child.tag = child.tag, parent.tag  # type: ignore[union-attr]


def _axes(joint: Element) -> None:
    """Version 1 had a set of axes, each with `is_rotation` and one `coordinate`, and none for those without motion.

    An axis without a function moved by its coordinate itself.
    """
    old = _first(joint, "TransformAxisSet")
    if old is None:
        return
    named: list[Element] = []
    for axis in old.objects():
        turning = _first(axis, "is_rotation")
        kind = "rotation" if turning is not None and turning.truth() else "translation"
        axis.name = f"{kind}{1 + sum(other.name.startswith(kind) for other in named)}"
        _rename(axis, "coordinate", "coordinates")
        axis.children = [child for child in axis.children if child is not turning]
        if not {child.tag for child in axis.children} - {"coordinates", "axis"}:
            axis.children.append(_made("LinearFunction", axis))
        named.append(axis)
    joint.children.remove(old)
    joint.children.append(_made("SpatialTransform", old, children=named))


def _frames(element: Element) -> list[Element]:
    """The frames that an element owns."""
    found = _first(element, "frames")
    if found is None:
        found = _made("frames", element)
        element.children.append(found)
    return found.children


def _offset(owner: Element, name: str, parent: str, place: str, turn: str) -> Element:
    """An offset frame from a body's name and from the owner's children with place and orientation, which it takes.

    OpenSim brings old layouts to its own as text, in which these numbers have six digits.
    """
    frame = _made("PhysicalOffsetFrame", owner, name=name)
    frame.children.append(_made("socket_parent", owner, parent))
    for tag, new in ((place, "translation"), (turn, "orientation")):
        found = _first(owner, tag)
        if found is not None:
            owner.children.remove(found)
            found.tag = new
            found.text = " ".join(map(_six_digits, found.text.split()))
            frame.children.append(found)
    return frame


def _six_digits(word: str) -> str:
    try:
        return f"{float(word):.6g}"
    except ValueError:
        return word


def rename_duplicates(model: Element, notes: Notes) -> None:
    """Give what has no name, or that of another one beside it, the name that OpenSim gives it.

    OpenSim calls a PinJoint without a name `pinjoint`, and the second `back` of a set `back_0`. It lets coordinates of
    two joints have one name, which stands for different columns of a motion: here the later one is called after the
    body that its joint carries.

    Args:
        model: in the layout of version 4.
        notes: gets every new name.
    """
    for element in list(model.all()):
        if element.tag in HOLDERS:
            _named_all(element.children)
            _distinct(element.children, notes)
    for child in model.children:
        if child.tag in (*SETS, BODIES):
            for holder in child.children:
                if holder.tag == "objects":
                    _named_all(holder.children)
                    if child.tag != BODIES:
                        _distinct(holder.children, notes)
    for joint in joints_of(model):
        _named_all(coordinates := _coordinates(joint))
        _distinct(coordinates, notes)
    _rename_coordinates(model, notes)


def _named_all(members: list[Element]) -> None:
    for member in members:
        member.name = member.name or member.tag.lower()


def _distinct(members: list[Element], notes: Notes) -> None:
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
    holders = [holder for holder in joint.children if holder.tag == "coordinates"]
    return holders[-1].children if holders else []  # of two, the last one counts


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
