"""A typed description of an experiment: character, controller, initial state, ground, objective, limits.

Everything a TOML scene can say is a field here; `validation` checks what the types alone cannot.
Units are SI and radians; y is up, x to the character's left, z forward. Quaternions are (x, y, z, w). A body's frame
has its origin at the centre of mass and its axes along the principal axes of inertia, or where `inertia_axes`, the
orientation of those in the body, turns them; in the reference pose all bodies have identity orientation, so that a
joint axis has the same coordinates in parent and child.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from warpmuscle.core.arguments import not_made_by_hand
from warpmuscle.core.errors import SceneError, lacking
from warpmuscle.core.html_table import html_table
from warpmuscle.scene.body_contact.part import BodyContact
from warpmuscle.scene.character.opensim import BallCoordinates, DrawnMesh, Marker, OpenSim, drawable
from warpmuscle.scene.character.shapes import Box, Capsule, ContactMaterial, Shape, Sphere
from warpmuscle.scene.character.tree import Body, Character, Joint
from warpmuscle.scene.constraints.part import Constraint
from warpmuscle.scene.controller import SIMBICON, Command, Controller
from warpmuscle.scene.custom_part import CustomPart
from warpmuscle.scene.displacement import Coupling, Displacement
from warpmuscle.scene.force import Force
from warpmuscle.scene.gait_states.part import GaitReflex, GaitStates
from warpmuscle.scene.impairments.part import Impairment
from warpmuscle.scene.learning.task import Task
from warpmuscle.scene.motion import Motion
from warpmuscle.scene.muscles import (
    Actuation,
    Branch,
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
from warpmuscle.scene.muscles.cables import BlankevoortLigament, Ligament, PathActuator
from warpmuscle.scene.muscles.curves import (
    CurveShape,
    DeGrooteCurves,
    MillardCurves,
    MujocoCurves,
    Spline,
    SplineCurves,
    ThelenCurves,
)
from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.objective import Failure, Objective, RecordedNorms, Robustness, SearchStage, Tracking
from warpmuscle.scene.objects.part import AnyObject, BallObject, BoxObject, CapsuleObject, Held, Hinge
from warpmuscle.scene.part import ABOVE_0, FRACTION, FROM_0, INSTEAD, NoSuchPart, Part, Side
from warpmuscle.scene.reflexes import Reflex, Reflexes
from warpmuscle.scene.simbicon.controller import PD, Balance, Component, Curve, Feedback, MachineState, Trajectory
from warpmuscle.scene.surfaces import CylinderSurface, EllipsoidSurface, SphereSurface, Surface, TorusSurface
from warpmuscle.scene.terrain.tiles import Terrain
from warpmuscle.scene.treadmill.part import Treadmill
from warpmuscle.scene.water.part import Water

__all__ = [
    "PD",
    "Actuation",
    "Balance",
    "BallCoordinates",
    "BallObject",
    "BlankevoortLigament",
    "Body",
    "BodyContact",
    "Box",
    "BoxObject",
    "Branch",
    "Capsule",
    "CapsuleObject",
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
    "Held",
    "Hinge",
    "Impairment",
    "InitialState",
    "Joint",
    "JointState",
    "Ligament",
    "MachineState",
    "Marker",
    "MillardCurves",
    "Motion",
    "MujocoCurves",
    "Muscle",
    "MuscleModel",
    "Objective",
    "OpenSim",
    "Part",
    "PathActuator",
    "PointMotion",
    "PolynomialPath",
    "Pulley",
    "RecordedNorms",
    "Reflex",
    "Reflexes",
    "Robustness",
    "Scene",
    "SearchStage",
    "Shape",
    "Side",
    "Sphere",
    "SphereSurface",
    "Spline",
    "SplineCurves",
    "Surface",
    "Terrain",
    "ThelenCurves",
    "TorusSurface",
    "Tracking",
    "Trajectory",
    "Treadmill",
    "ViaPoint",
    "Water",
    "Wrap",
    "drawable",
]  # fmt: skip


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
    With `file`, all of this but the heading is that of a frame of a recorded motion, whose joints have the scene's
    names; joints that it lacks start as they are named here. The frame's numbers become part of the scene as it is
    read.
    """

    root_position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)
    root_orientation: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)
    root_velocity: Annotated[Vector, "m/s"] = (0.0, 0.0, 0.0)
    root_angular_velocity: Annotated[Vector, "rad/s"] = (0.0, 0.0, 0.0)
    heading: Annotated[Number | None, "rad"] = None
    joints: dict[str, JointState] = {}
    activations: Annotated[dict[str, Number], "1", FRACTION] = {}  # of muscles; others as `muscle_model` has it
    file: str = ""  # a result file with a motion, such as one of `warpmuscle inverse`
    time: Annotated[float, "s"] = 0.0  # in that motion
    replay: int = 0  # which motion of the file
    scone_parameters: Annotated[dict[str, float], "1"] = {}  # offsets and load in it, for a .par; no effect


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
    stiffness: Annotated[Number, "N/m", FROM_0] = 2.0e5  # 0 switches contact off
    damping: Annotated[Number, "N s/m", FROM_0] = 1.0e3
    tangential_damping: Annotated[Number, "N s/m", FROM_0] = 1.0e5  # up to the friction limit
    friction: Annotated[Number, "1", FROM_0] = 1.0e3  # the body's own coefficient decides unless this one is smaller
    law: Literal["spring", "soft_constraint", "hunt_crossley", "smooth_hunt_crossley"] = "spring"
    restitution: Annotated[Number, "1", FRACTION] = 0.35  # after an impact; like the next two, of `soft_constraint`
    softness: Annotated[Number, "m/(N s)", ABOVE_0] = 2.0e-4  # its CFM
    penalty: Annotated[Number, "1", FRACTION] = 0.2  # its ERP: part of the depth that is pushed out in a step
    material: ContactMaterial | None = None  # of Hunt-Crossley contact; None: the defaults
    terrain: Terrain | None = None  # heights over the plane; none: it is flat
    treadmill: Treadmill | None = None  # by which it moves along itself; none: it stands still


class _SceneKind(msgspec.StructMeta):
    """Says what to type where a scene is called with the name of one, or its file."""

    if not TYPE_CHECKING:

        def __call__(cls, *args: Any, **kwargs: Any) -> Any:
            try:
                return super().__call__(*args, **kwargs)
            except TypeError as error:
                raise not_made_by_hand("Scene", "wm.load('walk56') reads one, from a name or a file", error) from None


class Scene(Part, metaclass=_SceneKind):
    """A complete simulation experiment: character, muscles, controller, ground, objective and initial state."""

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
    objects: dict[str, AnyObject] = {}  # beside the character, by names of one's own
    water: Water | None = None
    failure: Failure = msgspec.field(default_factory=Failure)
    objective: Objective = msgspec.field(default_factory=Objective)
    tracking: Tracking | None = None
    norms: RecordedNorms | None = None  # none: published ones
    robustness: Robustness = msgspec.field(default_factory=Robustness)
    learning: Task | None = None  # what a policy learns
    stages: list[SearchStage] = []  # of a search, one after the other; none: all of it at once
    muscle_model: MuscleModel = msgspec.field(default_factory=MuscleModel)
    actuation: dict[str, Actuation] = {}  # by joint
    forces: dict[str, Force] = {}  # by names of one's own
    impairments: dict[str, Impairment] = {}  # of muscles, by names of one's own
    opensim: OpenSim | None = None
    motion: dict[str, Motion] = {}  # by joint with kinematic degrees of freedom, or `root`
    duration: Annotated[float, "s", ABOVE_0] = 10.0
    time_step: Annotated[float, "s", ABOVE_0] = 0.0005
    gravity: Annotated[Number, "m/s^2"] = 9.8  # downwards
    control_rate: Annotated[float, "Hz", FROM_0] = 0.0  # of the controller's targets, which PD follows; 0: every step
    implicit_pd: bool = False  # PD linearised over the step, stable up to 1/500 s; False: explicit, as in the original

    @property
    def feet(self) -> tuple[str, str] | None:
        """Bodies of the left and the right foot; None for a character without feet."""
        if self.character.feet is not None or self.simbicon is None:
            return self.character.feet
        return self.simbicon.feet

    @property
    def simbicon(self) -> Controller | None:
        """The controller, if it is a SIMBICON one."""
        return self.controller if self.controller is not None and self.controller.type == SIMBICON else None

    @property
    def heading(self) -> Number:
        """Heading that the body should keep, rad, counterclockwise from z seen from above: the controller's, or 0."""
        return 0.0 if self.simbicon is None else self.simbicon.desired_heading

    @property
    def turns_from_start(self) -> bool:
        """Whether headings are relative to the initial one, because the controller does not control the heading."""
        return self.simbicon is not None and not self.simbicon.heading_control

    @property
    def pairs(self) -> dict[str, tuple[str, str]]:
        """Pairs of left and right joints, by the name of the pair."""
        return {} if self.simbicon is None else self.simbicon.pairs

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Say what to type instead of what is often tried, or where a part is."""
            if name in {field.name for field in msgspec.structs.fields(Character)}:
                raise AttributeError(f"a scene has no {name!r}, but its character has: scene.character.{name}")
            raise lacking("a scene", name, dir(type(self)), INSTEAD["Scene"])

    def __getitem__(self, path: str) -> Any:
        """What stands at a path, as `set` of `load` names it, such as scene["controller.states.0.time"].

        Raises:
            SceneError: nothing does.
        """
        found: Any = self
        for depth, name in enumerate(names := str(path).split(".")):
            try:
                if isinstance(found, list | tuple):
                    found = found[int(name)]
                else:
                    found = found[name] if isinstance(found, dict) else getattr(found, name)
            except (AttributeError, LookupError, ValueError, TypeError) as error:
                about = f"; {error}" if isinstance(error, AttributeError | NoSuchPart) else ""
                raise SceneError(f"there is no {'.'.join(names[: depth + 1])!r} in this scene{about}") from None
        return found

    def __repr__(self) -> str:
        parts = self.character
        sizes = [(len(parts.bodies), "body", "bodies"), (len(parts.joints), "joint", "joints")]
        sizes += [(len(parts.muscles), "muscle", "muscles")]
        counts = ", ".join(f"{size} {one if size == 1 else several}" for size, one, several in sizes)
        return f"Scene({self.name!r}, {counts}, {self.duration:g} s)"

    def _repr_html_(self) -> str:
        """What notebooks show: a table, and the body as it starts, where `scene.drawing` is imported, as by `load`."""
        return "".join(draw(self) for draw in drawn_by) or html_table(("", ""), [("scene", self.name)])


drawn_by: list[Callable[[Scene], str]] = []  # what notebooks show of a scene, from modules that are built on scenes
