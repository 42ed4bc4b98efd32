"""Bodies, joints, and the character that they make up."""

from __future__ import annotations

from typing import Annotated, Literal

from warpmuscle.scene.character.shapes import Shape
from warpmuscle.scene.constraints.part import Constraint
from warpmuscle.scene.displacement import Displacement
from warpmuscle.scene.muscles import Muscle
from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import FROM_0, Bodies, Joints, Muscles, Part
from warpmuscle.scene.surfaces import Surface


class Body(Part):
    """A rigid body. One of mass and inertia 0 stands between two joints, so that they are one with more freedom."""

    mass: Annotated[Number, "kg"]
    inertia: Annotated[Vector, "kg m^2"]  # principal moments about the centre of mass
    shapes: list[Shape] = []
    friction: Annotated[Number, "1", FROM_0] = 0.8  # Coulomb's; a contact takes the smaller one of body and ground
    inertia_axes: Annotated[tuple[Number, Number, Number, Number], "1"] = (0.0, 0.0, 0.0, 1.0)  # of its moments


class Joint(Part):
    """A joint between two bodies; its coordinates are the child's rotation in the parent's frame.

    `axes`: hinge [a]; slide [a], along which the child moves; universal [a, b], the child turning by b of the parent,
    then by a of its own; ball [swing, twist], used by its limits only, as the Euler angles of rotations about swing (in
    the parent), swing x twist, and twist (in the child); fixed and coupled [].
    `rotations` and `translations`: of a coupled joint, such as a knee, three of each at most: the child turns about the
    rotations' axes in their order, each axis riding on the turns before, and its joint point moves along the
    translations' axes, which stay in the parent. All are functions of the joint's one coordinate, or of that of the
    joint which it `follows`, as a patella does the knee: then it has none of its own. A follower may depend on a
    second coordinate, that of the joint `beside` it, by `terms` of displacements or along a `rod`. That takes two
    joints in a row: one follows the first coordinate; one with `rate_only` the second, and adds its part of the motion.
    `limits`: one [low, high] in rad per axis (three for a ball: swing, swing x twist, twist), of a slide in m; none if
    empty. Their stiffness and damping are those of a slide in N/m and N s/m; so is its own `damping`, and its
    `armature` is in kg. Both of a joint that follows another one resist the rates of its displacements.
    """

    type: str  # ball, universal, hinge, slide, coupled, fixed, or another one of `scene.joints.TYPES`
    parent: str
    child: str
    position_in_parent: Annotated[Vector, "m"]  # in the parent's frame
    position_in_child: Annotated[Vector, "m"]  # in the child's frame
    axes: Annotated[list[Vector], "1"] = []
    limits: Annotated[list[tuple[Number, Number]], "rad"] = []
    limit_stiffness: Annotated[Number, "N m/rad", FROM_0] = 4000.0
    limit_damping: Annotated[Number, "N m s/rad", FROM_0] = 20.0
    rotations: list[Displacement] = []
    translations: list[Displacement] = []
    follows: str = ""  # joint with a single coordinate of its own, anywhere in the tree
    beside: str = ""  # another such joint, on whose coordinate the functions of a follower depend besides
    rate_only: bool = False  # of the two joints in a row that do, whether it is the second one
    armature: Annotated[Number, "kg m^2", FROM_0] = 0.0  # inertia along its coordinates, as of a motor's rotor
    damping: Annotated[Number, "N m s/rad", FROM_0] = 0.0  # of its coordinates, whatever drives it


class Character(Part):
    """A tree of bodies. Joints are numbered breadth first from the root, in the order of this table.

    `wrapping`: round a cylinder, OpenSim's paths are not quite the shortest ones, and those round several surfaces stop
    half-way; so their moment arms, taken at the places of touch, miss the derivatives of their lengths by up to some
    tenths of a millimetre. `opensim` does the same, and turns once too often where OpenSim does on a long way round;
    `shortest` has none of these faults. OpenSim's paths also jump: round a surface to straight, where an end of a
    segment goes inside; the long way round, where they begin to touch near an end; and on to an ellipsoid from the side
    that they may not be on. `smooth` is `opensim` without these: a surface
    shrinks to nothing as an end goes inside by a quarter of its radius, a cylinder takes the shorter of two ways on its
    side, and a path comes over an ellipsoid to its side as it goes in. `mujoco` is as MuJoCo has it: between the two
    points of a wrap, round or inside of a cylinder without ends or a sphere, on the side of its `side_point`; over
    several surfaces between two points, in their order, it is the shortest path that begins at their side points.
    `moving_points`: with `slopes`, moment arms of paths whose points move on bodies are the slopes of their lengths;
    `opensim` leaves out what such a motion does to segments within one body, and goes on with it where a coordinate
    leaves its range and the point stays, as OpenSim's moment arms and forces do.
    """

    root: str
    bodies: dict[str, Body]
    joints: dict[str, Joint] = {}
    root_joint: Literal["free", "planar", "fixed"] = "free"  # planar: moves in y and z, turns about x; fixed: welded
    muscles: dict[str, Muscle] = {}
    surfaces: dict[str, Surface] = {}  # that muscles wrap around
    wrapping: Literal["opensim", "shortest", "smooth", "mujoco"] = "opensim"  # how paths run round surfaces, see above
    moving_points: Literal["slopes", "opensim"] = "slopes"  # how these act on joints, see above
    constraints: dict[str, Constraint] = {}  # between bodies that joints do not join
    feet: tuple[str, str] | None = None  # bodies, left and right; by default those of the controller, if there is one

    def __post_init__(self) -> None:
        self.bodies, self.joints = Bodies(self.bodies), Joints(self.joints)
        self.muscles = Muscles(self.muscles)
