"""What is judged: a scene with its own controller, or one that a policy moves, in batches under the same conditions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats, Integers
from warpmuscle.core.status import Status
from warpmuscle.model.bodies import ground_normal
from warpmuscle.results.learned import Learned
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.controller import Command
from warpmuscle.scene.impairments.impaired import in_words
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.devices import find_devices
from warpmuscle.simulation.multi_device import make_rollout
from warpmuscle.simulation.perturbations import Perturbations, with_bodies

if TYPE_CHECKING:
    from warpmuscle.learning.imitation import Gait

RATE = 200.0  # frames/s, for what happens at a touch-down
WALKING_SPEED = 1.25  # m/s, that a policy of several speeds is told unless asked otherwise


@dataclass(frozen=True)
class Walks:
    """How n walks went.

    Attributes:
        status: (n,) see `Status`. end_time: (n,) s. recordings: of all of them, if they were to be recorded.
    """

    status: Integers
    end_time: Floats
    recordings: list[Recording]

    @property
    def upright(self) -> NDArray[np.bool_]:
        """(n,) of bool, which of them lasted the whole time."""
        return np.asarray(self.status == Status.COMPLETED)


@dataclass(frozen=True)
class Nerves:
    """How nerves hinder a walker.

    Attributes:
        delay: s, later than it is anyway, that a policy hears of its body, or that muscles hear of their controller.
        noise: standard deviation of what is added to all that a policy observes, in the units of each observation.
    """

    delay: float = 0.0
    noise: float = 0.0


class Walker(ABC):
    """Something that walks under conditions that differ between instances of a batch.

    Attributes:
        commands: what it can be told at all, and what it is told unless asked otherwise.
        senses: whether it observes its body, so that noise can be in what it observes.
    """

    commands: Mapping[str, Command]
    senses = False
    _scene: Scene

    @property
    def muscles(self) -> list[str]:
        """Names of all muscles of its scene, in order."""
        return list(self._scene.character.muscles)

    @property
    def impaired(self) -> tuple[str, ...]:
        """What impairs these muscles, in words."""
        return tuple(in_words(self._scene))

    def on_ground(self, friction: float) -> Self:
        """The same walker on ground of this coefficient of friction; bodies that are more slippery stay so."""
        other = copy(self)
        ground = msgspec.structs.replace(self._scene.ground, friction=friction)
        other._scene = msgspec.structs.replace(self._scene, ground=ground)
        return other

    def with_nerves(self, nerves: Nerves) -> Self:
        """The same walker, hindered so; delays of muscles that are free, or follow others, stay as they are."""
        other = copy(self)
        if nerves.delay and self._scene.character.muscles:
            muscles = {
                name: msgspec.structs.replace(muscle, delay=muscle.delay + nerves.delay)
                if isinstance(muscle.delay, int | float)
                else muscle
                for name, muscle in self._scene.character.muscles.items()
            }
            character = msgspec.structs.replace(self._scene.character, muscles=muscles)
            other._scene = msgspec.structs.replace(self._scene, character=character)
        return other

    @abstractmethod
    def scene(self, commands: Mapping[str, float] | None = None) -> Scene:
        """The scene without free parameters, as it is under some commands."""

    def walk(
        self,
        duration: float,
        disturbances: Perturbations,
        commands: Mapping[str, Floats] | None = None,
        *,
        record: bool = False,
    ) -> Walks:
        """Walk once for each of n disturbances, all from the scene's own initial state.

        Args:
            duration: s. commands: (n,) by name, within the ranges of its `commands`. record: keep the motions.
        """
        lasting = msgspec.structs.replace(self._scene, duration=duration)
        return self._walked(lasting, disturbances, commands or {}, range(len(disturbances)) if record else ())

    @abstractmethod
    def _walked(
        self, scene: Scene, disturbances: Perturbations, commands: Mapping[str, Floats], recorded: Sequence[int]
    ) -> Walks:
        """Walk in the scene for as long as that lasts, and keep the motions of these instances."""


class SceneWalker(Walker):
    """A scene that its own controller moves, its free parameters at their start values."""

    def __init__(self, scene: Scene, device: str | None = None, threads: int | None = None) -> None:
        """Prepare; device and threads as of `make_rollout`."""
        self._scene, self._device, self._threads = scene, device, threads
        self.commands = scene.commands

    def scene(self, commands: Mapping[str, float] | None = None) -> Scene:
        return substitute(self._scene, start_values(self._scene), commands)

    def _walked(
        self, scene: Scene, disturbances: Perturbations, commands: Mapping[str, Floats], recorded: Sequence[int]
    ) -> Walks:
        n = len(disturbances)
        batch = make_rollout(scene, n, self._device, record=recorded, record_rate=RATE, threads=self._threads)
        if commands:
            batch.set_commands(commands)
        if disturbances.any:
            batch.disturb(disturbances)
        batch.run()
        return Walks(batch.status(), batch.end_time(), [batch.recording(i) for i in recorded])


class PolicyWalker(Walker):
    """A scene that a learnt policy moves, without noise; what its task draws is left out.

    What plays policies takes a while to import, which those who judge a scene need not wait for.
    """

    senses = True

    def __init__(
        self,
        learned: Learned,
        scene: Scene,
        device: str | None = None,
        threads: int | None = None,
        defaults: Mapping[str, float] | None = None,
    ) -> None:
        """Prepare.

        Args:
            learned: of a result file. scene: that the policy was learnt in. device: the first one of several counts.
            defaults: commands unless others are given, by name; by default 1.25 m/s, where it has learnt that, and
                the middle of everything else.

        Raises:
            ResultError: the file's task is damaged.
        """
        from warpmuscle.learning.player import commands_of, task_of, undisturbed

        self._learned, self._threads, self._device = learned, threads, device
        self._gait: Gait | None = None
        task = undisturbed(task_of(learned))
        self._task = msgspec.structs.replace(task, command_time=0.0, episode_time=None)
        self._scene = msgspec.structs.replace(scene, learning=None)
        learnt = commands_of(self._task)
        self._defaults = {name: one.asked for name, one in learnt.items()}
        if learnt["speed"].min <= WALKING_SPEED <= learnt["speed"].max:
            self._defaults["speed"] = WALKING_SPEED
        self._defaults |= dict(defaults or {})
        known = {
            name: msgspec.structs.replace(one, value=self._defaults[name])
            for name, one in learnt.items()
            if one.min < one.max
        }
        self._own = {name: one for name, one in scene.commands.items() if name not in learnt}
        self.commands = known | self._own

    def with_nerves(self, nerves: Nerves) -> Self:
        from warpmuscle.learning.senses import KNOWN, groups_of

        other, observed = copy(self), self._learned.policy.observation
        groups = {
            name: msgspec.structs.replace(
                sense, delay=sense.delay + nerves.delay, noise=float(np.hypot(sense.noise, nerves.noise))
            )
            if name not in KNOWN
            else sense
            for name, sense in groups_of(self._task).items()
            if any(one.startswith(f"{name}.") for one in observed)
        }
        other._task = msgspec.structs.replace(self._task, observations=groups)
        return other

    def scene(self, commands: Mapping[str, float] | None = None) -> Scene:
        own = {name: value for name, value in (commands or {}).items() if name in self._own}
        return substitute(self._scene, start_values(self._scene), own)

    def _walked(
        self, scene: Scene, disturbances: Perturbations, commands: Mapping[str, Floats], recorded: Sequence[int]
    ) -> Walks:
        from warpmuscle.learning.player import Player

        n = len(disturbances)
        player = Player(
            self._learned.policy, scene, n, str(find_devices(self._device)[0]), self._task,
            record=recorded, record_rate=RATE, threads=self._threads, gait=self._gait,
        )  # fmt: skip
        self._gait = player.batch.gait  # which takes seconds to make
        status, end_time = player.walk(disturbances, {**self._defaults, **commands})
        return Walks(status, end_time, [player.batch.rollout.recording(i) for i in recorded])


def under(scene: Scene, disturbances: Perturbations, instance: int) -> Scene:
    """A scene without free parameters as an instance meets it: its slope, and its masses."""
    ground = scene.ground
    if slope := float(disturbances.slope[instance]):
        normal = tuple(ground_normal(ground, np.array([slope]))[0, 0].tolist())
        scene = msgspec.structs.replace(scene, ground=msgspec.structs.replace(ground, normal=normal))
    return with_bodies(scene, disturbances.part(slice(instance, instance + 1)))


def loaded(scene: Scene, disturbances: Perturbations, loads: Floats) -> Perturbations:
    """The same disturbances, and instances carry loads (n,), kg, at the centre of mass of the heaviest body."""
    masses = np.array([plain_number(body.mass) for body in scene.character.bodies.values()])
    factors = np.ones((len(loads), len(masses))) if disturbances.mass is None else disturbances.mass.copy()
    factors[:, masses.argmax()] += loads / masses.max()
    return replace(disturbances, mass=factors)
