"""Parts of one's own of a task, for a batch: what they say of every instance, on the device."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import warp as wp

from warpmuscle.core.arrays import to_device
from warpmuscle.core.errors import SceneError, UserPartWarning
from warpmuscle.kernels import structs
from warpmuscle.kernels.learning import decision_parts as kernels
from warpmuscle.kernels.learning.decision import Decision
from warpmuscle.kernels.learning.episodes import Episodes
from warpmuscle.kernels.memory.scratch import capacity_of, work_floats
from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.learning.actions import Actions
from warpmuscle.model.part_checks import Found
from warpmuscle.model.parts import Placed
from warpmuscle.scene.learning import Task
from warpmuscle.simulation.fused_kernel import one_line_errors
from warpmuscle.simulation.rollout import Rollout

BLOCK = 256  # threads, that Warp launches on a GPU
KINDS = "rewards", "observations", "goals", "ends", "curriculum", "variation"


class Evaluation:
    """Values of some parts, (instances, numbers), evaluated by one kernel.

    Attributes:
        values: of the last evaluation. columns: first column of each part. widths: how many each has.
    """

    def __init__(
        self, parts: list[Placed], rollout: Rollout, first: int = 0, masked: bool = False,
        columns: list[int] | None = None, count: int | None = None,
    ) -> None:  # fmt: skip
        """Prepare; raises RolloutError for functions that are no Warp code.

        Args:
            first: columns before those of the parts. masked: evaluate only where an episode begins.
            columns: first one of each part; by default one behind the other. count: of all columns.
        """
        plugs = tuple(map(plug_of, parts))
        self.widths = [plug.width for plug in plugs]
        self.columns = [first + sum(self.widths[:k]) for k in range(len(plugs))] if columns is None else columns
        self._device, count = rollout.device, first + sum(self.widths) if count is None else count
        self.values = wp.zeros((rollout.instances, count), dtype=float, device=self._device)
        if plugs:
            with one_line_errors():
                self._kernel = kernels.evaluation_of(plugs, tuple(self.columns), masked)
                self._kernel.module.load(self._device, 1 if self._device.is_cpu else BLOCK)

    def evaluate(
        self, model: structs.Model, state: structs.State, episodes: Episodes, decision: Decision, room: wp.array
    ) -> None:
        """Evaluate all parts."""
        if self.columns:
            inputs = [model, episodes, decision, room, state, self.values]
            wp.launch(self._kernel, len(self.values), inputs, device=self._device)


def plug_of(part: Placed) -> kernels.DecisionPlug:
    """A part as a kernel has it."""
    return kernels.DecisionPlug(part.plug, part.part.base, part.part.result)


def unsigned(part: Found) -> str:
    """What is said of a reward that counts as a cost only because it says nothing."""
    name, function = part.entry.partition(":")[2], part.declaration.function
    if name == function.func.__name__:  # a Warp function by itself
        remedy = f'name a Declaration of it, Declaration(function={name}, stage="decision", sign="earned")'
    else:
        remedy = f'add sign="earned" to the Declaration {name!r}'
    return f'reward {part.entry!r} declares no sign and is taken off as a cost: {remedy}, or sign="cost"'


class CustomParts:
    """The parts of a batch.

    Attributes:
        decision: what they know of decisions. observed: values of observations. goals: name, first number and how many
            numbers of each goal. reward_names: of `rewards`, whose values are those of the last decision.
        ends: values of ends of episodes.
    """

    def __init__(self, task: Task, rollout: Rollout, actions: Actions, decision_time: float) -> None:
        """Make room; raises RolloutError for functions that are no Warp code."""
        n, self._device, self._task = rollout.instances, rollout.device, task
        self._time_step = rollout.scene.time_step
        found = rollout.structure.parts.task
        of = {kind: [one for key, one in found.items() if key.startswith(f"learning.{kind}")] for kind in KINDS}
        steps = [name for name in task.rewards.custom if f"learning.rewards.custom.{name}" not in found]
        self.reward_names = (*steps, *(one.part.entry for one in of["rewards"]))
        self._observations = Evaluation(of["observations"], rollout)
        self._rewards = Evaluation(of["rewards"], rollout, first=len(steps))
        self._ends = Evaluation(of["ends"], rollout)
        self._goals = self._goals_of(rollout)
        self._start = Evaluation(of["variation"], rollout, masked=True)
        self._curriculum = Evaluation(of["curriculum"], rollout, masked=True)
        self.observed, self.rewards, self.ends = self._observations.values, self._rewards.values, self._ends.values
        self.observation_widths = dict(
            zip((one.part.entry for one in of["observations"]), self._observations.widths, strict=True)
        )
        for one in of["rewards"]:
            if not one.part.declaration.sign:
                warnings.warn(unsigned(one.part), UserPartWarning, stacklevel=2)
        self.ends_fail = [one.part.declaration.sign != "earned" for one in of["ends"]]
        self._added = self._added_terms(steps, rollout)
        self.decision = Decision()
        self.decision.goal = self._goals.values
        self.decision.action, self.decision.previous_action = actions.action, actions.previous
        self.decision.difficulty = wp.zeros(n, dtype=float, device=self._device)
        self.decision.failed, self.decision.reached = (wp.zeros(n, dtype=bool, device=self._device) for _ in range(2))
        self.decision.time = decision_time
        self._room = wp.zeros((n if found else 0, self._work_floats(rollout)), dtype=float, device=self._device)
        self._any = bool(found or steps or task.goals)

    @property
    def changing(self) -> list[wp.array]:
        """Arrays that decisions change and that later ones depend on; none without parts of one's own."""
        if not self._any:
            return []
        changed = [self.decision.goal, self.decision.difficulty, self.decision.failed, self.decision.reached]
        return [array for array in (*changed, self._added.before) if array.size]

    def know(self, episodes: Episodes, failed: wp.array, reached: wp.array) -> None:
        """Let parts see what is told, and how episodes end."""
        self.decision.command, self.decision.length = episodes.command, episodes.length
        self.decision.failed, self.decision.reached = failed, reached

    def observe(self, model: structs.Model, state: structs.State, episodes: Episodes) -> None:
        """Have observations as they are now."""
        self._observations.evaluate(model, state, episodes, self.decision, self._room)

    def judge(self, model: structs.Model, state: structs.State, episodes: Episodes) -> None:
        """Have rewards of the decision, and which ends are met."""
        if self._added.before.shape[1]:
            inputs = [self._added, state, self._time_step, self.rewards]
            wp.launch(kernels.added_terms, self._added.before.shape, inputs, device=self._device)
        self._rewards.evaluate(model, state, episodes, self.decision, self._room)
        self._ends.evaluate(model, state, episodes, self.decision, self._room)

    def advance(self, model: structs.Model, state: structs.State, episodes: Episodes) -> None:
        """Make the difficulty of episodes that begin, while their instances stand where the last ones ended."""
        if self._curriculum.columns:
            self._curriculum.evaluate(model, state, episodes, self.decision, self._room)
            inputs = [episodes, self._curriculum.values, self.decision.difficulty]
            wp.launch(kernels.clamp_difficulty, len(episodes.mask), inputs, device=self._device)

    def begin(self, model: structs.Model, state: structs.State, episodes: Episodes) -> None:
        """Draw goals and starts of episodes that begin, whose states have been put to a start."""
        if len(self._low):
            inputs = [episodes, self._low, self._high, self._box_column, self.decision.goal]
            wp.launch(kernels.draw_in_boxes, len(episodes.mask), inputs, device=self._device)
        self._goals.evaluate(model, state, episodes, self.decision, self._room)
        self._start.evaluate(model, state, episodes, self.decision, self._room)
        if self._added.before.shape[1]:
            inputs = [episodes.mask, self._added.before]
            wp.launch(kernels.forget_terms, self._added.before.shape, inputs, device=self._device)

    def _goals_of(self, rollout: Rollout) -> Evaluation:
        """Goals in the order of the task, see `goals`; another kernel draws those that lie between bounds."""
        found = rollout.structure.parts.task
        self.goals: list[tuple[str, int, int]] = []
        drawn: list[Placed] = []
        columns: list[int] = []
        bounds: list[tuple[float, float, int]] = []
        width = 0
        for name, goal in self._task.goals.items():
            count = len(goal.low)
            if goal.draw:
                drawn.append(found[f"learning.goals.{name}.draw"])
                columns.append(width)
                count = plug_of(drawn[-1]).width
            bounds += [(*ends, width + k) for k, ends in enumerate(zip(goal.low, goal.high, strict=True))]
            self.goals.append((name, width, count))
            width += count
        low, high, column = np.array(bounds).reshape(-1, 3).T
        self._low, self._high = (to_device(ends, float, self._device) for ends in (low, high))
        self._box_column = to_device(column, int, self._device)
        return Evaluation(drawn, rollout, masked=True, columns=columns, count=width)

    def _added_terms(self, names: list[str], rollout: Rollout) -> kernels.AddedTerms:
        """The sums of the rewards that a step adds up."""
        kind, numbers = rollout.structure.objective, []
        for name in names:
            model = rollout.scene.objective.metabolic_model
            summed = f"{name}_{model}" if name in TERMS and TERMS[name].models else name
            table = {"muscle": kernels.OF_MUSCLES, "body": kernels.OF_BODIES, "instance": kernels.OF_INSTANCE}
            places = [
                (number, getattr(kind, part).index(summed))
                for part, number in table.items()
                if summed in getattr(kind, part)
            ]
            if not places:
                raise SceneError("muscles drive no joint of this scene", key=f"learning.rewards.custom.{name}")
            numbers.append(places[0])
        added = kernels.AddedTerms()
        added.part, added.index = (to_device([n[k] for n in numbers], int, self._device) for k in range(2))
        added.before = wp.zeros((rollout.instances, len(numbers)), dtype=wp.float64, device=self._device)
        return added

    def _work_floats(self, rollout: Rollout) -> int:
        """Numbers of a working set, see `kernels.stages`."""
        monomials = rollout.model.routes.monomial.shape[0]
        return int(work_floats(capacity_of(len(rollout.names.bodies)), True, monomials))


def signed_weights(task: Task, own: CustomParts, rollout: Rollout, decision_time: float) -> Any:
    """Weights of the rewards of one's own, in their order: negative of costs.

    What a step sums up has been summed over time; the others count for the time of the decision.
    """
    parts, kind = rollout.structure.parts, rollout.structure.objective
    found = {
        one.part.entry: one.part.declaration for key, one in parts.task.items() if key.startswith("learning.rewards")
    }
    weights = []
    for name in own.reward_names:
        earned = found[name].sign == "earned" if name in found else name in kind.earned
        weight = task.rewards.custom[name] * (decision_time if name in found else 1.0)
        weights.append(weight if earned else -weight)
    return np.array(weights)
