"""What a part of a simulation declares of itself, be it of this package or of a user's module.

Terms of the objective, rewards, observations, goals, starts, ends of episodes, curricula and recorded quantities are
all declared alike. This knows nothing of Warp, so that scenes need not wait for it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Scope = Literal["", "muscle", "body", "instance", "batch"]
Sign = Literal["cost", "earned"]
Stage = Literal["forces", "accelerations", "decision"]
STAGES = {  # of a step, or after one, at which a function may be called, and what it sees then
    "forces": "what joints, muscles and devices pull with is known, but not yet how bodies accelerate",
    "accelerations": "the bodies' accelerations are known; of the rest of the working set, places and turning",
    "decision": "a policy's decision is over: poses and velocities are known",
}


@dataclass(frozen=True)
class Declaration:
    """A named part: a Warp function, its parameters and memory, when it is called, and what its value is.

    A shipped part has a name, and its function is found by that. A part of one's own is named by the scene as
    `module:name`; a Warp function by itself is a part, too, with all else as it is by default.
    The function takes what is in brackets if it is declared: `parameters`, a `@wp.struct` of floats whose values
    stand in the scene's table `custom`, and `memory`, so many floats, which the function may write. Each instance has
    a memory of its own, and where the function is one of muscles or of joints, each muscle or joint. It is zero where
    an instance begins.
    """

    name: str = ""
    unit: str = ""  # of the value, in a term after it was summed over time
    description: str = ""  # one line, which reports show
    scope: Scope = ""  # what the function is of; batch: the host makes it from sums; of one's own, by its arguments
    sign: Sign | Literal[""] = ""  # cost or earned: whether less of it is wanted, or more; a cost if nothing is said
    stage: Stage = "forces"  # when the function is called
    follows_cycles: bool = False  # asks where feet are in their gait cycles
    models: tuple[str, ...] = ()  # it has a function for each of these, of which the scene chooses one
    weight: float = 0.0  # of a reward, where a scene says nothing
    function: Any = None  # the Warp function
    parameters: Any = None  # a `@wp.struct` of floats
    memory: int = 0  # floats that the function may keep
    defaults: Mapping[str, float] = field(default_factory=dict)  # of parameters that a scene need not give
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of parameters, lowest and highest value

    @property
    def sums(self) -> tuple[str, ...]:
        """Names of the functions of a shipped term, and of what a batch sums up for it."""
        return tuple(f"{self.name}_{model}" for model in self.models) or (self.name,)

    @property
    def factor(self) -> float:
        """What a value counts in a cost: 1, or -1 if it is earned."""
        return -1.0 if self.sign == "earned" else 1.0
