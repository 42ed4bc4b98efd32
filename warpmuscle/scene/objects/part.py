"""What a scene says of objects: rigid bodies beside the character that ground and bodies touch."""

from __future__ import annotations

from typing import Annotated

from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import ABOVE_0, FRACTION, FROM_0, Part

Quaternion = tuple[Number, Number, Number, Number]


class Held(Part):
    """A body holds an object, as if both were one, until it lets go. A held object passes through other bodies."""

    body: str
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of the object's middle, in the body's frame
    orientation: Annotated[Quaternion, "1"] = (0.0, 0.0, 0.0, 1.0)  # of the object, in the body's frame
    until: Annotated[Number | None, "s", FROM_0] = None  # when it is let go; by default never


class Hinge(Part):
    """An axis that stands still, about which alone an object turns: of a seesaw, of a door."""

    axis: Annotated[Vector, "1"] = (1.0, 0.0, 0.0)  # in the object's axes at the start; of any length
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of a point of it, from the object's middle, in its axes
    damping: Annotated[Number, "N m s/rad", FROM_0] = 0.0


class Solid(Part, kw_only=True):
    """What objects of all kinds have. Those that are fixed need no mass, and hang or stand wherever they are put.

    Bodies feel an object by their shapes as capsules, as those of `body_contact`; edges of boxes are rounded by 2 cm
    for them, and sharp on the ground. A contact is a spring and a damper, by which a free impact has the restitution
    whatever its speed is. Objects pass through each other, but for those that `touches` names. Of two, the smaller
    stiffness, friction and restitution count.
    """

    mass: Annotated[Number, "kg", ABOVE_0] = 1.0
    position: Annotated[Vector, "m"] = (0.0, 0.0, 0.0)  # of its middle, at the start; of a held one `held` says it
    orientation: Annotated[Quaternion, "1"] = (0.0, 0.0, 0.0, 1.0)
    velocity: Annotated[Vector, "m/s"] = (0.0, 0.0, 0.0)
    angular_velocity: Annotated[Vector, "rad/s"] = (0.0, 0.0, 0.0)
    fixed: bool = False  # it does not move
    held: Held | None = None
    hinge: Hinge | None = None
    touches: list[str] = []  # other objects that it touches; one of both has to name the other
    bodies: list[str] = []  # that touch it; none named: all with shapes
    friction: Annotated[Number, "1", FROM_0] = 0.5
    restitution: Annotated[Number, "1", FRACTION] = 0.3  # speed after an impact over that before; 0.05 at least
    stiffness: Annotated[Number, "N/m", FROM_0] = 2.0e4  # of each contact; 0: it touches nothing
    tangential_damping: Annotated[Number, "N s/m", FROM_0] = 1.0e3  # up to the friction limit


class BallObject(Solid, tag_field="type", tag="ball"):
    """A solid ball."""

    radius: Annotated[Number, "m", ABOVE_0] = 0.1


class BoxObject(Solid, tag_field="type", tag="box"):
    """A box."""

    size: Annotated[Vector, "m", ABOVE_0] = (0.2, 0.2, 0.2)  # along its axes


class CapsuleObject(Solid, tag_field="type", tag="capsule"):
    """A cylinder along y with round ends."""

    radius: Annotated[Number, "m", ABOVE_0] = 0.05
    length: Annotated[Number, "m", ABOVE_0] = 0.2  # of the cylinder, without the ends


AnyObject = BallObject | BoxObject | CapsuleObject
