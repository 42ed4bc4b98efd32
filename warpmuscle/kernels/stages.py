"""The stages of a step as kernels of their own over plain arrays, for pipelines of one's own and for tests.

Launch each with dim = instances. `workspace` is scratch memory, (instances,
`scratch.work_floats(scratch.capacity_of(bodies))`) floats, and more where paths are polynomials. A kernel of one's own
that calls the functions of these stages needs `enable_backward=False`, since they take structures by reference.
Body 0 is the root; body i hangs on joint i - 1.
"""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import full, symmetric
from warpmuscle.kernels.body.composite_bodies import add_mass_matrix
from warpmuscle.kernels.body.coordinate_joint import coordinate_velocities, put_groups
from warpmuscle.kernels.body.inertia import body_inertia_of
from warpmuscle.kernels.body.joint_motion import MotionOf, coupled_motion, slide_motion, turning_motion
from warpmuscle.kernels.body.joint_stages import SkeletonKind, joint_stages_of
from warpmuscle.kernels.body.speed_axes import speed_rate_of
from warpmuscle.kernels.constraint.constraints import constraint_stage
from warpmuscle.kernels.contact.contact_laws import SPRING, body_contacts_of
from warpmuscle.kernels.contact.terrain import FLAT
from warpmuscle.kernels.control.control import NO_CONTROLLER, ControllerKind, control_stage_of
from warpmuscle.kernels.memory.scratch import coordinate_work_at, monomials_at
from warpmuscle.kernels.muscle.muscle_kind import MuscleKind
from warpmuscle.kernels.muscle.muscle_stage import muscle_stage_of
from warpmuscle.kernels.path.path import joint_velocities
from warpmuscle.kernels.path.polynomial_path import monomials_stage
from warpmuscle.kernels.path.stretch import PathKind, any_stretch_of
from warpmuscle.kernels.structs import (
    DRIVING_HINGE,
    FIRST_OF_TABLE,
    FOLLOWER,
    Model,
    ModelRef,
    Record,
    Scratch,
    ScratchRef,
    State,
    StateRef,
    at,
)

wp.set_module_options({"enable_backward": False, "max_unroll": 1})


KNOWN_JOINTS = (  # as `model.joints` numbers them
    MotionOf(FOLLOWER, coupled_motion),
    MotionOf(DRIVING_HINGE, turning_motion),
    MotionOf(FIRST_OF_TABLE, slide_motion),
    MotionOf(FIRST_OF_TABLE + 1, coupled_motion),
)
OF_JOINTS = joint_stages_of(SkeletonKind(KNOWN_JOINTS, turned=True, resistance=True, of_two=True))
kinematics_stage, inertia_stage = OF_JOINTS.kinematics, OF_JOINTS.inertia
body_inertia = body_inertia_of(True)


@wp.func_native(snippet="return wp::array_t<float>(a.data + row * a.shape[1], a.shape[1]);")
def memory_of(a: wp.array2d[float], row: int) -> wp.array[float]: ...


@wp.func
def work_of(instance: int, model: ModelRef, workspace: wp.array2d[float]) -> Scratch:
    """The working set of an instance, in its row of the workspace."""
    room = memory_of(workspace, instance)
    work = coordinate_work_at(room, model.body_count, model.foot_slots)
    work.monomial = monomials_at(room, model.routes.monomial.shape[0])
    return work


@wp.kernel
def forward_kinematics(
    # in
    model: Model, state: State, workspace: wp.array2d[float],
    # out
    position: wp.array2d[wp.vec3], orientation: wp.array2d[wp.quat],
    velocity: wp.array2d[wp.vec3], angular_velocity: wp.array2d[wp.vec3], com: wp.array2d[wp.vec3],
):  # fmt: skip
    """Centres of mass, orientations and velocities of all bodies (instances, bodies), world; COM and its velocity."""
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    for body in range(model.body_count):
        c = work.rotation[body] * at(model.skeleton.row, i, body).com
        position[i, body] = work.position[body] + c
        orientation[i, body] = work.orientation[body]
        velocity[i, body] = work.velocity[body] + wp.cross(work.angular_velocity[body], c)
        angular_velocity[i, body] = work.angular_velocity[body]
    for k in range(2):
        com[i, k] = work.center[k]


@cache
def controller_torques(controller: ControllerKind = NO_CONTROLLER) -> Any:
    """The kernel (model, state, workspace, extension, target, torque) of a controller, see `control.control_stage_of`.

    It gives targets and torques (world, N m, + on the parent) for the joint of every body.
    """
    control_stage, extension_struct = control_stage_of(controller), controller.extension

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float], extension: extension_struct,
        # out
        target: wp.array2d[wp.quat], torque: wp.array2d[wp.vec3],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        own = extension
        kinematics_stage(i, 0, 1, model, state, work)
        control_stage(i, 0, 1, model, state, work, own)
        for body in range(model.body_count):
            target[i, body] = work.target[body]
            torque[i, body] = work.torque[body]

    return kernel


@cache
def contact_forces_of(law: int = SPRING, terrain: int = FLAT, moves: bool = False) -> Any:
    """The kernel (model, state, workspace, force, moment, a, b, c) of contacts with the ground by a law.

    Contact force on every body, N, and its moment about the body's centre of mass, N m, at the present velocity; and
    the tensors of `contact.ContactSum`, by which both become less as the body accelerates over a step.
    """
    contacts_of_body = body_contacts_of(law, terrain, moves)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float],
        # out
        force: wp.array2d[wp.vec3], moment: wp.array2d[wp.vec3],
        a: wp.array2d[wp.mat33], b: wp.array2d[wp.mat33], c_tensor: wp.array2d[wp.mat33],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        kinematics_stage(i, 0, 1, model, state, work)
        for body in range(model.body_count):
            total = contacts_of_body(i, body, state.step[i], model, work)
            force[i, body] = total.force
            a[i, body] = full(total.a)
            b[i, body] = total.b
            c_tensor[i, body] = full(total.c)
            c = work.rotation[body] * at(model.skeleton.row, i, body).com
            moment[i, body] = total.moment - wp.cross(c, total.force)

    return kernel


@cache
def stretch_all_of(kind: PathKind) -> Any:
    """The Warp function of kinematics, and then of the paths of all muscles of an instance.

    Its last arguments get length, m, and lengthening speed, m/s, by muscle, and moment arms, m, by crossing.

    Args:
        kind: what there is besides segments and pulleys.
    """
    any_stretch = any_stretch_of(kind, coordinate_joints=True, followers=True)
    polynomials, grouped = kind.monomials > 0, kind.groups > 0
    join = put_groups if grouped else None

    @wp.func
    def stretch_all(
        instance: int,
        model: ModelRef,
        state: StateRef,
        work: ScratchRef,
        length: wp.array[float],
        speed: wp.array[float],
        arm: wp.array[wp.vec3],
    ):
        kinematics_stage(instance, 0, 1, model, state, work)
        if wp.static(grouped):
            join(instance, 0, 1, model, state, work)
        joint_velocities(0, 1, model, work)
        coordinate_velocities(instance, 0, 1, model, work)
        if wp.static(polynomials):
            monomials_stage(instance, 0, 1, model, state, work)
        for muscle in range(model.muscles.count):
            stretch = any_stretch(instance, muscle, model, state, work, arm)
            length[muscle] = stretch.fixed + stretch.moving
            speed[muscle] = stretch.speed

    return stretch_all


@cache
def muscle_paths_of(kind: PathKind = PathKind()) -> Any:  # noqa: B008, immutable
    """The kernel (model, state, workspace, length, speed, arm) of the paths of all muscles.

    Length, m, and lengthening speed, m/s, of all muscles (instances, muscles), and all moment arms (instances,
    crossings), m, world axes; see `path.segments_stretch_of`.

    Args:
        kind: what there is besides segments and pulleys.
    """
    stretch_all = stretch_all_of(kind)

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float],
        # out
        length: wp.array2d[float], speed: wp.array2d[float], arm: wp.array2d[wp.vec3],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        stretch_all(i, model, state, work, length[i], speed[i], arm[i])

    return kernel


@cache
def muscle_torques(kind: MuscleKind, controller: ControllerKind = NO_CONTROLLER) -> Any:
    """The kernel (model, state, workspace, extension, desired, record, torque) of the muscles of a kind.

    It lets the muscles answer to desired joint torques (instances, bodies; world, N m, + on the parent) for one step,
    which it counts, and gives the torques that drive the joints instead. The record has a row an instance and one
    frame, whose `muscle` (instances, 1, quantities, muscles) gets what `muscle_stage` records.
    """
    muscle_stage, extension_struct = muscle_stage_of(kind, controller=controller), controller.extension

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False, "max_unroll": 1})
    def kernel(
        # in
        model: Model, state: State, workspace: wp.array2d[float], extension: extension_struct,
        desired: wp.array2d[wp.vec3],
        # in and out
        record: Record,
        # out
        torque: wp.array2d[wp.vec3],
    ):  # fmt: skip
        i = wp.tid()
        work = work_of(i, model, workspace)
        own = extension
        kinematics_stage(i, 0, 1, model, state, work)
        for body in range(model.body_count):
            work.torque[body] = desired[i, body]
            work.stiffness[body] = symmetric(0.0)
        muscle_stage(i, 0, 1, 0, model, state, record, work, own)
        for body in range(model.body_count):
            torque[i, body] = work.torque[body]
        state.step[i] = state.step[i] + 1

    return kernel


@cache
def forward_dynamics_of(followed: int = 0, constraints: int = 0, entries: int = 0, single: bool = False) -> Any:
    """The kernel of accelerations under joint torques (world, N m, + on the parent), gravity, contacts and limits.

    Contacts and limits are linearly implicit in a step of the model's length; without them the result is exact.

    Args:
        followed, constraints: coordinates and rows that stay open to the root, see `joint_stages.SkeletonKind`.
        entries, single: see there.

    The kernel returns
        speed_rate: (instances, speeds) time derivatives of the speeds.
        acceleration: (instances, bodies) of the centres of mass, world, m/s^2.
        angular_acceleration: (instances, bodies) world, rad/s^2.
    """
    kind = SkeletonKind(
        KNOWN_JOINTS, turned=True, followed=followed, constraints=constraints, of_two=True, entries=entries,
        single=single,
    )  # fmt: skip
    own = joint_stages_of(kind)
    accelerate, views = own.acceleration, own.work_at

    @wp.kernel(module="unique", enable_backward=False, module_options={"enable_backward": False})
    def forward_dynamics(
        # in
        model: Model, state: State, workspace: wp.array2d[float], torque: wp.array2d[wp.vec3],
        # out
        speed_rate: wp.array2d[float], acceleration: wp.array2d[wp.vec3], angular_acceleration: wp.array2d[wp.vec3],
    ):  # fmt: skip
        """Accelerations under joint torques (world, N m, + on the parent), gravity, contacts and joint limits."""
        i = wp.tid()
        work = views(memory_of(workspace, i), model.body_count, model.foot_slots)
        kinematics_stage(i, 0, 1, model, state, work)
        for body in range(model.body_count):
            work.torque[body] = torque[i, body]
            work.stiffness[body] = symmetric(0.0)
        if wp.static(constraints > 0):
            constraint_stage(i, 0, 1, model, state, work)
        inertia_stage(i, 0, 1, model, state, work)
        accelerate(i, 0, 1, model, work)
        for body in range(model.body_count):
            alpha = work.angular_acceleration[body]
            angular = work.angular_velocity[body]
            c = work.rotation[body] * at(model.skeleton.row, i, body).com
            centripetal = wp.cross(angular, wp.cross(angular, c))
            angular_acceleration[i, body] = alpha
            acceleration[i, body] = work.acceleration[body] + wp.cross(alpha, c) + centripetal
            first = model.skeleton.plan[body].speed_start
            if model.skeleton.plan[body].joint_type != FOLLOWER:
                for k in range(model.skeleton.plan[body].speed_end - first):
                    speed_rate[i, first + k] = speed_rate_of(body, k, model, work)

    return forward_dynamics


forward_dynamics = forward_dynamics_of()  # where no joint follows one that is not its neighbour


@wp.kernel
def mass_matrix(
    # in
    model: Model, state: State, workspace: wp.array2d[float],
    # out
    matrix: wp.array3d[float],
):  # fmt: skip
    """Joint-space inertia (instances, speeds, speeds) by composite bodies (Featherstone 2008, table 6.2)."""
    i = wp.tid()
    work = work_of(i, model, workspace)
    kinematics_stage(i, 0, 1, model, state, work)
    add_mass_matrix(i, model, state, work, matrix)
