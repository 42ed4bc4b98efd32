"""What a training leaves behind: a policy as plain arrays, and how it was learnt."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.array_checks import check_numbers
from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import many_of, number_of

Singles = NDArray[np.float32]
HUGE_WEIGHT = 1e6  # whose sums are numbers of single precision
WIDEST_LAYER, MOST_LAYERS = 4096, 16
MOST_COORDINATES, MOST_FRAMES = 10_000, 1000  # of a kept gait
SHORTEST_UP = 0.1  # of a mean of verticals
SHORTEST_CYCLE, LONGEST_GAIT = 0.01, 1e5  # s


class Column(NamedTuple):
    """A column of a learning curve."""

    unit: str
    description: str


CURVE = {
    "iteration": Column("", "number of the iteration, from 1"),
    "decisions": Column("", "of all instances together, until then"),
    "wall_time": Column("s", "since the training began, without what went on between a kill and its resumption"),
    "episodes": Column("", "that ended in the iteration"),
    "completed": Column("", "share of the instances whose last episode lasted its whole time"),
    "upright": Column("s", "that the last episode of an instance lasted, mean"),
    "gain": Column("", "rewards of the last episode of an instance, mean"),
    "speed": Column("m/s", "along the wanted way, mean of these episodes"),
    "hardness": Column("", "share of what disturbs an episode where that grows, mean of the instances; else 1"),
    "push_hardness": Column("", "share of the greatest push, where pushes grow by themselves, mean; else 1"),
    "reward": Column("", "of a decision, mean"),
    "policy_loss": Column("", "of proximal policy optimisation, mean of the update"),
    "value_loss": Column("", "of the critic, mean of the update"),
    "divergence": Column("nat", "from the policy before, mean of the update"),
    "clipped": Column("", "share of the likelihood ratios that were clipped"),
    "learning_rate": Column("", "at the end of the update"),
    "deviation": Column("", "of actions, mean"),
}

LATER = ("hardness", "push_hardness")  # columns that files of earlier versions lack, where all of them would be 1


@dataclass(frozen=True, repr=False)
class Layer:
    """A linear layer."""

    weight: Singles  # (outputs, inputs)
    bias: Singles  # (outputs,)


@dataclass(frozen=True, repr=False)
class ClippedNoise:
    """Noise that a policy learnt with, of which its actions are the mean where they are clipped."""

    deviation: Singles  # (A,) standard deviation
    low: float  # below and above which an action does what the end does
    high: float


@dataclass(frozen=True, repr=False)
class KeptGait:
    """One cycle of the gait that a scene's own controller makes, which a policy has learnt to imitate.

    Angles are those of the controller, before a task puts those of a norm into them.
    """

    scene: str  # SHA-256 of all of the scene that the gait depends on
    coordinate: Floats  # (BINS, C) of all joints, means over the cycles
    up: Floats  # (BINS, 3) the vertical in the root
    landings: Floats  # (n,) s, when the left foot touched down
    right: float  # part of the cycle after which the right foot touches down
    cycle_time: float  # s


@dataclass(frozen=True, repr=False)
class PolicyTable:
    """A network from O observations to A actions: normalised, then linear layers with ELU between them.

    With noise, an action is the mean of clip(x, low, high) over x of a normal distribution around what it says.
    """

    observation: tuple[str, ...]  # O names
    action: tuple[str, ...]  # A names
    mean: Singles  # (O,), taken off an observation
    deviation: Singles  # (O,), by which what is left is divided
    widest: float  # at which that is cut off on either side
    layers: tuple[Layer, ...]
    noise: ClippedNoise | None = None
    scene: str = ""  # name of the one that it was learnt in; empty where that is not known
    gait: KeptGait | None = None  # that it has learnt to imitate, if the scene's own controller made it

    def __repr__(self) -> str:
        sizes = [len(self.observation), *(len(layer.bias) for layer in self.layers)]
        return f"PolicyTable({'-'.join(map(str, sizes))})"


@dataclass(frozen=True)
class Ancestor:
    """A policy that another one was learnt from."""

    file: str  # its name
    seed: int
    decisions: int  # that it took, of all instances together
    command: str  # that it was learnt by

    def __str__(self) -> str:
        how = f", {self.command}" if self.command else ""
        return f"{self.file}: seed {self.seed}, {many_of(self.decisions, 'decision')}{how}"


@dataclass(frozen=True, repr=False)
class Learned:
    """A policy, and how it was learnt."""

    policy: PolicyTable
    task: str  # what it learnt, JSON text of a `scene.learning.Task`
    curve: Mapping[str, Floats]  # (R,) each, by the names of `CURVE`
    options: Mapping[str, Any]  # of the training
    ended: str = ""  # why; empty while it goes on
    critic: PolicyTable | None = None  # network from what a critic may know to the rewards to come
    ancestors: tuple[Ancestor, ...] = ()  # the policy that it was learnt from, then the one that this was learnt from
    file: str = field(default="", compare=False)  # that it was read from

    @property
    def decisions(self) -> int:
        """That it took to learn it, without those of its ancestors."""
        taken = self.curve["decisions"]
        return int(taken[-1]) if len(taken) else 0

    def __repr__(self) -> str:
        return (
            f"Learned({self.policy!r}, {number_of(len(self.curve['iteration']), 'iteration')}, "
            f"{self.ended or 'not ended'})"
        )


def load_learned(file: Any) -> Learned:
    """The policy of an open result file.

    Raises:
        KeyError, ValueError or TypeError: it is incomplete, or not as it should be.
    """
    training, learnt, columns = (hdf5.members(file, name) for name in ("training", "policy", "curve"))
    task = hdf5.text(hdf5.member(learnt, "task"))
    curve = {name: hdf5.array(columns, name) for name in CURVE if name not in LATER or name in columns}
    curve = {name: curve.get(name, np.ones_like(curve["iteration"])) for name in CURVE}
    options = {name: _plain(training.attrs[name]) for name in training.attrs if name != "ended"}
    return Learned(
        replace(_load_network(learnt), scene=_scene_name(file), gait=_load_gait(file)), task, curve, options,
        str(hdf5.attribute(training, "ended")),
        _load_network(hdf5.members(file, "critic")) if "critic" in file else None, _load_ancestors(training),
    )  # fmt: skip


def _scene_name(file: Any) -> str:
    """The name of the scene of an open file, as far as its text can be read."""
    try:
        return str(tomllib.loads(hdf5.text(file["scene"])).get("name", ""))
    except (KeyError, ValueError):
        return ""


def _load_network(group: Any) -> PolicyTable:
    """A network of an open file."""
    layers = hdf5.members(group, "layers")
    activation = hdf5.attribute(group, "activation")
    if not isinstance(activation, str) or activation != "elu":
        found = str(activation)[:40]
        raise ValueError(f"{group.name.strip('/')} has the activation {found!r}, and only 'elu' is known")
    return PolicyTable(
        observation=hdf5.strings(hdf5.member(group, "observation")),
        action=hdf5.strings(hdf5.member(group, "action")),
        mean=hdf5.array(group, "mean"),
        deviation=hdf5.array(group, "deviation"),
        widest=hdf5.number(group, "widest"),
        layers=tuple(
            Layer(hdf5.array(inner, "weight"), hdf5.array(inner, "bias"))
            for inner in (hdf5.member(layers, str(number)) for number in range(len(layers)))
        ),
        noise=_load_noise(group),
    )


def _load_gait(file: Any) -> KeptGait | None:
    """The gait that a policy of an open file imitates; files of earlier versions have none."""
    if "gait" not in file:
        return None
    group = hdf5.members(file, "gait")
    arrays = (hdf5.array(group, name) for name in ("coordinate", "up", "landings"))
    numbers = (hdf5.number(group, name) for name in ("right", "cycle_time"))
    return KeptGait(str(hdf5.attribute(group, "scene")), *arrays, *numbers)


def _load_ancestors(training: Any) -> tuple[Ancestor, ...]:
    """What the policy of an open file was learnt from."""
    if "ancestors" not in training:
        return ()
    group = hdf5.member(training, "ancestors")
    numbers = [np.atleast_1d(hdf5.array(group, name)).tolist() for name in ("seed", "decisions")]
    texts = [hdf5.strings(hdf5.member(group, name)) for name in ("file", "command")]
    if len({len(column) for column in (*numbers, *texts)}) > 1:
        raise ValueError("training/ancestors has columns of different lengths")
    return tuple(
        Ancestor(file, int(seed), int(decisions), command)
        for (file, command), seed, decisions in zip(zip(*texts, strict=True), *numbers, strict=True)
    )


def _load_noise(group: Any) -> ClippedNoise | None:
    """The noise that a policy of an open file learnt with, where its actions are the mean over it."""
    if "noise" not in group:
        return None
    low, high = (hdf5.number(group, name) for name in ("action_min", "action_max"))
    return ClippedNoise(hdf5.array(group, "noise"), low, high)


def _plain(value: Any) -> Any:
    """An attribute as a number, a text, or a tuple of numbers."""
    if isinstance(value, np.ndarray):
        return tuple(value.tolist())
    return value.item() if hasattr(value, "item") else value


def check_learned(learned: Learned) -> None:
    """Check a policy and its curve; raises ValueError with the place of what is wrong."""
    check_policy(learned.policy)
    if learned.critic is not None:
        check_policy(learned.critic, "critic")
        if len(learned.critic.action) != 1:
            raise ValueError(f"critic gives {number_of(len(learned.critic.action), 'number')}, and should give 1")
    if learned.policy.gait is not None:
        check_gait(learned.policy.gait)
    if set(learned.curve) != set(CURVE):
        raise ValueError("curve has other columns than a learning curve")
    rows = np.shape(learned.curve["iteration"])[:1]
    for name in CURVE:
        check_numbers(f"curve/{name}", learned.curve[name], rows or (0,))


def check_gait(gait: KeptGait) -> None:
    """Check a kept gait; raises ValueError with the place of what is wrong."""
    if not re.fullmatch("[0-9a-f]{64}", gait.scene):
        raise ValueError("gait has the attribute scene, which is no SHA-256")
    for name, array in (("coordinate", gait.coordinate), ("up", gait.up)):
        columns = 3 if name == "up" else MOST_COORDINATES
        if np.ndim(array) != 2 or not 0 < np.shape(array)[1] <= columns or not 0 < len(array) <= MOST_FRAMES:
            raise ValueError(f"gait/{name} has shape {np.shape(array)}, not frames and coordinates")
    frames = len(gait.coordinate)
    check_numbers("gait/coordinate", gait.coordinate, np.shape(gait.coordinate), -HUGE_WEIGHT, HUGE_WEIGHT, kinds="f")
    check_numbers("gait/up", gait.up, (frames, 3), -1.001, 1.001, kinds="f")
    if (np.linalg.norm(gait.up, axis=1) < SHORTEST_UP).any():
        raise ValueError("gait/up holds vectors that point nowhere")
    landings = np.size(gait.landings)
    if not 2 <= landings <= MOST_FRAMES:
        raise ValueError(f"gait/landings holds {number_of(landings, 'time')}, and should hold 2 to {MOST_FRAMES}")
    check_numbers("gait/landings", gait.landings, (landings,), 0.0, LONGEST_GAIT, kinds="f")
    if not (np.diff(gait.landings) > SHORTEST_CYCLE).all():
        raise ValueError("gait/landings holds times that do not come one after the other")
    if not 0.0 <= gait.right < 1.0:
        raise ValueError(f"gait has the attribute right = {gait.right:g}, and should have a part of the cycle")
    if not SHORTEST_CYCLE < gait.cycle_time <= LONGEST_GAIT:
        raise ValueError(f"gait has the attribute cycle_time = {gait.cycle_time:g}, and should have that of a gait, s")


def check_policy(policy: PolicyTable, name: str = "policy") -> None:
    """Check a network of that name; raises ValueError with the place of what is wrong."""
    inputs = len(policy.observation)
    check_numbers(f"{name}/mean", policy.mean, (inputs,), -HUGE_WEIGHT, HUGE_WEIGHT, kinds="f")
    check_numbers(f"{name}/deviation", policy.deviation, (inputs,), 1e-6, HUGE_WEIGHT, kinds="f")
    if not 0.0 < policy.widest <= HUGE_WEIGHT:
        raise ValueError(f"{name} has the attribute widest = {policy.widest:g}, and should have a positive number")
    if not 1 <= len(policy.layers) <= MOST_LAYERS:
        raise ValueError(
            f"{name}/layers holds {number_of(len(policy.layers), 'layer')}, and should hold 1 to {MOST_LAYERS}"
        )
    for number, layer in enumerate(policy.layers):
        last = number == len(policy.layers) - 1
        outputs = len(policy.action) if last else np.size(layer.bias)
        if not 1 <= outputs <= WIDEST_LAYER:
            raise ValueError(
                f"{name}/layers/{number} has {number_of(outputs, 'output')}, and should have 1 to {WIDEST_LAYER}"
            )
        for part, array, shape in (("weight", layer.weight, (outputs, inputs)), ("bias", layer.bias, (outputs,))):
            place = f"{name}/layers/{number}/{part}"
            check_numbers(place, array, shape, -HUGE_WEIGHT, HUGE_WEIGHT, kinds="f")
        inputs = outputs
    if policy.noise is not None:
        low, high = policy.noise.low, policy.noise.high
        check_numbers(f"{name}/noise", policy.noise.deviation, (len(policy.action),), 1e-6, HUGE_WEIGHT, kinds="f")
        if not -HUGE_WEIGHT <= low < high <= HUGE_WEIGHT:
            raise ValueError(f"{name} has action_min = {low:g} and action_max = {high:g}, and should have a range")
