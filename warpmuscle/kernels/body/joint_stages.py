"""The stages of a step that know of joints' types and of how inertia lies in bodies, as a model has them."""

from functools import cache
from typing import Any, NamedTuple

from warpmuscle.kernels.body.along_runs import (
    accelerate_next_of,
    accelerated_of,
    pass_along_runs_of,
    place_along_runs,
)
from warpmuscle.kernels.body.coordinate_joint import (
    accelerate_any,
    accelerate_any_remaining,
    move_any_of,
    place_any,
    prescribe_any,
    reduce_any,
    reduce_any_remaining,
)
from warpmuscle.kernels.body.dynamics import (
    acceleration_stage,
    acceleration_stage_of,
    backward_pass_of,
    forward_pass_of,
)
from warpmuscle.kernels.body.followed import (
    accelerate_followed_of,
    followed_acceleration_stage_of,
    followed_hybrid_stage_of,
)
from warpmuscle.kernels.body.followed_reduction import followed_pass_of, reduce_followed_of
from warpmuscle.kernels.body.follower import (
    backward_pass_of_clusters,
    forward_pass_of_clusters,
    integrate_drivers_stage,
    reduce_any_cluster,
    reduce_remaining_cluster,
)
from warpmuscle.kernels.body.hybrid import hybrid_acceleration_stage, hybrid_acceleration_stage_of
from warpmuscle.kernels.body.inertia import inertia_stage_of
from warpmuscle.kernels.body.integration import integrate_stage
from warpmuscle.kernels.body.joint_motion import MotionOf, displacements_stage_of, has_displacements
from warpmuscle.kernels.body.kinematics import kinematics_stage, kinematics_stage_of
from warpmuscle.kernels.body.motion import prescribe_stage
from warpmuscle.kernels.body.single_axes import single_pass_of
from warpmuscle.kernels.contact.contact_laws import SPRING
from warpmuscle.kernels.contact.terrain import FLAT
from warpmuscle.kernels.memory.main_memory import Apart, nothing_near, poses_near
from warpmuscle.kernels.memory.scratch import (
    ENTRIES,
    LEANER,
    LEANEST,
    NEAR,
    coordinate_work_at_of,
    followed_work_at_of,
    pushed_work_at_of,
    work_at,
)
from warpmuscle.kernels.structs import FOLLOWER


class SkeletonKind(NamedTuple):
    """What a step has compiled in for bodies and joints."""

    joints: tuple[MotionOf, ...] = ()  # types of joints of one coordinate
    turned: bool = False  # principal axes of inertia lie in some body as its `inertia_axes` say
    contact: int = SPRING  # law of the ground's contacts, see `contact_laws.py`
    followed: int = 0  # coordinates that joints far from theirs follow, and all others that are followed then
    constraints: int = 0  # rows of constraints between bodies, with which all followed coordinates count
    terrain: int = FLAT  # whether the ground rises over its plane, see `contact/terrain.py`
    resistance: bool = False  # whether some joints have armature or damping, see `resistance.py`
    moves: bool = False  # whether the ground moves along itself, see `contact/belts.py`
    of_two: bool = False  # whether some joints depend on two coordinates, see `two_coordinates.py`
    entries: int = 0  # pairs of a body and an unknown that stays open to the root and acts on it, see `followed.py`
    single: bool = False  # whether no joint has more than one axis, see `single_axes.py`
    main: int = NEAR  # how much of a working set is in a GPU's main memory, see `main_memory.py`

    @property
    def follows(self) -> bool:
        """Whether some joints follow others."""
        return any(joint.number == FOLLOWER for joint in self.joints)

    @property
    def open(self) -> int:
        """Unknowns that stay open to the root, see `followed.py`."""
        return self.followed + self.constraints

    @property
    def near_entries(self) -> int:
        """Entries that the working set has room for."""
        return self.entries if self.main < ENTRIES else 0

    def apart(self, bodies: int, slots: int) -> Apart:
        """What of a working set with so many bodies and slots of feet is in a GPU's main memory."""
        return Apart(self.main, self.entries, bodies, slots, self.open, self.constraints)

    @property
    def with_coordinates(self) -> bool:
        """Whether the working set has what joints of one coordinate need."""
        return bool(self.joints) or self.constraints > 0


class JointStages(NamedTuple):
    """Warp functions of these stages."""

    work_at: Any
    kinematics: Any
    prescribe: Any
    inertia: Any
    acceleration: Any
    hybrid_acceleration: Any
    integrate: Any


@cache
def joint_stages_of(kind: SkeletonKind, several_warps: bool = False) -> JointStages:
    """The stages of a model with such bodies and joints."""
    inertia_stage = inertia_stage_of(kind.turned, kind.contact, kind.terrain, kind.resistance, kind.moves)
    if not kind.with_coordinates:
        return JointStages(
            work_at, kinematics_stage, prescribe_stage, inertia_stage, acceleration_stage, hybrid_acceleration_stage,
            integrate_stage,
        )  # fmt: skip
    displaced = several_warps and has_displacements(kind.joints)
    sparse = kind.main >= LEANER
    prepare = displacements_stage_of(sparse) if displaced else None
    backward, forward = backward_pass_of, forward_pass_of
    reduce, reduce_rest, integrate = reduce_any, reduce_any_remaining, integrate_stage
    if kind.follows:
        backward, forward = backward_pass_of_clusters, forward_pass_of_clusters
        reduce, reduce_rest, integrate = reduce_any_cluster, reduce_remaining_cluster, integrate_drivers_stage
    views = coordinate_work_at_of(kind.main)
    if kind.open:
        views = followed_work_at_of(kind.open, kind.near_entries, kind.main)
        if kind.constraints:
            views = pushed_work_at_of(kind.open, kind.near_entries, kind.constraints, kind.main)
        if kind.main >= LEANEST:
            views = poses_near if kind.main == LEANEST else nothing_near
        constrained = kind.constraints > 0
        acceleration, hybrid = (
            stage_of(
                single_pass_of(rest, constrained)
                if kind.single
                else followed_pass_of(reduce_followed_of(rest, constrained, several_warps), several_warps),
                pass_along_runs_of(accelerate_next_of(rest), accelerated_of)
                if kind.single
                else forward_pass_of(accelerate_followed_of(rest)),
                constrained,
                kind.single,
            )
            for stage_of, rest in ((followed_acceleration_stage_of, False), (followed_hybrid_stage_of, True))
        )  # fmt: skip
    else:
        acceleration = acceleration_stage_of(backward(reduce), forward(accelerate_any))
        hybrid = hybrid_acceleration_stage_of(backward(reduce_rest), forward(accelerate_any_remaining))
    return JointStages(
        views,
        kinematics_stage_of(
            move_any_of(kind.joints, displaced, kind.of_two, sparse),
            place_any,
            prepare,
            place_along_runs if kind.single and kind.open else None,
        ),
        prescribe_any,
        inertia_stage,
        acceleration,
        hybrid,
        integrate,
    )
