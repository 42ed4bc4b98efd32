"""What is checked of a task that a policy learns."""

from __future__ import annotations

import math

from warpmuscle.core.errors import SceneError
from warpmuscle.core.plain_text import number_of
from warpmuscle.kernels.objective.objective_terms import REWARDS, SIZES, TERMS
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.learning import Goal, ImitatedRun, Imitation, Rewards, Task, Tightening, Variation
from warpmuscle.scene.learning.task import ANY_PHASE, GROWING, Interval
from warpmuscle.scene.norms import IMITATED, RUNNING, is_run
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.checks import Checks, known
from warpmuscle.scene.validation.objective import check_needs

LONGEST_HISTORY = 100  # decisions
LONGEST_DELAY = 1.0  # s, longer than of any nerve; what was felt meanwhile is kept
HIGHER_IS_WIDER = ("heading", "leg_crossing", "self_collision")  # limits of failure; of the others lower ones are
STEEPEST_PELVIS = 45.0  # deg, forwards or backwards
LARGEST_COUNT = 65536  # of starts and variants, which lie in the memory of the device


def check_task(check: Checks) -> None:
    """Times are positive, intervals are intervals, names are those of muscles; see `learning` for the rest."""
    task = check.checked.learning
    if task is None:
        return
    if task.decision_time < check.checked.time_step:
        raise SceneError(
            f"{task.decision_time:g} s is shorter than a time step, {check.checked.time_step:g} s",
            key="learning.decision_time",
        )
    if task.episode_time is not None and task.episode_time < task.decision_time:
        raise SceneError("an episode must last for one decision at least", key="learning.episode_time")
    _interval("learning.speed", task.speed)
    _interval("learning.turning_rate", task.turning_rate)
    for name, interval in task.pose.items():
        _interval(f"learning.pose.{name}", interval)
    for name, sense in task.observations.items():
        if sense.delay > LONGEST_DELAY:
            key = f"learning.observations.{name}.delay"
            raise SceneError(f"must be {LONGEST_DELAY:g} s at most, is {sense.delay:g}", key=key)
        if not 0 <= sense.history <= LONGEST_HISTORY:
            key = f"learning.observations.{name}.history"
            raise SceneError(f"must be 0 to {number_of(LONGEST_HISTORY, 'decision')}, is {sense.history}", key=key)
    for name, parts in task.synergies.items():
        for muscle in parts:
            known(muscle, check.checked.character.muscles, "muscle", f"learning.synergies.{name}.{muscle}")
    for name, weight in task.rewards.custom.items():
        key = f"learning.rewards.custom.{name}"
        if ":" not in name:
            known(name, [term.name for term in TERMS.values() if term.scope != "batch"], "term", key)
            check_needs(check.checked, name, key)
        if not 0.0 <= weight < math.inf:
            raise SceneError(f"must not be negative, is {weight:g}: a part declares its sign", key=key)
    _at_speed(task.rewards)
    for name, goal in task.goals.items():
        _goal(f"learning.goals.{name}", goal)
    _variation(check, task.variation)
    _aim(task)
    if task.imitation is not None:
        _imitation(check, task.imitation)
        if task.imitation.run is not None:
            _run(task, task.imitation.run)
    if task.tightening is not None:
        _tightening(check, task, task.tightening)


def _goal(key: str, goal: Goal) -> None:
    """A goal is drawn in one way, and has one number or three."""
    if bool(goal.draw) == bool(goal.low or goal.high):
        raise SceneError("give either low and high, or draw", key=key)
    if goal.draw:
        return
    if len(goal.low) != len(goal.high) or len(goal.low) not in (1, 3):
        raise SceneError("low and high have three numbers each, of a point, or one", key=key)
    for low, high in zip(goal.low, goal.high, strict=True):
        _interval(key, (low, high))


def _imitation(check: Checks, imitation: Imitation) -> None:
    """There is a gait, and norms and joints of these names."""
    key, scene = "learning.imitation", check.checked
    if scene.simbicon is None and not (imitation.file or imitation.norm):
        raise SceneError("there is no gait to imitate: give a `file` or a `norm`, or the scene a controller", key=key)
    if scene.feet is None:
        raise SceneError("a gait is imitated with two feet; name them in character.feet", key=key)
    if imitation.replay and not imitation.file:
        raise SceneError("is used only with learning.imitation.file", key=f"{key}.replay")
    alone = imitation.norm_alone or scene.simbicon is None
    if alone and is_run(imitation.norm) and imitation.cycle_time is None and not imitation.file:
        raise SceneError(
            "say how long a cycle of the run takes: people's walks tell nothing of it", key=f"{key}.cycle_time"
        )
    starts = check.checked.learning is not None and check.checked.learning.variation.start_states
    if starts and alone and not any(body.shapes for body in scene.character.bodies.values()):
        advice = "no body has a shape to stand on at the start; give the feet `shapes`"
        raise SceneError(advice, key="learning.variation.start_states")
    if imitation.uneven and scene.ground.terrain is None:
        raise SceneError("the ground is even everywhere: it has no terrain", key=f"{key}.uneven")
    tilt = imitation.pelvis_tilt
    if tilt is not None and abs(tilt) > STEEPEST_PELVIS:
        raise SceneError(f"must be within {STEEPEST_PELVIS:g} degrees, is {tilt:g}", key=f"{key}.pelvis_tilt")
    _norm(key, imitation)
    for name in imitation.weights:
        known(name, ["root", *scene.character.joints], "joint", f"{key}.weights.{name}")


def _run(task: Task, run: ImitatedRun) -> None:
    """The gait is a walk at the slowest wanted speed, and a run by a norm of runs at the fastest."""
    key, (low, high) = "learning.imitation.run", task.speed
    known(run.norm, [norm.source for norm in RUNNING], "norm of a run", f"{key}.norm")
    if task.imitation is not None and is_run(task.imitation.norm):
        raise SceneError("the gait is a run at all speeds by its norm; leave this out, or name a walk's norm", key=key)
    if not low < run.above < high:
        raise SceneError(
            f"must be between the wanted speeds, {low:g} and {high:g} m/s, is {run.above:g}", key=f"{key}.above"
        )


def _norm(key: str, imitation: Imitation) -> None:
    """The norm is known, and what is asked of it too."""
    if imitation.norm:
        known(imitation.norm, [norm.source for norm in IMITATED], "norm", f"{key}.norm")
    elif imitation.moving:
        raise SceneError("only the angles of a norm change with the speed; name one in `norm`", key=f"{key}.moving")
    if imitation.norm_alone and (imitation.file or not imitation.norm):
        raise SceneError("a norm alone is a gait: name one in `norm`, and no `file`", key=f"{key}.norm_alone")


def _variation(check: Checks, variation: Variation) -> None:
    """Parts are less than the whole, counts are counts."""
    key = "learning.variation"
    for name in ("mass", "strength", "side_strength", "lasting"):
        if getattr(variation, name) >= 1.0:
            raise SceneError(f"must be less than 1, is {getattr(variation, name):g}", key=f"{key}.{name}")
    for name in variation.growing:
        known(name, GROWING, "disturbance that can grow", f"{key}.growing")
    for name in variation.commands:
        known(name, check.checked.commands, "command", f"{key}.commands")
    for name, least in (("start_states", 0), ("variants", 1), ("poses", 1)):
        if not least <= getattr(variation, name) <= LARGEST_COUNT:
            raise SceneError(f"must be {least} to {LARGEST_COUNT}, is {getattr(variation, name)}", key=f"{key}.{name}")
    _starts(check, variation)


def _aim(task: Task) -> None:
    """Pushes come within one cycle of a gait that is imitated, and go within one turn."""
    key, variation = "learning.variation", task.variation
    for name, low, high, most in (("push_phase", 0.0, 2.0, 1.0), ("push_direction", -360.0, 360.0, 360.0)):
        first, last = getattr(variation, name)
        if not (low <= first <= last <= high and last - first <= most):
            text = f"must be a lower and an upper number of {low:g} to {high:g}, at most {most:g} apart"
            raise SceneError(f"{text}, is {first:g}, {last:g}", key=f"{key}.{name}")
    if variation.push_phase != ANY_PHASE and task.imitation is None:
        raise SceneError("there is no clock without learning.imitation", key=f"{key}.push_phase")


def _starts(check: Checks, variation: Variation) -> None:
    """Ranges are those of coordinates of their own; states have one source."""
    key, joints = "learning.variation", check.checked.character.joints
    own = [
        f"{name}.{part}".rstrip(".")
        for name, joint in joints.items()
        if not joint_type(joint).quaternion
        for part in joint_type(joint).coordinates
    ]
    for name, interval in variation.pose.items():
        if name in joints and joint_type(joints[name]).quaternion:
            raise SceneError("is a ball joint, which has no single angle; see joint_noise", key=f"{key}.pose.{name}")
        known(name, own, "coordinate of a joint", f"{key}.pose.{name}")
        _interval(f"{key}.pose.{name}", interval)
        if not math.isfinite(interval[0]) or not math.isfinite(interval[1]):
            raise SceneError("must have finite ends", key=f"{key}.pose.{name}")
    if variation.graded:
        known(variation.graded, variation.commands, "command of learning.variation.commands", f"{key}.graded")
        task = check.checked.learning
        if task is None or not task.curriculum:
            raise SceneError("variants are graded by the difficulty that learning.curriculum makes", f"{key}.graded")
    if not 0.0 < variation.graded_share <= 1.0:
        raise SceneError(f"must be above 0 and at most 1, is {variation.graded_share:g}", key=f"{key}.graded_share")
    if variation.start_file and variation.start_states:
        raise SceneError("give either a file of states or start_states, those of the gait", key=f"{key}.start_file")


def _tightening(check: Checks, task: Task, tightening: Tightening) -> None:
    """Limits are wider at first than those of the scene, which are plain numbers and on."""
    key, limits = "learning.tightening", check.checked.failure
    if tightening.decisions < 1:
        raise SceneError(f"must be 1 at least, is {tightening.decisions}", key=f"{key}.decisions")
    if not 0 <= tightening.held < tightening.decisions:
        less = f"must be 0 to less than decisions, {tightening.decisions}, is {tightening.held}"
        raise SceneError(less, key=f"{key}.held")
    if not (tightening.first or tightening.rewards or tightening.custom or tightening.costs is not None):
        raise SceneError("name at least one limit of [failure] that is wider at first, or costs, or rewards", key=key)
    _tightened_rewards(task.rewards, tightening)
    if tightening.costs == 1.0:
        raise SceneError("must be less than 1, the share of all costs in the end", key=f"{key}.costs")
    for name, first in tightening.first.items():
        last, place = getattr(limits, name), f"{key}.{name}"
        if name == "heading" and any(task.turning_rate):
            raise SceneError("turning is not a failure where learning.turning_rate asks for turns", key=place)
        if isinstance(last, Free):
            raise SceneError(f"tightens to failure.{name}, which must be one number, not free or by command", key=place)
        if last <= 0.0:
            raise SceneError(f"failure.{name} is 0, which switches it off; say what it tightens to", key=place)
        if not (last < first if name in HIGHER_IS_WIDER else first < last):
            wider = "greater" if name in HIGHER_IS_WIDER else "less"
            raise SceneError(f"must be {wider} than failure.{name}, {last:g}, is {first:g}", key=place)


def _tightened_rewards(rewards: Rewards, tightening: Tightening) -> None:
    """Rewards that are others at first are numbers that may change, and widths stay above 0."""
    key = "learning.tightening"
    names = [*REWARDS, *SIZES]
    for name, first in tightening.rewards.items():
        known(name, names, "number of learning.rewards that can change", f"{key}.rewards.{name}")
        if name.endswith("_width") and first <= 0.0:
            raise SceneError(f"must be above 0, is {first:g}", key=f"{key}.rewards.{name}")
    for name in tightening.custom:
        known(name, rewards.custom, "part of learning.rewards.custom", f"{key}.custom.{name}")


def _at_speed(rewards: Rewards) -> None:
    """What counts at a speed is rewarded at all, and has a width."""
    for name, (speed, width) in rewards.at_speed.items():
        key = f"learning.rewards.at_speed.{name}"
        known(name, rewards.custom, "part of learning.rewards.custom", key)
        if not (math.isfinite(speed) and 0.0 < width < math.inf):
            raise SceneError(f"write a wanted speed and a width above 0, m/s, not [{speed:g}, {width:g}]", key=key)


def _interval(key: str, interval: Interval) -> None:
    low, high = interval
    if not low <= high:
        raise SceneError(f"{low:g} is greater than {high:g}", key=key)
