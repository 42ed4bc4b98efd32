"""The inertia of a whole body against each of its speeds, by composite bodies (Featherstone 2008, table 6.2)."""

import warp as wp

from warpmuscle.kernels.algebra.spatial import symmetric_times
from warpmuscle.kernels.body.dynamics import leave_for_parent
from warpmuscle.kernels.body.inertia import body_inertia_of
from warpmuscle.kernels.body.resistance import armature_of
from warpmuscle.kernels.body.speed_axes import angular_axis, linear_axis, moving_speeds
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import FOLLOWER, ModelRef, ScratchRef, StateRef

body_inertia = body_inertia_of(True)


@func
def add_mass_matrix(instance: int, model: ModelRef, state: StateRef, work: ScratchRef, matrix: wp.array3d[float]):
    """Add the joint-space inertia of an instance, whose kinematics are known, to (instances, speeds, speeds)."""
    skeleton = model.skeleton
    for body in range(model.body_count):
        body_inertia(instance, body, model, work)
    for back in range(1, model.body_count + 1):
        body = model.body_count - back
        a = work.block_a[body]
        b = work.block_b[body]
        c = work.block_c[body]
        for k in range(moving_speeds(body, model)):
            axis = angular_axis(instance, body, k, model, work)
            direction = linear_axis(body, k, model, work)
            n = symmetric_times(a, axis) + b * direction
            f = wp.transpose(b) * axis + symmetric_times(c, direction)
            column = skeleton.plan[body].speed_start + k
            above = int(body)
            while above >= 0:
                for j in range(moving_speeds(above, model)):
                    m = wp.dot(angular_axis(instance, above, j, model, work), n) + wp.dot(
                        linear_axis(above, j, model, work), f
                    )
                    row = skeleton.plan[above].speed_start + j
                    if above == body and j > k:
                        continue
                    matrix[instance, row, column] = matrix[instance, row, column] + m
                    if above != body or j != k:
                        matrix[instance, column, row] = matrix[instance, column, row] + m
                parent = skeleton.plan[above].parent
                if parent >= 0:
                    n = n + wp.cross(work.position[above] - work.position[parent], f)
                above = parent
        if body > 0:
            parent = skeleton.plan[body].parent
            leave_for_parent(
                body, work.position[body] - work.position[parent], a, b, c, wp.vec3(0.0), wp.vec3(0.0), work
            )
            work.block_a[parent] = work.block_a[parent] + work.block_a[body]
            work.block_b[parent] = work.block_b[parent] + work.block_b[body]
            work.block_c[parent] = work.block_c[parent] + work.block_c[body]
    for body in range(1, model.body_count):
        if skeleton.plan[body].joint_type != FOLLOWER:  # whose armature its driver has
            for k in range(moving_speeds(body, model)):
                own = skeleton.plan[body].speed_start + k
                matrix[instance, own, own] = matrix[instance, own, own] + armature_of(instance, body, model, state)
