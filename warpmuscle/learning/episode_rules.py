"""What is drawn for the episodes of a task, as kernels are given it, and room for where every instance is."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import RolloutError
from warpmuscle.kernels.learning.episodes import AT_ONCE, NOT_YET, QUARTERS, EpisodeRules, Episodes
from warpmuscle.learning.imitation import Gait, run_from
from warpmuscle.model.joints import root_number
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Imitation, Task
from warpmuscle.scene.learning.task import ANY_DIRECTION, ANY_PHASE, GROWING


def room_for(instances: int, commands: int, device: wp.Device) -> Episodes:
    """Where every instance is in its episode, which has so many commands; all of it zero."""
    episodes = Episodes()
    for name, member in Episodes.vars.items():
        columns = {"command": commands, "push_hardness": QUARTERS}.get(name)
        size: Any = 1 if name == "seed" else instances if columns is None else (instances, columns)
        setattr(episodes, name, wp.zeros(size, dtype=member.type.dtype, device=device))
    return episodes


def put_first_hardness(episodes: Episodes, rules: EpisodeRules) -> None:
    """Let episodes be as hard as those before which there was none."""
    episodes.hardness.fill_(0.0 if rules.growth > 0.0 else 1.0)
    episodes.push_hardness.fill_(0.0 if rules.push_growth > 0.0 else 1.0)


def check_hardness(episodes: Episodes) -> None:
    """Raise RolloutError for a state from outside whose episodes cannot be as hard as it says."""
    for array in (episodes.hardness, episodes.push_hardness):
        hardness = array.numpy()
        if not ((hardness >= 0.0) & (hardness <= 1.0)).all():
            raise RolloutError("this state has a hardness that is not from 0 to 1")
    pushed = episodes.pushed.numpy()
    if not ((pushed >= NOT_YET) & (pushed < QUARTERS)).all():
        raise RolloutError("this state has a push to a side that does not exist")


def rules_of(
    task: Task, scene: Scene, gait: Gait | None, phases: Floats, variants: int, dt: float, longest: int,
    device: wp.Device,
) -> EpisodeRules:  # fmt: skip
    """What is drawn for episodes.

    Args:
        gait: that is imitated. phases: of it, at which the starts stand. variants: of the body.
        dt: s, of a decision. longest: decisions of an episode.
    """
    variation, rules = task.variation, EpisodeRules()
    rules.root, rules.starts, rules.variants = root_number(scene.character), len(phases), variants
    rules.start_phase = to_device(phases, float, device)
    _put_clock(rules, task, gait)
    intervals = np.array([task.speed, task.turning_rate, *task.pose.values()])
    rules.command_decisions = round(task.command_time / dt)
    rules.command_low = to_device(intervals[:, 0], float, device)
    rules.command_high = to_device(intervals[:, 1], float, device)
    rules.turning_share, rules.left_out = task.turning_share, 1.0 - variation.graded_share
    rules.velocity_noise, rules.push = variation.velocity_noise, variation.push
    rules.push_decisions = max(round(variation.push_interval / dt), 1) if variation.push > 0.0 else 0
    rules.growth, rules.longest = variation.growth, longest
    grows = {name: int(name in variation.growing) for name in GROWING}
    rules.velocity_grows, rules.push_grows = grows["velocity_noise"], grows["push"]
    against = variation.lasting / (1.0 - variation.lasting)
    rules.shrinkage, rules.push_shrinkage = against * variation.growth, against * variation.push_growth
    rules.push_least, rules.push_growth = variation.push_least, variation.push_growth
    rules.pushed_share = variation.pushed_share
    _put_aim(rules, task)
    rules.push_steps = max(round(variation.push_duration / scene.time_step), 1)
    rules.time_step, rules.decision_time = scene.time_step, dt
    return rules


def _put_aim(rules: EpisodeRules, task: Task) -> None:
    """When and whereto pushes come that have a phase or a direction."""
    variation = task.variation
    any_time = variation.push_phase == ANY_PHASE
    aimed = not (any_time and variation.push_direction == ANY_DIRECTION)
    rules.aimed_share = variation.aimed_share if aimed else 0.0
    rules.push_phase = wp.vec2(AT_ONCE, AT_ONCE) if any_time else wp.vec2(*variation.push_phase)
    rules.push_angle = wp.vec2(*np.radians(variation.push_direction))
    rules.push_mirrored = int(task.symmetric)
    rules.push_from_heading = int(aimed or variation.push_growth > 0.0)


def _put_clock(rules: EpisodeRules, task: Task, gait: Gait | None) -> None:
    """How fast the clock of an imitated gait goes."""
    imitation = task.imitation or Imitation()
    rules.cycle_rate = 0.0 if gait is None else 1.0 / gait.cycle_time
    rules.clock_speed, rules.cadence_power = imitation.clock_speed, imitation.cadence_power
    rules.run_from = run_from(task) or 0.0
    if (run := imitation.run) is not None:
        rules.run_rate, rules.run_speed, rules.run_power = 1.0 / run.cycle_time, run.clock_speed, run.cadence_power
