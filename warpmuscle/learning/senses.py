"""What a policy observes: groups of features, each with a delay and noise, through a ring buffer on the device."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warpmuscle.core.arrays import structs_to_device, to_device
from warpmuscle.core.errors import SceneError
from warpmuscle.kernels import structs
from warpmuscle.kernels.learning import senses as kernels
from warpmuscle.kernels.learning.episodes import Episodes
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.learning import Sense, Task
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.validation.checks import near
from warpmuscle.simulation.rollout import Rollout

SPEED_SCALE = 0.1  # of speeds of joints and fibres, so that they are about 1
TURNING = ("ball", "universal", "hinge", "fixed")  # joints that may carry a head
XYZ = ("x", "y", "z")


class Number(NamedTuple):
    """One observed number: its name, and what the device computes."""

    name: str
    kind: int
    place: int = 0
    scale: float = 1.0
    ago: int = 0  # whole decisions, beside the delay of its group


class About(NamedTuple):
    """What groups are made of: a batch, its actions, commands, and what varies between instances."""

    rollout: Rollout
    actions: tuple[str, ...]
    commands: tuple[str, ...]
    varied: tuple[str, ...]
    clock: bool = False  # whether a gait is imitated
    goals: tuple[tuple[str, int, int], ...] = ()  # name, first number and how many numbers of each
    custom: Mapping[str, int] = {}  # how many numbers each observation of one's own has, by `module:name`
    nerves: tuple[tuple[str, int, float], ...] = ()  # name, kind and greatest value of what hinders them in an episode


def _root(about: About) -> bool:
    return root_type(about.rollout.scene.character).forward is not None


def _trunk(about: About) -> list[Number]:
    if not _root(about):
        return []
    return [Number("height", kernels.HEIGHT), *(Number(f"up.{a}", kernels.UP, k) for k, a in enumerate(XYZ))]


def _trunk_speed(about: About) -> list[Number]:
    if not _root(about):
        return []
    moved = [Number(f"velocity.{a}", kernels.VELOCITY, k) for k, a in enumerate(XYZ)]
    turned = [Number(f"angular_velocity.{a}", kernels.ANGULAR_VELOCITY, k, 0.2) for k, a in enumerate(XYZ)]
    return moved + turned


def head_of(scene: Scene, names: Topology) -> int:
    """Number of the body that carries the head's organ of balance; 0 if there is none, or other joints carry it."""
    name = scene.objective.head_body
    head = body = names.bodies.index(name) if name in names.bodies else 0
    while body > 0:
        if scene.character.joints[names.joints[body - 1]].type not in TURNING:
            return 0
        body = names.parents[body]
    return head


def _head(about: About) -> list[Number]:
    rollout = about.rollout
    if not head_of(rollout.scene, rollout.names):
        return []
    up = [Number(f"up.{a}", kernels.HEAD_UP, k) for k, a in enumerate(XYZ)]
    turned = [Number(f"angular_velocity.{a}", kernels.HEAD_ANGULAR_VELOCITY, k, 0.2) for k, a in enumerate(XYZ)]
    return up + turned


def _coordinates(about: About) -> list[Number]:
    names = about.rollout.coordinate_names
    return [Number(n, kernels.COORDINATE, k) for k, n in enumerate(names) if not n.startswith("root.")]


def _speeds(about: About) -> list[Number]:
    names = about.rollout.speed_names
    return [Number(n, kernels.JOINT_SPEED, k, SPEED_SCALE) for k, n in enumerate(names) if not n.startswith("root.")]


def _foot_force(about: About) -> list[Number]:
    if about.rollout.scene.feet is None:
        return []
    return [
        Number(f"{side}.{axis}", kernels.FOOT_FORCE, 3 * s + k)
        for s, side in enumerate(("left", "right"))
        for k, axis in enumerate(XYZ)
    ]


def _of_muscles(kind: int, scale: float = 1.0) -> Callable[[About], list[Number]]:
    def numbers(about: About) -> list[Number]:
        return [Number(name, kind, k, scale) for k, name in enumerate(about.rollout.structure.actuation.muscles)]

    return numbers


def _command(about: About) -> list[Number]:
    commanded = [Number(name, kernels.COMMAND, k) for k, name in enumerate(about.commands)]
    if not _root(about):
        return commanded[2:]  # what goes nowhere has no speed and no course
    course = ("turn.sin", "turn.cos", "side")
    return commanded + [Number(name, kernels.COURSE, k) for k, name in enumerate(course)]


def _action(about: About) -> list[Number]:
    return [Number(name, kernels.ACTION, k) for k, name in enumerate(about.actions)]


def _phase(about: About) -> list[Number]:
    if about.rollout.scene.simbicon is None:
        return []
    return [Number("phase", kernels.PHASE), Number("stance", kernels.STANCE)]


def _clock(about: About) -> list[Number]:
    return [Number(name, kernels.CLOCK, k) for k, name in enumerate(("sin", "cos"))] if about.clock else []


def _goal(about: About) -> list[Number]:
    numbers: list[Number] = []
    for name, first, count in about.goals:
        if count == len(XYZ):
            numbers += [Number(f"{name}.{a}", kernels.GOAL_POINT, 3 * first + k) for k, a in enumerate(XYZ)]
        else:
            numbers.append(Number(name, kernels.GOAL, first))
    return numbers


def _ground_rows(about: About, rows: range) -> list[Number]:
    """Places of the ground from right to left and then forwards, by how many steps of the grid they are ahead."""
    if not _root(about) or about.rollout.scene.ground.terrain is None:
        return []
    across, before = kernels.GROUND_COLUMNS, kernels.GROUND_BEHIND - 1
    return [
        Number(f"{side}.{row}", kernels.GROUND, across * (row + before) + column, 10.0)
        for row in rows
        for column, side in enumerate(("right", "middle", "left"))
        if (row, side) != (0, "middle")  # below the root, from where heights are counted
    ]


def _ground(about: About) -> list[Number]:
    return _ground_rows(about, range(1, kernels.GROUND_AHEAD + 1))


def _ground_behind(about: About) -> list[Number]:
    return _ground_rows(about, range(1 - kernels.GROUND_BEHIND, 1))


def _footing(about: About) -> list[Number]:
    """Strips of ground on the ways of the right and the left foot, from behind the root forwards."""
    if not _root(about) or about.rollout.scene.ground.terrain is None:
        return []
    sides, behind = ("right", "left"), kernels.FOOTING_BEHIND
    return [
        Number(f"{side}.{row}", kernels.FOOTING, len(sides) * (row + behind) + column, 10.0)
        for row in range(-behind, kernels.FOOTING_AHEAD + 1)
        for column, side in enumerate(sides)
    ]


def _custom(about: About, entry: str) -> list[Number]:
    """Numbers of an observation of one's own."""
    first = 0
    for name, count in about.custom.items():
        if name == entry:
            axes = XYZ if count == len(XYZ) else ("value",)
            return [Number(axis, kernels.CUSTOM, first + k) for k, axis in enumerate(axes)]
        first += count
    return []


def numbers_of(group: str, about: About) -> list[Number]:
    """Numbers of a group, or of an observation of one's own."""
    return GROUPS[group](about) if group in GROUPS else _custom(about, group)


def with_history(numbers: Sequence[Number], history: int) -> list[Number]:
    """Numbers as they are observed, and as they were at each of so many decisions before."""
    before = [
        number._replace(name=f"{number.name}.{ago}_before", ago=ago)
        for ago in range(1, history + 1)
        for number in numbers
    ]
    return [*numbers, *before]


def _disturbance(about: About) -> list[Number]:
    pushed = [Number(f"push.{a}", kernels.PUSH_FORCE, k) for k, a in enumerate(XYZ)] if _root(about) else []
    varied = [Number(name, kernels.VARIED, k) for k, name in enumerate(about.varied)]
    return pushed + varied + [Number(name, kind, 0, 1.0 / most) for name, kind, most in about.nerves]


GROUPS: dict[str, Callable[[About], list[Number]]] = {
    "trunk": _trunk,  # height of the root above the ground, m, and the vertical in its axes
    "trunk_speed": _trunk_speed,  # m/s, as it faces, and 5 rad/s in its axes
    "head": _head,  # the vertical and 5 rad/s, in its axes; see `Objective.head_body`
    "coordinates": _coordinates,  # of joints, rad
    "speeds": _speeds,  # of joints, 10 rad/s
    "foot_force": _foot_force,  # on each foot, as the trunk faces, over body weight
    "activation": _of_muscles(kernels.ACTIVATION),
    "fibre_length": _of_muscles(kernels.FIBRE_LENGTH),  # over l_opt, less 1
    "fibre_velocity": _of_muscles(kernels.FIBRE_VELOCITY, SPEED_SCALE),  # 10 l_opt/s
    "tendon_force": _of_muscles(kernels.FIBRE_FORCE),  # over f_max, along the tendon
    "command": _command,  # what is wanted, and where the wanted way is
    "action": _action,  # of the last decision
    "phase": _phase,  # of the scene's controller
    "goal": _goal,  # points from the root and as it faces, m
    "ground": _ground,  # that is not flat: 0.1 m higher 0.2 to 1.2 m ahead, at three places across, than below the root
    "ground_behind": _ground_behind,  # the same beside it, and 0.2 and 0.4 m behind it
    "footing": _footing,  # 0.1 m that strips on the feet's ways, 10 cm each, are higher in the mean than below the root
    "clock": _clock,  # sine and cosine of the phase of the gait that is imitated
}
KNOWN = ("command", "clock", "action", "goal")  # what a policy observes by no nerve
USUAL = ("trunk", "trunk_speed", "coordinates", "speeds", "foot_force", "activation", "command")


def groups_of(task: Task) -> dict[str, Sense]:
    """The groups that a policy observes.

    Raises:
        SceneError: an unknown group.
    """
    for name in task.observations:
        if name not in GROUPS and ":" not in name:
            raise SceneError(
                f"there is no group {name!r}{near(name, GROUPS)}; known: {', '.join(GROUPS)}",
                key=f"learning.observations.{name}",
            )
    usual = USUAL if task.imitation is None else (*USUAL, "clock")
    usual = (*usual, "goal") if task.goals else usual
    return task.observations or {name: Sense() for name in usual}


class Moment(NamedTuple):
    """A time within a decision at which features are sampled."""

    steps: int  # of the simulation, since the moment before
    chosen: wp.array | None  # numbers of the features


class Senses:
    """Observations of a batch.

    Attributes:
        numbers, critic_numbers: that are observed. names, critic_names: of them.
        moments: of a decision, the last one at its end.
        observation, critic: (instances, numbers) on the device. around: what features are of besides the state.
    """

    def __init__(self, task: Task, about: About, decision_steps: int, around: kernels.Surroundings) -> None:
        """Make room; raises SceneError for an unknown group, or one that is empty in this scene."""
        rollout = about.rollout
        n, self._device, self.around = rollout.instances, rollout.device, around
        rows: list[Number] = []
        delays, late, noises, noisier, self.names = [], [], [], [], []
        longest = round(task.variation.delay / (decision_steps * rollout.scene.time_step))
        for group, sense in groups_of(task).items():
            numbers = with_history(numbers_of(group, about), sense.history)
            if not numbers and group in task.observations:
                raise SceneError("there is nothing of it in this scene", key=f"learning.observations.{group}")
            rows += numbers
            self.names += [f"{group}.{number.name}" for number in numbers]
            delay = round(sense.delay / rollout.scene.time_step)
            delays += [delay + number.ago * decision_steps for number in numbers]
            late += [0 if group in KNOWN else longest] * len(numbers)
            noises += [sense.noise] * len(numbers)
            noisier += [0.0 if group in KNOWN else task.variation.noise] * len(numbers)
        if not rows:
            raise SceneError("a policy observes nothing of this scene", key="learning.observations")
        whole, rest = np.divmod(np.array(delays), decision_steps)
        self._features = _table(rows, whole, late, noises, noisier, task.variation.growing, self._device)
        self._ring = wp.zeros((n, int((whole + late).max()) + 1, len(rows)), dtype=float, device=self._device)
        self.moments = _moments(rest, decision_steps, self._device)
        known = {group: GROUPS[group](about) for group in GROUPS if group != "action"}
        known |= {entry: _custom(about, entry) for entry in about.custom}
        nerves = (("delay", kernels.LATER, longest), ("noise", kernels.NOISIER, task.variation.noise))
        about = about._replace(nerves=tuple(one for one in nerves if one[2]))
        known["disturbance"] = _disturbance(about)
        critic = [number for numbers in known.values() for number in numbers]
        self.numbers, self.critic_numbers = rows, critic
        self.critic_names = tuple(f"{group}.{number.name}" for group, numbers in known.items() for number in numbers)
        none = [0] * len(critic)
        hindered = [longest] * len(critic), none, [task.variation.noise] * len(critic)
        self._critic_features = _table(critic, none, *hindered, task.variation.growing, self._device)
        self.observation = wp.zeros((n, len(rows)), dtype=float, device=self._device)
        self.critic = wp.zeros((n, len(critic)), dtype=float, device=self._device)

    @property
    def changing(self) -> list[wp.array]:
        """Arrays that decisions change and that later ones depend on."""
        return [self._ring]

    def sample(self, moment: Moment, state: structs.State, episodes: Episodes) -> None:
        """Keep how the features of a moment are now."""
        if moment.chosen is not None:
            inputs = [self._features, moment.chosen, state, episodes, self.around, self._ring]
            dim = (len(self.observation), len(moment.chosen))
            wp.launch(kernels.sample, dim, inputs, device=self._device)

    def sample_first(self, state: structs.State, episodes: Episodes) -> None:
        """Keep how the features are in episodes that begin, as if they had ever been so."""
        inputs = [self._features, state, episodes, self.around, self._ring]
        wp.launch(kernels.sample_first, self.observation.shape, inputs, device=self._device)

    def surround(self, model: structs.Model) -> None:
        """Let features be of instances that have this model."""
        around = self.around
        around.skeleton = model.skeleton
        around.normal, around.ground = model.contacts.normal, model.contacts.height
        around.terrain = model.contacts.terrain

    def observe(self, episodes: Episodes, into: wp.array) -> None:
        """What policies are told, (instances, numbers)."""
        wp.launch(
            kernels.observe, self.observation.shape, [self._features, self._ring, episodes, into], device=self._device
        )

    def observe_critic(self, state: structs.State, episodes: Episodes) -> None:
        """What a critic may know."""
        inputs = [self._critic_features, state, episodes, self.around, self.critic]
        wp.launch(kernels.observe_now, self.critic.shape, inputs, device=self._device)


def _table(
    numbers: Sequence[Number], delays: Any, late: Sequence[int], noises: Sequence[float], noisier: Sequence[float],
    growing: Sequence[str], device: Any,
) -> wp.array:  # fmt: skip
    columns = {
        "kind": [number.kind for number in numbers],
        "index": [number.place for number in numbers],
        "scale": [number.scale for number in numbers],
        "delay": delays,
        "late": late,
        "noise": noises,
        "noisier": noisier,
        "late_grows": [int("delay" in growing)] * len(numbers),
        "noisier_grows": [int("noise" in growing)] * len(numbers),
    }
    return structs_to_device(kernels.Feature, {name: np.array(values) for name, values in columns.items()}, device)


def _moments(rest: Any, decision_steps: int, device: Any) -> list[Moment]:
    """The moments of a decision, from how many steps before its end each feature is sampled."""
    moments, done = [], 0
    for before in sorted({*rest.tolist(), 0}, reverse=True):
        chosen = np.flatnonzero(rest == before)
        numbers = to_device(chosen, int, device) if len(chosen) else None
        moments.append(Moment(decision_steps - before - done, numbers))
        done = decision_steps - before
    return moments
