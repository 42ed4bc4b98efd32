"""Bodies and joints of a character by number: breadth first from the root."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpmuscle.scene import Character
from warpmuscle.scene.joints import JointType, RootType, joint_type, root_type


@dataclass(frozen=True)
class Topology:
    """Names and numbers of bodies and joints; joint i - 1 connects body i to its parent."""

    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    parents: tuple[int, ...]  # by body, -1 for the root
    level_start: tuple[int, ...]  # (levels + 1,)
    first_child: tuple[int, ...]
    child_count: tuple[int, ...]
    coordinate_start: tuple[int, ...]  # (bodies + 1,)
    speed_start: tuple[int, ...]  # (bodies + 1,)
    driver: tuple[int, ...]  # by body: the one whose joint's coordinates move its joint; another one if it follows it
    beside: tuple[int, ...]  # by body: the one on whose joint's coordinate its joint depends besides; -1: on none

    @property
    def coordinates(self) -> int:
        """Number of coordinates of an instance."""
        return self.coordinate_start[-1]

    @property
    def speeds(self) -> int:
        """Number of speeds of an instance: its degrees of freedom."""
        return self.speed_start[-1]

    def joint_coordinates(self, body: int) -> slice:
        """Where the coordinates are that the joint of a body itself has: none of one that follows another."""
        return slice(self.coordinate_start[body], self.coordinate_start[body + 1])

    def coordinates_of(self, body: int) -> slice:
        """Where the coordinates are that move the joint of a body."""
        return slice(*self.coordinate_start[self.driver[body] : self.driver[body] + 2])

    def speeds_of(self, body: int) -> slice:
        """Where the speeds are that move the joint of a body."""
        return slice(*self.speed_start[self.driver[body] : self.driver[body] + 2])

    def arguments_of(self, body: int) -> tuple[list[int], list[int]]:
        """Numbers of the coordinates and of the speeds that the motion of the joint of a body depends on."""
        bodies = [self.driver[body], *([self.beside[body]] if self.beside[body] >= 0 else [])]
        starts = (self.coordinate_start, self.speed_start)
        coordinates, speeds = ([k for one in bodies for k in range(start[one], start[one + 1])] for start in starts)
        return coordinates, speeds

    def body_of_joint(self, joint: str) -> int:
        """Number of the body that a joint carries; `root` is the root."""
        return 0 if joint == "root" else self.joints.index(joint) + 1


def coordinate_names(names: Topology, character: Character) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of all coordinates and of all speeds: `root.x`, a hinge's own, `ankle.0`, `hip.qx` and `hip.x`."""
    kind = root_type(character)
    coordinates, speeds = [f"root.{part}" for part in kind.coordinates], [f"root.{part}" for part in kind.speeds]
    for name in names.joints:
        entry = joint_type(character.joints[name])
        coordinates += [f"{name}.{part}".rstrip(".") for part in entry.coordinates]
        speeds += [f"{name}.{part}".rstrip(".") for part in entry.speeds]
    return tuple(coordinates), tuple(speeds)


def coordinate_units(names: Topology, character: Character) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Units of all coordinates and of all speeds, in the order of `coordinate_names`; those of quaternions are "1"."""
    kind = root_type(character)
    coordinates = [{"x": "m", "y": "m", "z": "m", "turn": "rad"}.get(part, "1") for part in kind.coordinates]
    speeds = ["m/s" if number < len(kind.moving) else "rad/s" for number in range(len(kind.speeds))]
    for name in names.joints:
        joint = character.joints[name]
        entry = joint_type(joint)
        unit = entry.unit(joint)
        coordinates += ["1" if len(entry.coordinates) > len(entry.speeds) else unit] * len(entry.coordinates)
        speeds += [f"{unit}/s"] * len(entry.speeds)
    return tuple(coordinates), tuple(speeds)


def topology(character: Character) -> Topology:
    """Number the bodies breadth first from the root, children in the order of the character's joints.

    A child whose joint follows another one comes behind its parent's other children.
    """
    bodies, joints, parents, depth = [character.root], [], [-1], [0]
    first_child, child_count = [], []
    by_parent = joints_by_parent(character)
    for number, name in enumerate(bodies):  # grows while it is walked through
        children = sorted(by_parent.get(name, ()), key=lambda key: bool(character.joints[key].follows))
        first_child.append(len(bodies))
        child_count.append(len(children))
        for key in children:
            bodies.append(character.joints[key].child)
            joints.append(key)
            parents.append(number)
            depth.append(depth[number] + 1)
    types: list[RootType | JointType] = [root_type(character), *(joint_type(character.joints[key]) for key in joints)]
    levels = [depth.index(d) for d in range(max(depth) + 1)]
    return Topology(
        bodies=tuple(bodies),
        joints=tuple(joints),
        parents=tuple(parents),
        level_start=(*levels, len(bodies)),
        first_child=tuple(first_child),
        child_count=tuple(child_count),
        coordinate_start=(0, *np.cumsum([len(entry.coordinates) for entry in types]).tolist()),
        speed_start=(0, *np.cumsum([len(entry.speeds) for entry in types]).tolist()),
        driver=(0, *(joints.index(character.joints[key].follows or key) + 1 for key in joints)),
        beside=(-1, *(joints.index(one) + 1 if (one := character.joints[key].beside) else -1 for key in joints)),
    )


def joints_by_parent(character: Character) -> dict[str, list[str]]:
    """Names of the joints that lead on from each body that has any, in the order of the character's joints."""
    found: dict[str, list[str]] = {}
    for name, joint in character.joints.items():
        found.setdefault(joint.parent, []).append(name)
    return found


def followers(character: Character, joint: str) -> list[str]:
    """Joints that follow a joint."""
    return [name for name, other in character.joints.items() if other.follows == joint]


def is_near(character: Character, joint: str) -> bool:
    """Whether a joint that follows one other is its neighbour: on its parent, or on what moves with it alone."""
    if character.joints[joint].beside:
        return False
    driver = character.joints[character.joints[joint].follows]
    others = [character.joints[name].child for name in followers(character, character.joints[joint].follows)]
    return character.joints[joint].parent in (driver.parent, driver.child, *others)


def followed_drivers(character: Character, names: Topology) -> tuple[int, ...]:
    """Bodies of the joints that others follow, if one is no neighbour of its own or there are constraints; else none.

    Neighbours are eliminated with the joint that they follow (`kernels.body.follower`), all others together at the root
    (`kernels.body.followed`).
    """
    following = [name for name, joint in character.joints.items() if joint.follows]
    if not character.constraints and all(is_near(character, name) for name in following):
        return ()
    return tuple(sorted({names.body_of_joint(character.joints[name].follows) for name in following}))


def subtree(character: Character, body: str) -> set[str]:
    """A body and all that hang on it."""
    found, added = {body}, {body}
    while added:
        added = {joint.child for joint in character.joints.values() if joint.parent in added} - found
        found |= added
    return found


def carried(joint: str, names: Topology) -> set[int]:
    """Numbers of the bodies that a joint carries."""
    found = {names.body_of_joint(joint)}
    for body in range(min(found) + 1, len(names.bodies)):
        if names.parents[body] in found:
            found.add(body)
    return found
