"""Joints of `.rbs` files: their axes, points and limits."""

from __future__ import annotations

from warpmuscle.formats.lines import Line, Lines, Notes
from warpmuscle.formats.rbs_blocks import JOINTS, MISPLACED, Contents, Triple, attributes_of, triple_of
from warpmuscle.scene import Joint
from warpmuscle.scene.joints import JointType

BALL_LIMIT_DAMPING = 8.0  # N m s/rad: the original's soft stops, (1 - ERP) / CFM = 0.8 / 0.1


def read_joint(opening: Line, lines: Lines, contents: Contents) -> tuple[str, Joint]:
    """Name and joint up to `/Joint`."""
    notes, kind = lines.notes, JOINTS[opening.keyword]
    names: dict[str, tuple[str, Line]] = {}
    positions: dict[str, Triple] = {}
    limits_line: Line | None = None
    actuation: Line | None = None
    for line in attributes_of(opening, "/Joint", lines):
        if line.keyword in ("name", "parent", "child"):
            names[line.keyword] = (line.word("a name"), line)
        elif line.keyword in ("jointPPos", "jointCPos"):
            positions[line.keyword] = line.triple("m", notes)
        elif line.keyword == "jointLimits":
            limits_line = line
        elif line.keyword == "actuationType":
            actuation = line
        else:
            line.ignore(notes, MISPLACED)
    for needed in ("name", "parent", "child"):
        if needed not in names:
            raise opening.error(f"this joint has no {needed}")
    name = names["name"][0]
    key = f"character.joints.{name}"
    if actuation is not None and actuation.word("muscle") == "muscle":
        contents.driven[name] = actuation
    elif actuation is not None:
        actuation.ignore(notes, "the only type known is muscle")
    opening.mark(notes, key)
    names["parent"][1].mark(notes, f"{key}.parent")
    names["child"][1].mark(notes, f"{key}.child")
    joint = Joint(
        type=kind.name,
        parent=names["parent"][0],
        child=names["child"][0],
        position_in_parent=positions.get("jointPPos", (0.0, 0.0, 0.0)),
        position_in_child=positions.get("jointCPos", (0.0, 0.0, 0.0)),
        axes=_read_axes(opening, kind, notes),  # type: ignore[arg-type]
        limits=_read_limits(limits_line, kind, notes, key),  # type: ignore[arg-type]
    )
    if kind.quaternion:
        joint.limit_damping = BALL_LIMIT_DAMPING
    return name, joint


def _read_axes(line: Line, kind: JointType, notes: Notes) -> list[Triple]:
    """The axes after a joint's keyword; a ball may have two or three."""
    three = kind.quaternion and len(line.rest.partition("#")[0].split()) >= 9
    numbers = line.numbers(9 if three else 3 * kind.axes, "axes", notes)
    if three:
        line.ignore(notes, "the second swing axis is always swing1 x twist")
        numbers = numbers[0:3] + numbers[6:9]
    return [triple_of(numbers[i : i + 3]) for i in range(0, len(numbers), 3)]


def _read_limits(line: Line | None, kind: JointType, notes: Notes, key: str) -> list[tuple[float, float]]:
    """Limits of the joint's angles as the scene has them, one pair an axis."""
    if line is None:
        return []
    line.mark(notes, f"{key}.limits")
    if not kind.limits:
        line.ignore(notes, "a stiff joint has no limits")
        return []
    numbers = line.numbers(2 * kind.limits, "low and high of each axis, rad", notes)
    pairs = [(numbers[i], numbers[i + 1]) for i in range(0, len(numbers), 2)]
    for low, high in pairs:
        if low > high:
            raise line.error(f"low {low:g} is greater than high {high:g}", key=f"{key}.limits")
    return [mirrored(*pair) if i in kind.opposite_limits else pair for i, pair in enumerate(pairs)]


def mirrored(low: float, high: float) -> tuple[float, float]:
    """Limits of -x where x has the given ones; 0.0 - 0.0 avoids a negative zero."""
    return 0.0 - high, 0.0 - low
