"""A typed description of an experiment: character, controller, initial state, ground, objective, limits.

Everything a TOML scene can say is a field here; `validation` checks what the types alone cannot.
Units are SI and radians; y is up, x to the character's left, z forward. Quaternions are (x, y, z, w). A body's frame
has its origin at the centre of mass and its axes along the principal axes of inertia, or where `inertia_axes`, the
orientation of those in the body, turns them; in the reference pose all bodies have identity orientation, so that a
joint axis has the same coordinates in parent and child.
"""

from __future__ import annotations

from importlib import import_module
from typing import Annotated, Literal

import msgspec

from warpmuscle.core.html_table import html_table
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene.body_contact.part import BodyContact
from warpmuscle.scene.constraints.part import Constraint
from warpmuscle.scene.controller import SIMBICON, Command, Controller
from warpmuscle.scene.custom_part import CustomPart
from warpmuscle.scene.displacement import Coupling, Displacement
from warpmuscle.scene.force import Force
from warpmuscle.scene.gait_states.part import GaitReflex, GaitStates
from warpmuscle.scene.learning.task import Task
from warpmuscle.scene.motion import Motion
from warpmuscle.scene.muscles import (
    Actuation,
    Condition,
    Drive,
    Excitation,
    Muscle,
    MuscleModel,
    PointMotion,
    PolynomialPath,
    Pulley,
    ViaPoint,
    Wrap,
)
from warpmuscle.scene.muscles.cables import Ligament, PathActuator
from warpmuscle.scene.muscles.curves import CurveShape, DeGrooteCurves, MillardCurves, ThelenCurves
from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.objective import Failure, Objective, Robustness, SearchStage, Tracking
from warpmuscle.scene.part import Part, Side
from warpmuscle.scene.reflexes import Reflex, Reflexes
from warpmuscle.scene.simbicon.controller import PD, Balance, Component, Curve, Feedback, MachineState, Trajectory
from warpmuscle.scene.surfaces import (
    CylinderSurface,
    EllipsoidSurface,
    SphereSurface,
    Surface,
    TorusSurface,
)
from warpmuscle.scene.terrain.tiles import Terrain

__all__ = [
    "PD",
    "Actuation",
    "Balance",
    "BallCoordinates",
    "Body",
    "BodyContact",
    "Box",
    "Capsule",
    "Character",
    "Command",
    "Component",
    "Condition",
    "Constraint",
    "ContactMaterial",
    "Controller",
    "Coupling",
    "Curve",
    "CurveShape",
    "CustomPart",
    "CylinderSurface",
    "DeGrooteCurves",
    "Displacement",
    "DrawnMesh",
    "Drive",
    "EllipsoidSurface",
    "Excitation",
    "Failure",
    "Feedback",
    "Force",
    "GaitReflex",
    "GaitStates",
    "Ground",
    "InitialState",
    "Joint",
    "JointState",
    "Ligament",
    "MachineState",
    "Marker",
    "MillardCurves",
    "Motion",
    "Muscle",
    "MuscleModel",
    "Objective",
    "OpenSim",
    "Part",
    "PathActuator",
    "PointMotion",
    "PolynomialPath",
    "Pulley",
    "Reflex",
    "Reflexes",
    "Robustness",
    "Scene",
    "SearchStage",
    "Shape",
    "Side",
    "Sphere",
    "SphereSurface",
    "Surface",
    "Terrain",
    "ThelenCurves",
    "TorusSurface",
    "Tracking",
    "Trajectory",
    "ViaPoint",
    "Wrap",
    "drawable",
]  # fmt: skip


class ContactMaterial(Part):
    """What a sphere and the ground are made of in Hunt-Crossley contact; the numbers are OpenSim's, see `Ground`.

    They count for both sides; of different ones, harmonic means stand for stiffness to the power 2/3 and frictions.
    """

    stiffness: Annotated[Number, "N/m^2"] = 1.0e6  # of plane strain; 0: it does not touch the ground
    dissipation: Annotated[Number, "s/m"] = 2.0
    static_friction: Annotated[Number, "1"] = 0.8
    dynamic_friction: Annotated[Number, "1"] = 0.8
    viscous_friction: Annotated[Number, "s/m"] = 0.5
    transition_velocity: Annotated[Number, "m/s"] = 0.2  # of slip, at which friction is greatest
    hertz_smoothing: Annotated[Number, "1/m"] = 300.0  # this and the following of the smooth law only
    hunt_crossley_smoothing: Annotated[Number, "s/m"] = 50.0
    constant_force: Annotated[Number, "1"] = 1.0e-5  # added to squares of depth, m^2, and of slip, m^2/s^2


class Sphere(Part, tag_field="type", tag="sphere"):
    """Collision sphere in body coordinates, m."""

    center: Annotated[Vector, "m"]
    radius: Annotated[Number, "m"]
    material: ContactMaterial | None = None  # in Hunt-Crossley contact, in place of the ground's


class Capsule(Part, tag_field="type", tag="capsule"):
    """Collision capsule: a segment from `start` to `end` (centres of its caps) swept by a sphere, m."""

    start: Annotated[Vector, "m"]
    end: Annotated[Vector, "m"]
    radius: Annotated[Number, "m"]
    material: ContactMaterial | None = None


class Box(Part, tag_field="type", tag="box"):
    """Collision box, aligned with the body axes, between two opposite corners, m."""

    low: Annotated[Vector, "m"]
    high: Annotated[Vector, "m"]


Shape = Sphere | Capsule | Box


class Body(Part):
    """A rigid body. One of mass and inertia 0 stands between two joints, so that they are one with more freedom."""

    mass: Annotated[Number, "kg"]
    inertia: Annotated[Vector, "kg m^2"]  # principal moments about the centre of mass
    shapes: list[Shape] = []
    friction: Annotated[Number, "1"] = 0.8  # Coulomb coefficient; a contact takes the smaller one of body and ground
    inertia_axes: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)  # of its moments


class Joint(Part):
    """A joint between two bodies; its coordinates are the child's rotation in the parent's frame.

    `axes`: hinge [a]; slide [a], along which the child moves; universal [a, b], the child turning by b of the parent,
    then by a of its own; ball [swing, twist], used by its limits only, as the Euler angles of rotations about swing (in
    the parent), swing x twist, and twist (in the child); fixed and coupled [].
    `rotations` and `translations`: of a coupled joint, such as a knee, three of each at most: the child turns about the
    rotations' axes in their order, each axis riding on the turns before, and its joint point moves along the
    translations' axes, which stay in the parent. All are functions of the joint's one coordinate, or of that of the
    joint which it `follows`, as a patella does the knee: then it has none of its own.
    `limits`: one [low, high] in rad per axis (three for a ball: swing, swing x twist, twist), of a slide in m; none if
    empty. Their stiffness and damping are those of a slide in N/m and N s/m.
    """

    type: str  # ball, universal, hinge, slide, coupled, fixed, or another one of `scene.joints.TYPES`
    parent: str
    child: str
    position_in_parent: Annotated[Vector, "m"]  # in the parent's frame
    position_in_child: Annotated[Vector, "m"]  # in the child's frame
    axes: Annotated[list[Vector], "1"] = []
    limits: Annotated[list[tuple[Number, Number]], "rad"] = []
    limit_stiffness: Annotated[Number, "N m/rad"] = 4000.0
    limit_damping: Annotated[Number, "N m s/rad"] = 20.0
    rotations: list[Displacement] = []
    translations: list[Displacement] = []
    follows: str = ""  # joint with a single coordinate of its own, anywhere in the tree


class Character(Part):
    """A tree of bodies. Joints are numbered breadth first from the root, in the order of this table.

    `wrapping`: round a cylinder, OpenSim's paths are not quite the shortest ones, and those round several surfaces stop
    half-way; so their moment arms, taken at the places of touch, miss the derivatives of their lengths by up to some
    tenths of a millimetre. `opensim` does the same, `shortest` has neither fault. OpenSim's paths also jump: round a
    surface to straight, where an end of a segment goes inside; the long way round, where they begin to touch near an
    end; and on to an ellipsoid from the side that they may not be on. `smooth` is `opensim` without these: a surface
    shrinks to nothing as an end goes inside by a quarter of its radius, a cylinder takes the shorter of two ways on its
    side, and a path comes over an ellipsoid to its side as it goes in.
    """

    root: str
    bodies: dict[str, Body]
    joints: dict[str, Joint] = {}
    root_joint: Literal["free", "planar", "fixed"] = "free"  # planar: moves in y and z, turns about x; fixed: welded
    muscles: dict[str, Muscle] = {}
    surfaces: dict[str, Surface] = {}  # that muscles wrap around
    wrapping: Literal["opensim", "shortest", "smooth"] = "opensim"  # how paths run round surfaces, see above
    constraints: dict[str, Constraint] = {}  # between bodies that joints do not join
    feet: tuple[str, str] | None = None  # bodies, left and right; by default those of the controller, if there is one


class JointState(Part):
    """Start of a joint: the child's orientation and angular velocity relative to the parent, in the parent's frame.

    A joint whose motion is a function of one coordinate, such as a slide, starts from that and its rate instead.
    """

    orientation: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)
    angular_velocity: Annotated[Vector, "rad/s"] = (0.0, 0.0, 0.0)
    coordinate: Annotated[Number, "rad or m"] = 0.0
    speed: Annotated[Number, "rad/s or m/s"] = 0.0


class InitialState(Part):
    """Start of the simulation, in world coordinates; joints that are not named start at rest in the reference pose.

    If `heading` is given, the root's orientation and velocities are first turned about the vertical to this heading.
    """

    root_position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)
    root_orientation: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)
    root_velocity: Annotated[Vector, "m/s"] = (0.0, 0.0, 0.0)
    root_angular_velocity: Annotated[Vector, "rad/s"] = (0.0, 0.0, 0.0)
    heading: Annotated[Number | None, "rad"] = None
    joints: dict[str, JointState] = {}


class Ground(Part):
    """A plane of contacts with the bodies' shapes, by one of four laws.

    spring: implicit spring-damper contacts with regularised Coulomb friction; values per contact point. The defaults
    are where the original's gaits come out closest to their recordings, also in steps of 1/500 s.
    soft_constraint: as the original program has it, at steps of 1/2000 s: its points bounce.
    hunt_crossley: spheres, and capsules by the spheres at their ends, as OpenSim's HuntCrossleyForce has them;
    smooth_hunt_crossley: as its SmoothSphereHalfSpaceForce. Each is of its own `material`, or of that of the ground.
    """

    normal: Annotated[Vector, "1"] = (0.0, 1.0, 0.0)
    height: Annotated[Number, "m"] = 0.0  # distance of the plane from the origin along its normal
    stiffness: Annotated[Number, "N/m"] = 2.0e5  # 0 switches contact off
    damping: Annotated[Number, "N s/m"] = 1.0e3
    tangential_damping: Annotated[Number, "N s/m"] = 1.0e5  # up to the friction limit
    friction: Annotated[Number, "1"] = 1.0e3  # the body's own coefficient decides unless this one is smaller
    law: Literal["spring", "soft_constraint", "hunt_crossley", "smooth_hunt_crossley"] = "spring"
    restitution: Annotated[Number, "1"] = 0.35  # this and the next two of `soft_constraint`: speed after over before
    softness: Annotated[Number, "m/(N s)"] = 2.0e-4  # its CFM
    penalty: Annotated[Number, "1"] = 0.2  # its ERP: part of the depth that is pushed out in a step
    material: ContactMaterial | None = None  # of Hunt-Crossley contact; None: the defaults
    terrain: Terrain | None = None  # heights over the plane; none: it is flat


class Marker(Part):
    """A point on a body, as on a subject's skin."""

    body: str
    position: Annotated[Vector, "m"]  # in the body's frame


class DrawnMesh(Part):
    """A file of triangles that a body is drawn with, where a folder has it; nothing is computed with it."""

    body: str
    file: str  # its name, without a folder: .vtp, .stl or .obj
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of the file's origin, in the body's frame
    orientation: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)  # of the file's axes, as a rotation vector
    scale: Annotated[Vector, "1"] = (1.0, 1.0, 1.0)  # along the file's axes


def drawable(file: str) -> bool:
    """Whether this may be the name of a mesh: of a file of a known kind, in no other folder."""
    plain = bool(file) and len(file) < 256 and not file.startswith(".") and file.isprintable()
    return plain and not set(file) & set('/\\:*?"<>|') and file.lower().endswith((".vtp", ".stl", ".obj"))


class BallCoordinates(Part):
    """Coordinates of a model that are angles of a ball joint here: about its axes swing, swing x twist and twist."""

    names: tuple[str, str, str]
    turned_round: bool = False  # whether the second one counts the other way


class OpenSim(Part):
    """What a scene that was made of an OpenSim model keeps of it, so that motions can go back in the model's words.

    The root's joint is given as a coupled one would be, but each of its displacements is a line over a coordinate of
    its own, named in `root_coordinates`: first those of its rotations, then those of its translations. Of all other
    joints a coordinate of the model has the name and the value of the joint.
    """

    file: str = ""
    root: Joint | None = None  # from `ground`, whose axes are the world's, to the root body; none: the root is fixed
    root_coordinates: list[str] = []
    locked: Annotated[dict[str, float], "rad or m"] = {}  # coordinates that do not move, and where they are
    couplers: dict[str, Coupling] = {}  # coordinates that are functions of that of a joint
    markers: dict[str, Marker] = {}
    angles: list[str] = []  # coordinates that OpenSim's files have in degrees
    balls: dict[str, BallCoordinates] = {}  # by ball joint; of all other joints coordinates have the joint's name
    ranges: Annotated[dict[str, tuple[float, float]], "rad or m"] = {}  # within which inverse kinematics keeps them
    meshes: list[DrawnMesh] = []  # that it is drawn with
    sideways: Annotated[float, "m"] = 0.0  # of a planar root: how far to the left of the plane x = 0 the model has it


class Scene(Part):
    """A complete experiment."""

    name: str
    character: Character
    controller: Controller | None = None
    gait_states: GaitStates | None = None  # reflexes by states of gait, in the place of a controller
    custom_controller: str = ""  # `module:name` of one of one's own, in the place of parts of the controller
    custom_controller_parameters: Annotated[dict[str, Number], "1"] = {}
    recorded: list[str] = []  # `module:name` each: quantities of one's own that recordings have
    custom: dict[str, CustomPart] = {}  # by `module:name` of a term or other part of one's own
    description: str = ""
    commands: dict[str, Command] = {}  # what numbers of this scene follow, by names of one's own
    initial_state: InitialState = msgspec.field(default_factory=InitialState)
    ground: Ground = msgspec.field(default_factory=Ground)
    body_contact: BodyContact | None = None  # of bodies with each other; none: they pass through one another
    failure: Failure = msgspec.field(default_factory=Failure)
    objective: Objective = msgspec.field(default_factory=Objective)
    tracking: Tracking | None = None
    robustness: Robustness = msgspec.field(default_factory=Robustness)
    learning: Task | None = None  # what a policy learns
    stages: list[SearchStage] = []  # of a search, one after the other; none: all of it at once
    muscle_model: MuscleModel = msgspec.field(default_factory=MuscleModel)
    actuation: dict[str, Actuation] = {}  # by joint
    forces: dict[str, Force] = {}  # by names of one's own
    opensim: OpenSim | None = None
    motion: dict[str, Motion] = {}  # by joint with kinematic degrees of freedom, or `root`
    duration: Annotated[float, "s"] = 10.0
    time_step: Annotated[float, "s"] = 0.0005
    gravity: Annotated[Number, "m/s^2"] = 9.8  # downwards
    control_rate: Annotated[float, "Hz"] = 0.0  # of the controller's targets, which PD follows meanwhile; 0: every step
    implicit_pd: bool = False  # PD linearised over the step, stable up to 1/500 s; False: explicit, as in the original

    @property
    def feet(self) -> tuple[str, str] | None:
        """Left and right foot of the character; None if it walks on nothing."""
        if self.character.feet is not None or self.simbicon is None:
            return self.character.feet
        return self.simbicon.feet

    @property
    def simbicon(self) -> Controller | None:
        """The controller, if it is a SIMBICON one."""
        return self.controller if self.controller is not None and self.controller.type == SIMBICON else None

    @property
    def heading(self) -> Number:
        """Heading that the body is to keep, rad, turned to the left from z: that which its controller has, or 0."""
        return 0.0 if self.simbicon is None else self.simbicon.desired_heading

    @property
    def turns_from_start(self) -> bool:
        """Whether the body turns from the heading at its start, since nothing makes it take another one."""
        return self.simbicon is not None and not self.simbicon.heading_control

    @property
    def pairs(self) -> dict[str, tuple[str, str]]:
        """Joints, left and right, that belong together, by a name for both."""
        return {} if self.simbicon is None else self.simbicon.pairs

    def __repr__(self) -> str:
        parts = self.character
        sizes = [(len(parts.bodies), "body", "bodies"), (len(parts.joints), "joint", "joints")]
        sizes += [(len(parts.muscles), "muscle", "muscles")]
        counts = ", ".join(f"{size} {one if size == 1 else several}" for size, one, several in sizes)
        return f"Scene({self.name!r}, {counts}, {self.duration:g} s)"

    def _repr_html_(self) -> str:
        """What notebooks show: a table, and the body as it starts."""
        parameters, anatomy = (
            import_module(f"warpmuscle.scene.{name}") for name in ("parameters", "anatomy")
        )  # of scenes
        parts = self.character
        drives = number_of(len(parts.muscles), "muscle") if parts.muscles else "torques"
        rows = [
            ("scene", self.name),
            ("is", self.description),
            ("bodies", str(len(parts.bodies))),
            ("driven by", drives),
        ]
        rows += [("free parameters", str(len(parameters.free_parameters(self)))), ("duration", f"{self.duration:g} s")]
        return str(anatomy.picture(self)) + html_table(("", ""), [row for row in rows if row[1]])
