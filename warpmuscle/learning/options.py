"""What a training is told beside its scene and its task."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from warpmuscle.core.errors import Error
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene.validation.checks import near

Count = Annotated[int, Meta(ge=1, le=1_000_000)]
Size = Annotated[int, Meta(ge=1, le=4096)]
Positive = Annotated[float, Meta(gt=0.0, le=1e6)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Weight = Annotated[float, Meta(ge=0.0, le=1e6)]


class PPOOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How proximal policy optimisation learns; the defaults suit bodies that walk on muscles."""

    instances: Count = 4096
    steps: Annotated[int, Meta(ge=2, le=10_000)] = 24  # decisions of each instance between two updates
    epochs: Annotated[int, Meta(ge=1, le=100)] = 4  # times that an update goes through all samples
    minibatches: Count = 4
    hidden: Annotated[tuple[Size, ...], Meta(min_length=1, max_length=8)] = (128, 128, 64)  # sizes of hidden layers
    deviation: Positive = 0.5  # of actions at first, the greatest of them
    min_deviation: Positive = 0.05
    end_deviation: Weight = 0.0  # that none exceeds after `end_decisions`, the bound falling till then; 0: no bound
    end_decisions: Annotated[int, Meta(ge=1, le=10**12)] = 50_000_000
    held_deviation: Weight = (
        0.0  # that none falls below until `held_decisions`, from which the bound falls; 0: not held
    )
    held_decisions: Annotated[int, Meta(ge=1, le=10**12)] = 50_000_000
    expected_action: bool = True  # play what actions with noise come to in the mean, clipped, not the mean of actions
    discount: Share = 0.99  # a decision; gamma
    trace: Share = 0.95  # lambda of generalised advantage estimation
    clip: Positive = 0.2  # of the ratio of likelihoods
    value_clip: Weight = 0.2  # of how far an update may move values; 0: as far as it will
    value_weight: Weight = 1.0
    entropy_weight: Weight = 0.0
    effort_weight: Weight = 0.0  # of the squared excitations that the policy means, each by its muscle's share in the
    # mass of all: muscles that do nothing for the reward relax, which noise of so many hides from rewards; beside
    # advantages in their standard deviations 0.1 is much
    learning_rate: Positive = 1e-3  # at first
    min_learning_rate: Positive = 5e-5
    max_learning_rate: Positive = 5e-3
    rate_factor: Annotated[float, Meta(ge=1.0, le=10.0)] = 1.5  # by which the learning rate adapts
    divergence: Weight = 0.02  # from one policy to the next, nat, that the learning rate aims at; 0 keeps it
    critic_rate: Weight = 0.0  # learning rate of the critic, which does not adapt; 0: that of the policy
    max_gradient: Positive = 1.0  # length of the gradient of either network
    mean_decisions: Annotated[float, Meta(ge=0.0, le=1e12)] = 0.0  # the mean of all weights, which forgets with so many
    # decisions, is kept as what was learnt: it lacks the noise of single updates; 0: the weights of the last update
    critic_iterations: Annotated[int, Meta(ge=0, le=1_000_000)] = 0  # at first, in which the policy stays as it is
    mirrored: Literal["action", "noise"] = "action"  # what a mirror image has of a sample: its action, which the policy
    # may hardly ever choose there, or the noise of its action beside what the policy does there
    mirror_weight: Weight = 0.0  # of how far the policy is from its own mirror image, nat
    reward_time: Positive = 0.1  # s; rewards a second times this are of the size of values that networks learn well

    def min_log_deviation(self, iterations: int) -> float:
        """Logarithm of the least deviation after so many iterations."""
        held = self.held_deviation and self._decisions(iterations) < self.held_decisions
        return math.log(max(self.min_deviation, self.held_deviation if held else 0.0))

    def max_log_deviation(self, iterations: int) -> float:
        """Logarithm of the greatest deviation after so many iterations, falling evenly; infinite without a bound."""
        if not self.end_deviation:
            return math.inf
        begin = self.held_decisions if self.held_deviation else 0
        part = min(max((self._decisions(iterations) - begin) / (self.end_decisions - begin), 0.0), 1.0)
        return (1.0 - part) * math.log(self.deviation) + part * math.log(self.end_deviation)

    def mean_share(self, iterations: int) -> float:
        """Share of the weights after so many iterations in the mean of weights till then; all alike at first."""
        samples = self.instances * self.steps
        return max(-math.expm1(-samples / self.mean_decisions), 1.0 / iterations) if self.mean_decisions else 1.0

    def _decisions(self, iterations: int) -> int:
        return iterations * self.instances * self.steps


def options_of(values: Mapping[str, Any]) -> PPOOptions:
    """Options with other values of some; raises Error for one that is unknown or impossible."""
    for name in values:
        if name not in PPOOptions.__struct_fields__:
            raise Error(f"there is no option {name!r} of a training{near(name, PPOOptions.__struct_fields__)}")
    try:
        options = msgspec.convert(dict(values), PPOOptions, strict=True)
    except msgspec.ValidationError as error:
        raise Error(f"options of the training: {str(error).replace('`$.', '`')}") from None
    if options.instances * options.steps < options.minibatches:
        raise Error(f"{number_of(options.instances, 'instance')} and {number_of(options.steps, 'step')} are too "
        f"few for {options.minibatches} "
                    "minibatches")  # fmt: skip
    if not options.min_learning_rate <= options.learning_rate <= options.max_learning_rate:
        raise Error("learning_rate must lie between min_learning_rate and max_learning_rate")
    if options.min_deviation > options.deviation:
        raise Error("deviation must not be less than min_deviation")
    if options.end_deviation and not options.min_deviation <= options.end_deviation <= options.deviation:
        raise Error("end_deviation must lie between min_deviation and deviation")
    if options.held_deviation and not options.min_deviation <= options.held_deviation <= options.deviation:
        raise Error("held_deviation must lie between min_deviation and deviation")
    if options.held_deviation and options.end_deviation and options.held_decisions >= options.end_decisions:
        raise Error("held_decisions must be less than end_decisions, by which the deviation has fallen")
    return options


def bounded(known: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Options that an earlier training ended with, within the bounds that hold now, and those given by name.

    That training has clipped them in single precision, in which a bound itself may be a little beyond the bound.

    Args:
        known: `learning_rate` and `deviation`, if there are any. values: given by name; they are not changed.
    """
    usual = msgspec.structs.asdict(PPOOptions()) | dict(values)
    bounds = {
        "learning_rate": (usual["min_learning_rate"], usual["max_learning_rate"]),
        "deviation": (max(usual["min_deviation"], usual["end_deviation"], usual["held_deviation"]), math.inf),
    }
    found = dict(known)
    for name, (low, high) in bounds.items():
        if name in found and isinstance(low, int | float) and isinstance(high, int | float):
            found[name] = min(max(found[name], low), max(low, high))
    return found | dict(values)


def parsed(texts: Sequence[str]) -> dict[str, Any]:
    """Values from KEY=VALUE, the value as in TOML; raises Error for what is none."""
    values: dict[str, Any] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        try:
            if not equals:
                raise ValueError
            values[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except RecursionError:
            raise Error(f"{key.strip()}: its value is nested too deeply") from None
        except ValueError:  # also what tomllib says of what is no TOML
            raise Error(f"{text!r}: write KEY=VALUE, such as epochs=5 or hidden=[64,64]") from None
    return values
