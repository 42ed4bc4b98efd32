"""What is learnt, with what one does with it first."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

from warpmuscle.core.arguments import answering
from warpmuscle.formats import SceneLike
from warpmuscle.session.results import ShownResult, shown
from warpmuscle.view.page import Page

if TYPE_CHECKING:
    from warpmuscle.learning.evaluation import Evaluation
    from warpmuscle.learning.progress import TrainingProgress


@dataclass(frozen=True)
class Training:
    """What a training has led to: a result with its policy and motions, and how the policy does."""

    result: ShownResult
    evaluation: Evaluation

    def show(self) -> Page:
        """Motions of the policy as a page, see `warpmuscle.show`."""
        return self.result.show()

    def save(self, path: str | PathLike[str]) -> None:
        """Write the policy to an HDF5 file, or its motions to a page if the name ends in `.html`; see `Result.save`."""
        self.result.save(path)


@answering(
    {
        **dict.fromkeys(
            ("timesteps", "total_timesteps", "steps", "epochs", "episodes", "n"),
            "iterations=100, until=300 (s) or target=0.95 ends it",
        ),
        **dict.fromkeys(("algorithm", "algo", "policy", "model"), "it is proximal policy optimisation"),
        **dict.fromkeys(
            ("instances", "num_envs", "n_envs", "lr", "learning_rate"), "options={'instances': 1024} has it"
        ),
        **dict.fromkeys(("reward", "rewards", "task"), "wm.load(scene, set={'learning.rewards.alive': 1}) has it"),
        "verbose": "on a terminal and in a notebook a line says how far it is",
        "callback": "progress=print is told of every iteration",
    }
)
def learn(
    scene: SceneLike,
    output: str | PathLike[str] | None = None,
    *,
    options: Mapping[str, Any] | None = None,
    source: str | PathLike[str] | None = None,
    seed: int = 1,
    device: str | None = None,
    iterations: int | None = None,
    until: float | None = None,
    target: float | None = None,
    threads: int | None = None,
    progress: Callable[[TrainingProgress], None] | None = None,
    trust: bool = False,
) -> Training:
    """Train a policy by proximal policy optimisation; needs `pip install "warpmuscle[learn]"`.

    Args:
        scene: what it moves, or its name or file. output: HDF5 file to write and to replace, beside which the state of
            the training lies.
        options: of the training by name, such as `{"instances": 1024}`. source: result file of a policy to begin with.
        seed: of all that is drawn. device, threads: as of `Rollout`.
        iterations, until, target: after how many, how many seconds, or at which share of instances that last their
            whole time the training ends; one of them is needed.
        progress: is told of every iteration. trust: as of `load`.

    Raises:
        Error: PyTorch is not installed, nothing ends the training, an option is impossible, or a file cannot be used.
    """
    from warpmuscle.learning.training import learn as train

    trained = train(
        scene, None if output is None else str(output), options=options, source=None if source is None else str(source),
        seed=seed, device=device, iterations=iterations, until=until, target=target, threads=threads,
        progress=progress, trust=trust,
    )  # fmt: skip
    return Training(shown(trained.result), trained.evaluation)
