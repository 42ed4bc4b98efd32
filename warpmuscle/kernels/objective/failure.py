"""When an instance has failed."""

from functools import cache
from typing import Any

import warp as wp

from warpmuscle.kernels.algebra.spatial import heading, heading_angle
from warpmuscle.kernels.contact.ground_plane import above_ground
from warpmuscle.kernels.functions import func
from warpmuscle.kernels.structs import (
    CROSSED,
    DIVERGED,
    FAILED,
    FELL,
    LARGEST,
    RUNNING,
    STOPPED,
    TOUCHED,
    TURNED,
    ModelRef,
    ScratchRef,
    StateRef,
    at,
)

CONDITION_MET = 2  # in the flag of a step that otherwise is 1 if it diverged


@func
def has_fallen(height: float, start_height: float, fraction: float) -> bool:
    """Whether the centre of mass is below a fraction of its initial height (Bergmann 2017, section 6); NaN has."""
    return not (height >= fraction * start_height)


@func
def turn_between(angle: float, desired: float) -> float:
    """The turn from a heading to another one on the shorter way, whole revolutions left out, rad, -pi..pi."""
    turn = angle - desired
    return turn - wp.static(2.0 * wp.PI) * wp.round(turn * wp.static(0.5 / wp.PI))


@func
def has_turned(angle: float, desired: float, largest: float) -> bool:
    """Whether the heading is off by more than `largest` (Bergmann 2017, section 6: 45 degrees); never if 0."""
    return largest > 0.0 and not (wp.abs(turn_between(angle, desired)) <= largest)


@func
def nearest_on_the_way(angle: float, start: float, desired: float) -> float:
    """The heading nearest to an angle on the shorter way from the starting heading to the desired one, rad."""
    way = turn_between(desired, start)
    return start + wp.clamp(turn_between(angle, start), wp.min(way, 0.0), wp.max(way, 0.0))


@func
def has_crossed(apart: float, largest: float) -> bool:
    """Whether the left foot is farther to the right of the right foot than `largest`, m; NaN has."""
    return not (apart >= -largest)


@func
def is_somewhere(place: wp.vec3) -> bool:
    """Whether a place is within all bounds; NaN is not."""
    return wp.abs(place[0]) + wp.abs(place[1]) + wp.abs(place[2]) < LARGEST


@func
def feet_apart(model: ModelRef, work: ScratchRef) -> float:
    """How far the joint of the left foot is to the left of that of the right foot, as the character faces, m."""
    between = work.position[model.feet.left] - work.position[model.feet.right]
    return wp.quat_rotate_inv(heading(work.orientation[0]), between)[0]


@cache
def begin_step_of(above: Any) -> Any:
    """The Warp function that begins a step, see `begin_step`.

    Args:
        above: how far a point is above the ground, m: `above_ground`, or `above_terrain` where it is not flat.
    """

    @func
    def begin_step(instance: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef):
        """Nothing has diverged yet; in the first step, remember how the instance starts. One lane calls it."""
        work.flags[1] = 0
        if step == 0:
            state.start_height[instance] = above(instance, work.center[0], model)
            state.start_heading[instance] = heading_angle(work.orientation[0])

    return begin_step


@cache
def posture_status_of(above: Any) -> Any:
    """The Warp function of a posture, see `posture_status`.

    Args:
        above: how far a point is above the ground, m: `above_ground`, or `above_terrain` where it is not flat.
    """

    @func
    def posture_status(instance: int, model: ModelRef, state: StateRef, work: ScratchRef) -> int:
        """Status by the pose and speed at the start of a step: RUNNING, DIVERGED, FELL, TURNED or CROSSED."""
        limits = at(model.failure, instance, 0)
        place, velocity = work.center[0], work.center[1]
        if not (is_somewhere(place) and wp.dot(velocity, velocity) <= model.fastest * model.fastest):
            return DIVERGED
        if limits.com_height > 0.0:  # noqa: SIM102, `and` would compute both
            if has_fallen(above(instance, place, model), state.start_height[instance], limits.com_height):
                return FELL
        wanted = at(model.heading, instance, 0)
        if model.turns_from_start == 1:
            wanted = state.start_heading[instance]
        angle = heading_angle(work.orientation[0])
        if not (wp.abs(angle - wanted) <= limits.heading):  # the rest is for the few who seem to have turned
            start = state.start_heading[instance]
            if has_turned(angle, nearest_on_the_way(angle, start, wanted), limits.heading):
                return TURNED
        if limits.leg_crossing > 0.0 and has_crossed(feet_apart(model, work), limits.leg_crossing):
            return CROSSED
        return RUNNING

    return posture_status


begin_step, posture_status = begin_step_of(above_ground), posture_status_of(above_ground)


@func
def step_status(model: ModelRef, work: ScratchRef) -> int:
    """Status by what happened in a step: RUNNING, DIVERGED or TOUCHED."""
    if work.flags[1] == 1:
        return DIVERGED
    if model.fail_on_body_contact == 1 and work.flags[0] == 1:
        return TOUCHED
    return RUNNING


@func
def window_begins(instance: int, step: int, model: ModelRef) -> bool:
    """Whether one window of the mean speed of `progress_status` ends with a step, and the next begins."""
    steps = wp.max(int(at(model.failure, instance, 0).no_progress_window / model.time_step + 0.5), 1)
    return step % steps == 0


@func
def progress_status(instance: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef) -> int:
    """STOPPED if the centre of mass went less far over the ground than it must in the window that ends, else RUNNING.

    Windows follow one another, so that one place an instance is kept. All lanes see the same.
    """
    limits = at(model.failure, instance, 0)
    if limits.no_progress <= 0.0 or step == 0 or not window_begins(instance, step, model):
        return RUNNING
    gone = work.center[0] - state.passed[instance]
    if not (gone[0] * gone[0] + gone[2] * gone[2] >= wp.pow(limits.no_progress * limits.no_progress_window, 2.0)):
        return STOPPED
    return RUNNING


@func
def remember_place(instance: int, step: int, model: ModelRef, state: StateRef, work: ScratchRef):
    """Keep where a window of `progress_status` begins. One lane calls it, a barrier after that."""
    if window_begins(instance, step, model):
        state.passed[instance] = work.center[0]


@func
def condition_status(work: ScratchRef) -> int:
    """FAILED if a condition of the scene's own was met in a step, and nothing diverged, else RUNNING."""
    if work.flags[1] == CONDITION_MET:
        return FAILED
    return RUNNING
