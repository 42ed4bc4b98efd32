"""What a model file says, as plain records in OpenSim's axes and words; SI units and radians.

A frame is named by its path in the model, such as `/bodyset/femur_r` or `/jointset/knee_r/femur_r_offset`; `line` is
where a thing stands in the file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from warpmuscle.core.array_types import Floats
from warpmuscle.formats.osim.functions import Function
from warpmuscle.formats.osim.joints.several import Terms

Vec3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame fixed in another one; of a body or the ground, `parent` is empty."""

    path: str
    line: int
    parent: str
    rotation: Floats  # (3, 3), this frame's axes in those of its parent
    translation: Floats  # (3,) m

    @property
    def name(self) -> str:
        return self.path.rpartition("/")[2]


@dataclass(frozen=True, slots=True)
class Body:
    """Mass properties of a body, whose frame has the same path."""

    path: str
    name: str
    line: int
    mass: float
    center: Floats  # (3,) m
    inertia: Floats  # (3, 3) kg m^2 about the centre of mass, in the body's axes


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A generalised coordinate."""

    path: str
    name: str
    line: int
    value: float  # at the start
    speed: float
    range: tuple[float, float]
    locked: bool
    prescribed: Function | None  # over time
    clamped: bool = True  # whether OpenSim keeps it within its range where it assembles a pose


@dataclass(frozen=True, slots=True)
class Axis:
    """One turn or shift of a joint, a function of coordinates."""

    direction: Vec3
    coordinates: tuple[str, ...]  # names
    function: Function  # of one coordinate at most
    line: int
    terms: Terms = ()  # of several


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """What a joint's child slides on, and of a scapula also the axis about which it comes off."""

    radii: Vec3  # m, along the axes of the parent's frame
    origin: tuple[float, float] = (0.0, 0.0)  # m, x and y of a point of that axis in the child's frame
    direction: float = 0.0  # rad, of the axis, from y about z


@dataclass(frozen=True, slots=True)
class Rod:
    """What a joint's child is at the end of, see `joints.rods`."""

    length: float  # m
    angles: Vec3  # rad, about x, z and y, at which it is straight and not turned


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint: shifts along axes of the parent's frame, then turns, each about an axis that the former ones turned.

    With an ellipsoid or a rod, what moves is a row of its own, see `joints.ellipsoids` and `joints.rods`, and
    `rotations` only say which coordinates are angles.
    """

    kind: str
    name: str
    path: str
    line: int
    parent: str  # frame
    child: str
    coordinates: tuple[Coordinate, ...]
    rotations: tuple[Axis, ...]
    translations: tuple[Axis, ...]
    ellipsoid: Ellipsoid | None = None
    rod: Rod | None = None


@dataclass(frozen=True, slots=True)
class Coupler:
    """A coordinate that is a function of another one, or of several."""

    name: str
    line: int
    dependent: str
    independent: str
    function: Function
    constant: bool = False  # a Constant, which takes no coordinate at all
    several: tuple[str, ...] = ()  # all the coordinates, where there are several
    terms: Terms = ()  # of these


@dataclass(frozen=True, slots=True)
class Loop:
    """A constraint between two bodies that closes a loop: a place on each of two frames, see `loops.read`."""

    kind: str
    name: str
    line: int
    frame: str
    location: Vec3
    other_frame: str
    other_location: Vec3
    axis: Vec3  # of a line, in the other frame
    distance: float  # m


@dataclass(frozen=True, slots=True)
class Point:
    """A point of a path: fixed in a frame; counted within a range of a coordinate; or moved by coordinates."""

    name: str
    line: int
    frame: str
    location: Vec3
    coordinate: str = ""
    range: tuple[float, float] = (0.0, 0.0)
    motion: tuple[tuple[str, Function], ...] = ()  # along x, y and z: a coordinate's name, and its function


@dataclass(frozen=True, slots=True)
class PathWrap:
    """A surface that a path wraps over between two of its points, counted from 1; -1: from the first, to the last."""

    surface: str
    line: int
    method: str
    range: tuple[int, int]


@dataclass(frozen=True, slots=True)
class PolynomialPath:
    """A path's length as a polynomial in coordinates."""

    line: int
    coordinates: tuple[str, ...]  # names
    dimension: int
    order: int
    coefficients: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface that paths wrap over."""

    kind: str  # WrapCylinder, ...
    name: str
    line: int
    frame: str
    rotation: Vec3  # body-fixed x-y-z angles
    translation: Vec3
    quadrant: str
    sizes: tuple[float, ...]  # radius and length; radius; radii; inner and outer radius
    side_point: Vec3 | None = None  # on whose side of a cylinder a shortest path runs, in its axes


@dataclass(frozen=True, slots=True)
class OldCurves:
    """Curves of a muscle through knots, see `muscles.old_curves`; without one over speed, Schutte's hyperbolas."""

    active: Function
    passive: Function
    tendon: Function
    velocity: Function | None
    damping: float  # of the fibre, over f_max at v_max


@dataclass(frozen=True, slots=True)
class Muscle:
    """A muscle, or what else pulls along a path, with the numbers that its class knows."""

    kind: str
    name: str
    line: int
    numbers: dict[str, float]
    truths: dict[str, bool]
    curves: dict[str, dict[str, float]]  # by class of curve
    points: tuple[Point, ...]
    wraps: tuple[PathWrap, ...]
    polynomial: PolynomialPath | None = None
    tension: Function | None = None  # of a ligament, over pcsa_force, of its length over resting_length
    old: OldCurves | None = None
    shortest: bool = False  # whether its path is the shortest one over its surfaces, see `wraps.shortest`
    lost: str = ""  # what of its tension is not kept


@dataclass(frozen=True, slots=True)
class OsimForce:
    """Another force: its numbers, words and the frames it acts between."""

    kind: str
    name: str
    line: int
    numbers: dict[str, tuple[float, ...]]
    words: dict[str, str]
    frames: tuple[str, ...] = ()
    functions: dict[str, tuple[Function, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Contact:
    """A shape that touches others."""

    kind: str  # ContactSphere, ContactHalfSpace
    name: str
    line: int
    frame: str
    location: Vec3
    orientation: Vec3
    radius: float = 0.0


@dataclass(frozen=True, slots=True)
class Marker:
    """A point on a body, as on a subject's skin."""

    name: str
    line: int
    frame: str
    location: Vec3
    fixed: bool = False  # whether it stays there when markers are placed as a subject has them


@dataclass(frozen=True, slots=True)
class DrawnMesh:
    """A file of triangles that a frame is drawn with."""

    file: str
    frame: str
    rotation: Vec3  # body-fixed x-y-z angles
    translation: Vec3
    scale: Vec3


@dataclass(frozen=True, slots=True)
class Lost:
    """A force that is left out, and all names that stand in it."""

    kind: str
    names: frozenset[str]


@dataclass(slots=True)
class Model:
    """All that a file says."""

    file: Path
    name: str
    line: int
    version: int
    credits: str = ""
    gravity: Vec3 = (0.0, -9.80665, 0.0)
    gravity_line: int = 0
    frames: dict[str, Frame] = field(default_factory=dict)  # by path; all parents stand in it, without a circle
    bodies: list[Body] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    couplers: list[Coupler] = field(default_factory=list)
    loops: list[Loop] = field(default_factory=list)
    surfaces: dict[str, Surface] = field(default_factory=dict)
    obstacles: set[str] = field(default_factory=set)  # names of shapes of contact that shortest paths go over
    muscles: list[Muscle] = field(default_factory=list)
    forces: list[OsimForce] = field(default_factory=list)
    contacts: dict[str, Contact] = field(default_factory=dict)
    markers: list[Marker] = field(default_factory=list)
    meshes: list[DrawnMesh] = field(default_factory=list)
    controls: dict[str, Function] = field(default_factory=dict)  # over time, by actuator
    lost: list[Lost] = field(default_factory=list)
    lost_shapes: dict[str, frozenset[str]] = field(default_factory=dict)  # not known: all names that stand in them

    @property
    def coordinates(self) -> dict[str, Coordinate]:
        """All coordinates by name, in the order of the joints."""
        return {coordinate.name: coordinate for joint in self.joints for coordinate in joint.coordinates}
