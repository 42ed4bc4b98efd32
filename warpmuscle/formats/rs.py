"""`.rs` files of the Simbicon Controller Editor Framework: the state that a simulation starts from."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats.lines import Line, Lines, Notes
from warpmuscle.formats.rbs_blocks import triple_of
from warpmuscle.scene import Character, InitialState, JointState
from warpmuscle.scene.topology import joints_by_parent

Quaternion = tuple[float, float, float, float]


def read(path: str | Path, character: Character, notes: Notes) -> InitialState:
    """Read an initial state: heading (absent in files of 2019), root, then the joints, breadth first from the root.

    Quaternions stand as w x y z in the file; they are kept as given, not normalised. A block of muscle states at the
    end is listed as ignored.

    Args:
        path: the file.
        character: whose state it is; the number of joints must agree.
        notes: gets the lines that were ignored, and the place of every key.

    Raises:
        SceneError: with file and line.
    """
    path = Path(path)
    joints = breadth_first(character)
    records = _Records(path, notes)
    initial = InitialState()
    first = records.peek()
    if first is not None and len(first.text.partition("#")[0].split()) == 1:
        (initial.heading,) = records.take(1, "the heading", "initial_state.heading")
    initial.root_position = triple_of(records.take(3, "the root's position", "initial_state.root_position"))
    initial.root_orientation = _quaternion(
        records.take(4, "the root's orientation, w x y z", "initial_state.root_orientation")
    )
    initial.root_velocity = triple_of(records.take(3, "the root's velocity", "initial_state.root_velocity"))
    initial.root_angular_velocity = triple_of(
        records.take(3, "the root's angular velocity", "initial_state.root_angular_velocity")
    )
    for number, name in enumerate(joints, start=1):
        key, which = f"initial_state.joints.{name}", f"of joint {name!r} ({number} of {len(joints)})"
        orientation = records.take(4, f"the orientation {which}, w x y z", f"{key}.orientation")
        velocity = records.take(3, f"the angular velocity {which}", f"{key}.angular_velocity")
        initial.joints[name] = JointState(_quaternion(orientation), triple_of(velocity))
    records.finish(len(joints))
    return initial


def breadth_first(character: Character) -> list[str]:
    """Names of the joints, breadth first from the root, the children of a body in the order of the table.

    Joints that do not hang on the root are left out, as is a second joint to the same body.
    """
    by_parent = joints_by_parent(character)
    order, bodies, seen = list[str](), [character.root], {character.root}
    for body in bodies:
        for name in by_parent.get(body, ()):
            child = character.joints[name].child
            if child not in seen:
                seen.add(child)
                bodies.append(child)
                order.append(name)
    return order


class _Records:
    """Lines of numbers, one after another."""

    def __init__(self, path: Path, notes: Notes) -> None:
        self._path, self._notes = path, notes
        self._lines: Iterator[Line] = iter(Lines(path, (), notes))
        self._next = next(self._lines, None)
        self._last = 0  # number of the line of the last record

    def peek(self) -> Line | None:
        """The next record, None at the end."""
        return self._next

    def take(self, count: int, what: str, key: str) -> tuple[float, ...]:
        """The numbers of the next record, which must be `count`."""
        line = self._next
        if line is None:
            raise SceneError(f"the file ends before {what}", key, self._path, self._last)
        line.mark(self._notes, key)
        self._last = line.number
        words = line.text.partition("#")[0].split()
        if len(words) != count:
            raise line.error(f"expected {what}: {number_of(count, 'number')}, got {len(words)}", key)
        values = tuple(line.number_in(word, self._notes) for word in words)
        self._next = next(self._lines, None)
        return values

    def finish(self, joints: int) -> None:
        """Only a muscle block may follow; it is listed as ignored."""
        if self._next is None:
            return
        if self._next.text.split()[0] != "muscles":
            raise self._next.error(f"expected the end of the file: the character has {number_of(joints, 'joint')}")
        count = sum(1 for _ in self._lines)
        self._next.ignore(
            self._notes,
            f"muscles start at the activation of the scene's muscle_model ({number_of(count, 'line')} of their state)",
        )


def _quaternion(values: tuple[float, ...]) -> Quaternion:
    """Scalar first, as in the file, to scalar last."""
    w, x, y, z = values
    return x, y, z, w
