"""What a training leaves behind: a policy as plain arrays, and how it was learnt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core import hdf5
from warpmuscle.core.array_checks import check_numbers
from warpmuscle.core.array_types import Floats

Singles = NDArray[np.float32]
HUGE_WEIGHT = 1e6  # whose sums are numbers of single precision
WIDEST_LAYER, MOST_LAYERS = 4096, 16


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
    "reward": Column("", "of a decision, mean"),
    "policy_loss": Column("", "of proximal policy optimisation, mean of the update"),
    "value_loss": Column("", "of the critic, mean of the update"),
    "divergence": Column("nat", "from the policy before, mean of the update"),
    "clipped": Column("", "share of the likelihood ratios that were clipped"),
    "learning_rate": Column("", "at the end of the update"),
    "deviation": Column("", "of actions, mean"),
}


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

    def __repr__(self) -> str:
        sizes = [len(self.observation), *(len(layer.bias) for layer in self.layers)]
        return f"PolicyTable({'-'.join(map(str, sizes))})"


@dataclass(frozen=True, repr=False)
class Learned:
    """A policy, and how it was learnt."""

    policy: PolicyTable
    task: str  # what it learnt, JSON text of a `scene.learning.Task`
    curve: Mapping[str, Floats]  # (R,) each, by the names of `CURVE`
    options: Mapping[str, Any]  # of the training
    ended: str = ""  # why; empty while it goes on

    def __repr__(self) -> str:
        return f"Learned({self.policy!r}, {len(self.curve['iteration'])} iterations, {self.ended or 'not ended'})"


def load_learned(file: Any) -> Learned:
    """The policy of an open result file.

    Raises:
        KeyError, ValueError or TypeError: it is incomplete, or not as it should be.
    """
    group, attributes = file["policy"], file["training"].attrs
    layers = hdf5.member(group, "layers")
    table = PolicyTable(
        observation=hdf5.strings(hdf5.member(group, "observation")),
        action=hdf5.strings(hdf5.member(group, "action")),
        mean=hdf5.array(group, "mean"),
        deviation=hdf5.array(group, "deviation"),
        widest=float(hdf5.attribute(group, "widest")),
        layers=tuple(
            Layer(hdf5.array(inner, "weight"), hdf5.array(inner, "bias"))
            for inner in (hdf5.member(layers, str(number)) for number in range(len(layers)))
        ),
        noise=_load_noise(group),
    )
    task = hdf5.text(hdf5.member(group, "task"))
    curve = {name: hdf5.array(file["curve"], name) for name in CURVE}
    options = {name: _plain(attributes[name]) for name in attributes if name != "ended"}
    return Learned(table, task, curve, options, str(hdf5.attribute(file["training"], "ended")))


def _load_noise(group: Any) -> ClippedNoise | None:
    """The noise that a policy of an open file learnt with, where its actions are the mean over it."""
    if "noise" not in group:
        return None
    low, high = (float(hdf5.attribute(group, name)) for name in ("action_min", "action_max"))
    return ClippedNoise(hdf5.array(group, "noise"), low, high)


def _plain(value: Any) -> Any:
    """An attribute as a number, a text, or a tuple of numbers."""
    if isinstance(value, np.ndarray):
        return tuple(value.tolist())
    return value.item() if hasattr(value, "item") else value


def check_learned(learned: Learned) -> None:
    """Check a policy and its curve; raises ValueError with the place of what is wrong."""
    check_policy(learned.policy)
    if set(learned.curve) != set(CURVE):
        raise ValueError("curve has other columns than a learning curve")
    rows = np.shape(learned.curve["iteration"])[:1]
    for name in CURVE:
        check_numbers(f"curve/{name}", learned.curve[name], rows or (0,))


def check_policy(policy: PolicyTable) -> None:
    """Check a policy; raises ValueError with the place of what is wrong."""
    inputs = len(policy.observation)
    check_numbers("policy/mean", policy.mean, (inputs,), -HUGE_WEIGHT, HUGE_WEIGHT, kinds="f")
    check_numbers("policy/deviation", policy.deviation, (inputs,), 1e-6, HUGE_WEIGHT, kinds="f")
    if not 0.0 < policy.widest <= HUGE_WEIGHT:
        raise ValueError(f"policy has the attribute widest = {policy.widest:g}, and should have a positive number")
    if not 1 <= len(policy.layers) <= MOST_LAYERS:
        raise ValueError(f"policy/layers holds {len(policy.layers)} layers, and should hold 1 to {MOST_LAYERS}")
    for number, layer in enumerate(policy.layers):
        last = number == len(policy.layers) - 1
        outputs = len(policy.action) if last else np.size(layer.bias)
        if not 1 <= outputs <= WIDEST_LAYER:
            raise ValueError(f"policy/layers/{number} has {outputs} outputs, and should have 1 to {WIDEST_LAYER}")
        for name, array, shape in (("weight", layer.weight, (outputs, inputs)), ("bias", layer.bias, (outputs,))):
            place = f"policy/layers/{number}/{name}"
            check_numbers(place, array, shape, -HUGE_WEIGHT, HUGE_WEIGHT, kinds="f")
        inputs = outputs
    if policy.noise is not None:
        low, high = policy.noise.low, policy.noise.high
        check_numbers("policy/noise", policy.noise.deviation, (len(policy.action),), 1e-6, HUGE_WEIGHT, kinds="f")
        if not -HUGE_WEIGHT <= low < high <= HUGE_WEIGHT:
            raise ValueError(f"policy has action_min = {low:g} and action_max = {high:g}, and should have a range")
