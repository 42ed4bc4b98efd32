"""Episodes of many instances at once, on one device: a policy's observations, actions and rewards as Warp arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import msgspec
import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from warpmuscle.core.arguments import as_integer
from warpmuscle.core.arrays import arrays_of, rows
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.plain_text import number_of
from warpmuscle.formats import SceneLike, scene_of
from warpmuscle.kernels import structs
from warpmuscle.kernels.learning import episodes as kernels
from warpmuscle.kernels.learning import senses as sense_kernels
from warpmuscle.kernels.learning.senses import GREATEST
from warpmuscle.learning.actions import Actions
from warpmuscle.learning.custom_parts import CustomParts
from warpmuscle.learning.episode_rules import check_hardness, put_first_hardness, room_for, rules_of
from warpmuscle.learning.imitation import Gait, gait_kept
from warpmuscle.learning.imitation.choice import gait_of_controller, imitated_gait, phases_of
from warpmuscle.learning.imitation.people import by_norm_alone, people_starts
from warpmuscle.learning.poses import State, elsewhere
from warpmuscle.learning.rewards import Judge
from warpmuscle.learning.senses import About, Senses, head_of
from warpmuscle.learning.starts import ControllerGait, RowTable, first_states, make_room_to_feel, start_table
from warpmuscle.learning.symmetry import BodySymmetry, Images, observed_image
from warpmuscle.learning.tasks import checked_task, prepared
from warpmuscle.learning.tightening import TighteningLimits
from warpmuscle.learning.variants import Variants
from warpmuscle.model.joints import root_number
from warpmuscle.results.learned import KeptGait
from warpmuscle.scene import Scene
from warpmuscle.scene.learning import Task
from warpmuscle.scene.trusted_code import trust as allow
from warpmuscle.simulation.perturbations import Perturbations
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import Stepper, unrecorded

LARGEST_SEED = 2**31 - 1
FROM_THE_FIRST = 8  # states of a gait for one start from the scene's own initial state
PARTS = ("action", "simulation", "observation", "reward", "reset")  # of a decision, as they are timed


def no_mark(part: str) -> None:
    """What is done as a part of a decision ends: nothing."""


class EpisodeBatch:
    """Instances of one scene that a policy acts in, each in an episode of its own.

    A decision lasts for some steps of the simulation. Where an episode ends, the next one begins within the same
    decision, and `senses.observation` is already of it. All is done by kernels; nothing is asked of the device, and
    nothing allocated, once the first decision has been made. The same seed and actions give an instance the same
    observations, whatever the number of instances, on the same kind of device.

    Attributes:
        scene, task, rollout: what is learned where; the rollout's `state` is that of the instances.
        decision_steps: of the simulation. dt: s, that a decision lasts. longest: decisions of an episode.
        actions, senses, judge, custom_parts: with the arrays that they hold.
        episodes: where every instance is in its episode.
        final_observation: (instances, observations) of the episode that ended, where one did.
        limits: of failure, which a training may tighten, and the share of costs, which it may raise.
        command_names: of the columns of `episodes.command`. gait: that is imitated, if there is one.
        kept_gait: what a policy's file keeps of that, if the scene's controller makes it.
        images: of observations and actions in a mirror; None where the task is not said to be symmetric.
    """

    def __init__(
        self,
        scene: SceneLike,
        instances: int = 1,
        device: str | None = None,
        task: Task | None = None,
        seed: int = 0,
        *,
        record: Sequence[int] = (),
        record_rate: float = 100.0,
        threads: int | None = None,
        trust: bool = False,
        gait: Gait | None = None,
        kept_gait: KeptGait | None = None,
    ) -> None:
        """Prepare and begin all episodes; the first call compiles kernels.

        Args:
            scene, instances, device, record, record_rate, threads, trust: as of `Rollout`.
            task: what is learned; by default what the scene says, or a walk at 1.2 m/s.
            seed: of everything that is drawn.
            gait: that is imitated, of another batch of this scene and task, so that its controller need not make it.
            kept_gait: of a policy's file, which stands for what the scene's controller makes if it is of this scene.

        Raises:
            SceneError: the scene is inconsistent, or has not what the task wants.
            RolloutError: as of `Rollout`.
        """
        scene = scene_of(scene, trust=trust)
        self.task = checked_task(task) or scene.learning or Task()
        if trust:
            allow(msgspec.structs.replace(scene, learning=self.task))
        self.scene = prepared(scene, self.task)
        self.rollout = rollout = Rollout(
            self.scene, instances, device, record=record, record_rate=record_rate, threads=threads, trust=trust
        )
        self.device = rollout.device
        self.decision_steps = max(round(self.task.decision_time / self.scene.time_step), 1)
        self.dt = self.decision_steps * self.scene.time_step
        episode_time = self.scene.duration if self.task.episode_time is None else self.task.episode_time
        self.longest = max(round(episode_time / self.dt), 1)
        make_room_to_feel(rollout)
        self.actions = Actions(self.task, rollout)
        self._records = bool(record)
        self._variants = Variants(self.task.variation, rollout)
        self.limits = TighteningLimits(self.task.tightening, rollout, self._variants.model)
        self.command_names = self.task.command_names
        body = BodySymmetry(rollout) if self.task.symmetric else None
        imitates = gait is not None or self.task.imitation is not None
        self.custom_parts = CustomParts(self.task, rollout, self.actions, self.dt)
        about = About(
            rollout, self.actions.names, self.command_names, self._variants.names, imitates,
            tuple(self.custom_parts.goals), self.custom_parts.observation_widths,
        )  # fmt: skip
        self.senses = Senses(self.task, about, self.decision_steps, self._surroundings())
        self.senses.surround(self._variants.model)
        self.images = None if body is None else self._images(about, body)
        self.final_observation = wp.zeros_like(self.senses.observation)
        self._stepper = self._stepper_of(self._variants.model)
        known = None if gait is not None else gait_kept(kept_gait, rollout, self.task.imitation)
        # Kernels may take long, and are compiled side by side; what a task says wrongly has been said by now.
        with ThreadPoolExecutor(1, thread_name_prefix="kernel") as pool:
            loading = pool.submit(self._stepper.load)
            own = gait_of_controller(self.task, rollout, self.decision_steps, recorded=gait is None and known is None)
            loading.result()
        self.kept_gait = None if known is None else kept_gait
        if gait is None:
            gait, made = imitated_gait(self.task, rollout, own, body, known)
            self.kept_gait = made or self.kept_gait
        self.gait = gait
        self.judge = Judge(
            self.task, rollout, self.actions, gait, self._variants.model, self.dt, self.longest, self.custom_parts,
            self.limits.costs,
        )  # fmt: skip
        states, times = self._start_states(own)
        self._starts = start_table(self._stepper, states)
        self.episodes = room_for(instances, len(self.command_names), self.device)
        phases = phases_of(self.task, rollout, gait, states, np.array(times))
        self._rules = rules_of(
            self.task, self.scene, gait, phases, self._variants.count, self.dt, self.longest, self.device
        )
        self.custom_parts.know(self.episodes, self.judge.gains.terminated, self.judge.gains.reached)
        self._start_row = self.episodes.start_row
        self._conditions = RowTable([], [], self.device)
        self.reset(seed)

    def reset(self, seed: int | None = None) -> None:
        """Begin all episodes anew.

        Args:
            seed: of all that is drawn from now on, as if nothing had been drawn before; None to draw on.

        Raises:
            RolloutError: no such seed.
        """
        if seed is not None:
            number = as_integer(seed, "seed", 0, LARGEST_SEED, error=RolloutError)
            self.episodes.seed.fill_(number)
            for array in (self.episodes.decision, self.episodes.number):
                array.zero_()
            put_first_hardness(self.episodes, self._rules)
        self.episodes.length.zero_()  # nothing has ended by lasting or failing
        self.episodes.mask.fill_(True)
        self._begin()
        self._observe(self.senses.observation)

    def begin(self, mask: ArrayLike) -> None:
        """Begin the next episode of some instances, after a `step` that was not to; the others go on.

        Args:
            mask: (instances,) whose.

        Raises:
            RolloutError: another number of instances.
        """
        chosen = np.ascontiguousarray(mask, dtype=bool)
        if chosen.shape != (len(self._stepper.state.step),):
            raise RolloutError(
                f"a mask of shape {chosen.shape} chooses none of {number_of(len(self._stepper.state.step), 'instance')}"
            )
        self.episodes.mask.assign(chosen)
        self._begin()
        self._observe(self.senses.observation)

    def begin_under(self, disturbances: Perturbations, commands: Mapping[str, ArrayLike]) -> None:
        """Begin all episodes anew from the scene's initial state, each disturbed and told what to do in its own way.

        So do all later ones. The task should draw nothing: no starts, noise, variants or pushes.

        Args:
            disturbances: of the instances.
            commands: one value each, or (instances,), by name: those of the task, m/s, rad/s or a coordinate, which
                stay as they were drawn if they are not named; and others, which are the scene's.

        Raises:
            RolloutError: another number of instances, the task draws variants, or the scene takes no such command.
        """
        if self._variants.count > 1:
            raise RolloutError("instances that are variants of a body cannot be disturbed besides")
        rollout, state, n = self.rollout, self._stepper.state, len(self._stepper.state.step)
        of_scene = {name: values for name, values in commands.items() if name not in self.command_names}
        if of_scene:
            rollout.set_commands(of_scene)
        rollout.disturb(disturbances)
        self._stepper = self._stepper_of(rollout.model)
        self.senses.surround(rollout.model)
        self._starts = start_table(self._stepper, first_states(rollout, self._stepper, n))
        drawn = self.episodes.command.numpy().copy()
        for column, name in enumerate(self.command_names):
            drawn[:, column] = commands.get(name, drawn[:, column])
        self.episodes.command.assign(drawn)
        targets = [state.push, state.push_steps, self.episodes.command]
        self._conditions = RowTable(targets, [wp.clone(target) for target in targets], self.device)
        self._start_row = wp.array(np.arange(n, dtype=np.int32), dtype=int, device=self.device)
        self.reset(int(self.episodes.seed.numpy()[0]))

    def change_parts(self, numeric: Scene, parts: Sequence[str]) -> None:
        """Go on with other numbers of these parts of the model, see `Rollout.change_parts`; instances are all alike."""
        self.rollout.change_parts(numeric, parts)
        self._stepper = self._stepper_of(self.rollout.model)
        self.senses.surround(self.rollout.model)

    def step(self, restart: bool = True, mark: Callable[[str], None] = no_mark) -> None:
        """Make a decision: act as `actions.requested` says; see `senses`, `judge.gains` and `final_observation`.

        Args:
            restart: let the next episode begin where one ends; without it, what follows a failure means
                nothing.
            mark: called with the name of a part as it ends, see `PARTS`.
        """
        state, episodes = self._stepper.state, self.episodes
        wp.launch(kernels.begin_decision, len(state.step), [self._rules, episodes, state], device=self.device)
        self.actions.take()
        mark("action")
        for moment in self.senses.moments:
            self._stepper.launch(moment.steps)
            mark("simulation")
            self.custom_parts.observe(self._stepper.model, state, episodes)
            self.senses.sample(moment, state, episodes)
            mark("observation")
        self.custom_parts.judge(self._stepper.model, state, episodes)
        self.judge.judge(self._rules, episodes, state, self.senses.around)
        mark("reward")
        self.senses.observe(episodes, self.final_observation)
        mark("observation")
        if restart:
            self._begin()
            mark("reset")
        self._observe(self.senses.observation)
        mark("observation")

    def state_arrays(self) -> Iterator[wp.array]:
        """All arrays that decisions change and that later ones depend on, in an order that stays."""
        yield from arrays_of(self.rollout.state)
        yield from (array for array in arrays_of(self._stepper.extensions) if array.ndim == 3)
        yield from arrays_of(self.episodes)
        for part in (self.actions, self.senses, self.judge, self.custom_parts):
            yield from part.changing

    def check_state(self) -> None:
        """Raise RolloutError for a state from outside whose numbers kernels cannot count with."""
        state, episodes, simbicon = self.rollout.state, self.episodes, self.rollout.numeric.simbicon
        counted = {
            "step": (state.step, LARGEST_SEED),
            "start": (episodes.start_row, self._rules.starts),
            "variant": (episodes.variant, self._rules.variants),
            "decision": (episodes.decision, LARGEST_SEED),
            "episode": (episodes.number, LARGEST_SEED),
            "length": (episodes.length, LARGEST_SEED),
        }
        check_hardness(episodes)
        if simbicon is not None:
            counted["machine state"] = state.simbicon.machine_state, len(simbicon.states)
            counted["stance"] = state.simbicon.stance, 2
        for name, (array, count) in counted.items():
            numbers = array.numpy()
            if numbers.size and not 0 <= int(numbers.min()) <= int(numbers.max()) < count:
                raise RolloutError(f"this state has a {name} that does not exist")

    def observe_again(self) -> None:
        """Show what is observed, after arrays of the state were changed from outside."""
        self.custom_parts.observe(self._stepper.model, self._stepper.state, self.episodes)
        self._observe(self.senses.observation)

    def _start_states(self, own: ControllerGait) -> tuple[list[State], list[float]]:
        """The states in which episodes may start, and at which time of the gait each of them is, s."""
        variation = self.task.variation
        states, times = first_states(self.rollout, self._stepper), [0.0]
        if self.gait is not None and by_norm_alone(self.scene, self.task.imitation) and variation.start_states:
            own = people_starts(self.gait, self.rollout, self._stepper, self.task)
        if own.states:
            again = len(own.states) // FROM_THE_FIRST
            states, times = own.states + states * again, own.times + times * again
        return elsewhere(self.rollout, self._stepper, variation, states, times)

    def _begin(self) -> None:
        """Begin an episode where the mask says so."""
        state, episodes, n = self._stepper.state, self.episodes, len(self._stepper.state.step)
        wp.launch(kernels.draw_starts, n, [self._rules, episodes], device=self.device)
        self.custom_parts.advance(self._stepper.model, state, episodes)
        if self.task.variation.graded:
            inputs = [self._rules, self.custom_parts.decision.difficulty, episodes]
            wp.launch(kernels.grade_variants, n, inputs, device=self.device)
        self._starts.restore(episodes.mask, self._start_row)
        self._variants.restore(episodes.mask, episodes.variant)
        self.rollout.terrain_starts.put(self._stepper.model, state, episodes.mask)
        self.custom_parts.begin(self._stepper.model, state, episodes)
        wp.launch(kernels.begin_episodes, n, [self._rules, episodes, state], device=self.device)
        self._conditions.restore(episodes.mask, self._start_row)
        self.judge.forget(episodes)
        self.custom_parts.observe(self._stepper.model, state, episodes)
        self.senses.sample_first(state, episodes)

    def _observe(self, into: wp.array) -> None:
        self.senses.observe(self.episodes, into)
        self.senses.observe_critic(self._stepper.state, self.episodes)

    def _stepper_of(self, model: structs.Model) -> Stepper:
        """Steps of instances that have this model and take the actions."""
        change = self.actions.change
        plain = self._records or self.device.is_cpu
        return self.rollout.stepper(
            change if plain else lambda config: change(unrecorded(config)), self.actions.fields, model
        )

    def _surroundings(self) -> sense_kernels.Surroundings:
        """What features need besides the state."""
        numeric = self.rollout.numeric
        mass = rows([body.mass for body in numeric.character.bodies.values()])[0].sum()
        around = sense_kernels.Surroundings()
        around.root = root_number(numeric.character)
        around.head = head_of(numeric, self.rollout.names)
        around.body_weight = float(mass * first_number(numeric.gravity)) or 1.0
        around.action = self.actions.action
        around.least_action, around.greatest_action = self.actions.range or (-GREATEST, GREATEST)
        around.varied = self._variants.described
        around.custom, around.goal = self.custom_parts.observed, self.custom_parts.decision.goal
        return around

    def _images(self, about: About, body: BodySymmetry) -> Images:
        """What a body's mirror image observes, and how it acts; raises SceneError for what has no image."""
        senses = self.senses
        action = self.actions.image(body)
        observed, critic = (observed_image(row, about, body, action) for row in (senses.numbers, senses.critic_numbers))
        return Images(observed, critic, action)
