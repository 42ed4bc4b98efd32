"""What a body may lean on besides the ground: objects that are fixed, such as a seat or a rail."""

import warp as wp

from warpmuscle.kernels.functions import func
from warpmuscle.kernels.object_structs import ObjectExtension
from warpmuscle.kernels.objects.shape import between, nearest_on_segment
from warpmuscle.kernels.program.structs import Frames, Layout
from warpmuscle.kernels.structs import at


@wp.struct
class Support:
    """Where a shape of a body is nearest to an object."""

    point: wp.vec3  # m, world
    normal: wp.vec3  # unit vector from the object to the body
    gap: float  # m between both; negative where they touch
    friction: float


@func
def support_of(instance: int, number: int, layout: Layout, frames: Frames, objects: ObjectExtension) -> Support:
    """The support of this number in `layout.support`; edges are rounded as bodies feel them."""
    row = at(objects.row, instance, layout.support[number, 1])
    capsule = at(objects.capsule, instance, layout.support[number, 0])
    body = layout.support[number, 2]
    turn = frames.orientation[instance, body]
    rotation = wp.quat_to_matrix(row.orientation)
    core = row.half - wp.vec3(
        wp.min(row.rounding, row.half[0]), wp.min(row.rounding, row.half[1]), wp.min(row.rounding, row.half[2])
    )
    apart = frames.position[instance, body] + wp.quat_rotate(turn, capsule.middle) - row.place
    middle = wp.transpose(rotation) * apart
    along = wp.transpose(rotation) * wp.quat_rotate(turn, capsule.half)
    near = between(middle + along * nearest_on_segment(middle, along, core), core)
    radius = row.radius + row.rounding
    s = Support()
    s.normal = rotation * near.normal
    s.gap = near.distance - radius - capsule.radius
    s.point = row.place + rotation * near.on_box + s.normal * radius
    s.friction = row.friction
    return s
