"""What a file says of a creature.

All is drawn in one pose, standing, with the feet on the ground y = 0: places are in m, y up, x to the left, z forward.
All angles are 0 there. A joint turns about x: positive angles swing a hanging limb backwards. One with a `side` range
turns about z, too: positive angles lift a hanging limb outwards. Units are SI and radians.
"""

from __future__ import annotations

from typing import Literal

from warpmuscle.scene.part import Part

Place = tuple[float, float, float]  # m, in the standing pose
Range = tuple[float, float]


class Segment(Part):
    """A body: a capsule, or a box along z, from `start` to `end`; one without a parent is the root."""

    start: Place
    end: Place
    radius: float  # m; of a box half its height, and half its width
    parent: str = ""
    joint: str = ""  # its name; by default that of the segment
    at: Place | None = None  # of the joint; by default at `start`
    range: Range | None = None  # of the joint, rad; none: it is welded to its parent
    side: Range | None = None  # of a second axis of the joint, rad, outwards; none: it has one axis
    paired: bool = False  # one on the left, as given, and its mirror image on the right
    box: bool = False  # such as a foot
    mass: float | None = None  # kg; by default of its volume
    density: float | None = None  # kg/m^3; by default the creature's
    damping: float = 0.5  # N m s/rad, of the soft parts of a joint of one axis
    friction: float = 0.9


class Attachment(Part):
    """A box on a segment in which a point of a muscle's path lies."""

    on: str
    low: Place
    high: Place
    start: Place | None = None  # where a search begins; by default in the middle


class Bend(Part):
    """A cylinder about a joint that a path wraps around, on one side of it in the frame of the joint's parent."""

    joint: str
    side: Literal["front", "back", "up", "down"]
    radius: Range  # m, within which a search chooses it, from the lower one on


class CreatureMuscle(Part):
    """A muscle, on both sides if it touches anything paired. Searches begin at the geometric means of the ranges."""

    path: list[Attachment]  # from origin to insertion
    f_max: Range  # N
    over: list[Bend] = []
    l_opt: Range = (0.2, 0.6)  # optimal fibre length over the length of the path in the standing pose
    fibre: float = 1.0  # length of the fibre over l_opt in the standing pose, where a search begins
    delay: float = 0.005  # s


class CreatureGait(Part):
    """How it is to move: targets of joints over the phase of a step, rad, evenly spread, where a search begins.

    `walk`: one leg swings while the other one stands. `hop`: both swing through the air, then both push.
    """

    kind: Literal["walk", "hop"]
    speed: float  # m/s that is wanted
    time: float  # s, of a step, or in the air
    hips: str  # the pair that carries the trunk, and steers the feet
    feet: str  # the paired segment that stands on the ground
    ground_time: float = 0.2  # s, of `hop`
    lean: float = 0.0  # rad, of the root, forwards
    swing: dict[str, list[float]] = {}  # by pair; of a leg in the air
    stance: dict[str, list[float]] = {}  # by pair; of one on the ground
    steady: dict[str, list[float]] = {}  # by joint that is no pair
    crossed: list[str] = []  # pairs of which the right one moves with the left hip, as in a trot
    level: list[str] = []  # pairs whose targets are orientations in space, as those of feet
    apart: dict[str, float] = {}  # rad, outwards, of a leg in the air, by pair with a `side` range; 0 by default
    stiffness: dict[str, float] = {}  # N m/rad of a pair, joint or `root`; by default of the creature's weight
    start: dict[str, float] = {}  # rad, where joints start
    freedom: float = 0.5  # rad, by which a search may change targets, either way


class Creature(Part):
    """An animal."""

    name: str
    segments: dict[str, Segment]
    muscles: dict[str, CreatureMuscle]
    gait: CreatureGait
    description: str = ""
    spatial: bool = False  # it moves in space, and can fall to its sides; or else in its sagittal plane
    density: float = 1050.0  # kg/m^3
    fall: float = 0.75  # of the centre of mass, over its height at the start, below which it has fallen
    duration: float = 8.0  # s
    time_step: float = 0.001  # s


def sided(name: str, side: str) -> str:
    """The name of one of a pair, `l` or `r`: lThigh of Thigh."""
    return f"{side}{name[:1].upper()}{name[1:]}"


def joint_of(name: str, segment: Segment) -> str:
    """The name of a segment's joint, without a side."""
    return segment.joint or name


def is_paired(creature: Creature, muscle: CreatureMuscle) -> bool:
    """Whether there is a muscle on each side."""
    return any(creature.segments[point.on].paired for point in muscle.path)


def mirrored(place: Place) -> Place:
    """A place on the other side."""
    return (-place[0], place[1], place[2])
