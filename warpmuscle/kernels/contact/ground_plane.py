"""The plane of the ground, over which terrain may rise, see `terrain.py`."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import ModelRef, at


@func
def above_ground(instance: int, point: wp.vec3, model: ModelRef) -> float:
    """Distance of a point from the plane of the ground, m: on a slope, a walk loses or gains no height."""
    return wp.dot(at(model.contacts.normal, instance, 0), point) - at(model.contacts.height, instance, 0)
