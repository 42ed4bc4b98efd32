"""The laws of contact with the ground, by the numbers that `scene.Ground` has names for."""

from typing import Any

from warpmuscle.kernels.contact.contact import point_contacts_of
from warpmuscle.kernels.contact.hunt_crossley import hunt_crossley_contacts_of
from warpmuscle.kernels.contact.terrain import FLAT

SPRING, HUNT_CROSSLEY, SMOOTH_HUNT_CROSSLEY, SOFT_CONSTRAINT = 0, 1, 2, 3
LAWS = {
    "spring": SPRING, "hunt_crossley": HUNT_CROSSLEY, "smooth_hunt_crossley": SMOOTH_HUNT_CROSSLEY,
    "soft_constraint": SOFT_CONSTRAINT,
}  # fmt: skip

TOUCHING = (0.0, 0.0, 1.0, 0.0)  # N, by law: smooth contacts push a little before they touch


def body_contacts_of(law: int, terrain: int = FLAT, moves: bool = False) -> Any:
    """The Warp function of all contacts of a body by a law, on ground that is FLAT, RISES or is PATCHED, and moves."""
    if law in (SPRING, SOFT_CONSTRAINT):
        return point_contacts_of(law == SOFT_CONSTRAINT, terrain, moves)
    return hunt_crossley_contacts_of(law == SMOOTH_HUNT_CROSSLEY, terrain, moves)
