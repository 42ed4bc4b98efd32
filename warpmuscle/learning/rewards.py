"""What decisions are worth: the task's terms, and the scene's own objective, evaluated on the device."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import rows, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.core.number_rows import first_number
from warpmuscle.kernels import structs
from warpmuscle.kernels.learning import rewards as kernels
from warpmuscle.kernels.learning.episodes import EpisodeRules, Episodes
from warpmuscle.kernels.learning.senses import Surroundings
from warpmuscle.kernels.objective.objective_terms import PER_DECISION, REWARDS, SIZES
from warpmuscle.learning.actions import BY_MUSCLES, Actions
from warpmuscle.learning.custom_parts import CustomParts, signed_weights
from warpmuscle.learning.imitation import Gait, gait_table
from warpmuscle.learning.tightening import with_rewards
from warpmuscle.model.objective import counted_terms, weight_of
from warpmuscle.scene.accounting import basal_rate
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.learning import Task
from warpmuscle.scene.validation.checks import near
from warpmuscle.simulation.rollout import Rollout


class Judge:
    """Rewards of a batch.

    Attributes:
        gains: what instances have gained, on the device. names: of all rewards, those of one's own last.
    """

    def __init__(
        self,
        task: Task,
        rollout: Rollout,
        actions: Actions,
        gait: Gait | None,
        model: structs.Model,
        decision_time: float,
        longest: int,
        own: CustomParts,
        costs: wp.array,
    ) -> None:
        """Make room; raises SceneError for coordinates that are not there.

        Args:
            costs: (1,) share of what rewards take off, which may change.
        """
        n, self._device = rollout.instances, rollout.device
        rules = kernels.RewardRules()
        moves = root_type(rollout.scene.character).forward is not None
        self.task, self._moves, self._decision_time = task, moves, decision_time
        self._present = task.rewards
        first = weights(with_rewards(task, 0), moves, decision_time)
        last = weights(task, moves, decision_time)
        rules.weight = kernels.term_values(*(max(pair, key=abs) for pair in zip(first, last, strict=True)))
        rules.now = to_device(self._numbers(task), float, self._device)
        rules.costs = costs
        rules.pose = to_device(pose_numbers(task, rollout.coordinate_names), int, self._device)
        rules.longest = longest
        rules.uneven = 0.0 if gait is None or task.imitation is None else task.imitation.uneven
        if gait is not None:
            rules.gait = gait_table(gait, task, rollout)
        rules.force_share = share_of_now(decision_time, task.rewards.force_smoothing)
        rules.speed_share = share_of_now(decision_time, task.rewards.speed_smoothing)
        rules.total_mass, rules.gravity = model.skeleton.total_mass, model.gravity
        muscular = rollout.excitable and actions.kind == "joint_targets"
        by_muscles = kernels.EXCITATIONS if actions.kind in BY_MUSCLES else kernels.ACTIVATIONS
        rules.effort = by_muscles if muscular or actions.kind in BY_MUSCLES else kernels.ACTIONS
        self._rules, self._weights = rules, objective_weights(rollout)
        gains = kernels.Gains()
        gains.action, gains.previous, gains.excitation = actions.action, actions.previous, actions.excitation
        gains.foot_force = wp.full((n, 2), kernels.UNKNOWN, dtype=float, device=self._device)
        gains.speed = wp.full(n, kernels.NO_SPEED, dtype=float, device=self._device)
        gains.objective = wp.zeros(n, dtype=wp.float64, device=self._device)
        gains.sums = wp.zeros((n, kernels.LOGGED), dtype=float, device=self._device)
        gains.finished = wp.zeros((n, kernels.LOGGED), dtype=float, device=self._device)
        gains.reward = wp.zeros(n, dtype=float, device=self._device)
        gains.terminated = wp.zeros(n, dtype=bool, device=self._device)
        gains.truncated = wp.zeros(n, dtype=bool, device=self._device)
        gains.custom = own.rewards
        if own.ends_fail:
            gains.custom_end = own.ends
        self._custom = functools.partial(signed_weights, own=own, rollout=rollout, decision_time=decision_time)
        gains.custom_weight = to_device(self._custom(task), float, self._device)
        near = np.array([task.rewards.at_speed.get(name, (0.0, 0.0)) for name in own.reward_names]).reshape(-1, 2)
        gains.custom_speed, gains.custom_width = (to_device(column, float, self._device) for column in near.T)
        shape = own.rewards.shape
        gains.custom_sums, gains.custom_finished = (wp.zeros(shape, dtype=float, device=self._device) for _ in range(2))
        gains.end_fails = to_device(own.ends_fail, int, self._device)
        gains.reached = wp.zeros(n, dtype=bool, device=self._device)
        self.gains, self.names = gains, (*kernels.TERMS, *own.reward_names)

    def after(self, decisions: int) -> None:
        """Let rewards be those after so many decisions of all instances together, where the task tightens any."""
        tightening = self.task.tightening
        if tightening is None or not (tightening.rewards or tightening.custom):
            return
        now = with_rewards(self.task, decisions)
        if now.rewards == self._present:
            return
        self._present = now.rewards
        wp.copy(self._rules.now, to_device(self._numbers(now), float, self._device))
        if tightening.custom:
            wp.copy(self.gains.custom_weight, to_device(self._custom(now), float, self._device))

    def _numbers(self, task: Task) -> Any:
        """Weights, widths and limits as kernels read them."""
        sizes = [getattr(task.rewards, name) for name in SIZES]
        return np.array([*weights(task, self._moves, self._decision_time), *sizes])

    @property
    def changing(self) -> list[wp.array]:
        """Arrays that decisions change and that later ones depend on."""
        gains = self.gains
        own = [array for array in (gains.custom_sums, gains.custom_finished) if array.size]
        return [gains.objective, gains.sums, gains.finished, gains.foot_force, gains.speed, *own]

    def judge(self, rules: EpisodeRules, episodes: Episodes, state: structs.State, around: Surroundings) -> None:
        """Reward the decision that has been made on the ground around, and see which episodes end."""
        if self._rules.uneven > 0.0:
            self._rules.around = around
        inputs = [self._rules, self._weights, rules, episodes, state, self.gains]
        wp.launch(kernels.judge, len(self.gains.reward), inputs, device=self._device)

    def forget(self, episodes: Episodes) -> None:
        """Begin to count again in episodes that begin."""
        wp.launch(kernels.forget, len(self.gains.reward), [episodes.mask, self.gains], device=self._device)


def share_of_now(decision_time: float, smoothing: float) -> float:
    """How much of what a decision finds a low-pass of first order with that time constant, s, takes over."""
    return 1.0 - math.exp(-decision_time / smoothing) if smoothing > 0.0 else 1.0


def weights(task: Task, moves: bool, decision_time: float) -> list[float]:
    """Signed weights of the terms of a decision, in the order of `kernels.learning.rewards.TERMS`."""
    given = {name: getattr(task.rewards, name) for name in kernels.TERMS}
    if not moves:  # what goes nowhere is not rewarded for going
        given |= dict.fromkeys(("speed", "progress", "heading", "side"), 0.0)
    if task.imitation is None:
        given |= dict.fromkeys(("imitation", "force", "contact"), 0.0)
    if not task.pose:
        given["pose"] = 0.0
    signed = {name: -REWARDS[name].factor * weight for name, weight in given.items()}
    return [weight * (1.0 if name in PER_DECISION else decision_time) for name, weight in signed.items()]


def pose_numbers(task: Task, coordinates: tuple[str, ...]) -> Any:
    """Numbers of the wanted coordinates; SceneError if there is no such."""
    for name in task.pose:
        if name not in coordinates:
            raise SceneError(f"there is no coordinate {name!r}{near(name, coordinates)}", key=f"learning.pose.{name}")
    return np.array([coordinates.index(name) for name in task.pose], dtype=np.int32)


def objective_weights(rollout: Rollout) -> kernels.ObjectiveWeights:
    """Weights of the sums that a batch makes, so that they add up to the scene's weighted objective.

    What `fall` weighs is left out: an episode that goes on has missed nothing yet.
    """
    scene, kind, device = rollout.numeric, rollout.structure.objective, rollout.device
    h = scene.time_step
    weigh = {name: first_number(weight_of(scene.objective, name)) for name in counted_terms(scene.objective)}
    energy = f"metabolic_{scene.objective.metabolic_model}"
    mass = float(rows([body.mass for body in scene.character.bodies.values()]).sum(axis=1)[0])
    basal = first_number(basal_rate(scene.objective)) * mass
    w = kernels.ObjectiveWeights()
    weigh |= {name: -weigh[name] for name in kind.earned}
    w.torque = h * weigh.get("torque", 0.0)
    for part in ("muscle", "body", "instance"):
        values = [h * weigh.get("metabolic" if name == energy else name, 0.0) for name in getattr(kind, part)]
        setattr(w, part, wp.array(np.array(values, dtype=np.float64), dtype=wp.float64, device=device))
    w.basal = h * basal * weigh.get("metabolic", 0.0)
    w.energy = kind.muscle.index(energy) if energy in kind.muscle else -1
    w.transport, w.mass, w.basal_power, w.time_step = weigh.get("cost_of_transport", 0.0), mass, basal, h
    return w
