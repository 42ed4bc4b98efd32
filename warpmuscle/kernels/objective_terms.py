"""The terms of the objective, one object each. They know nothing of Warp, so that scenes need not wait for it.

What a term of a muscle, body or whole instance adds in a step is the function of its name in `term_functions.py`.
"""

from typing import Literal, NamedTuple

Scope = Literal["muscle", "body", "whole", "batch"]


class Term(NamedTuple):
    """One term of the objective."""

    name: str  # the field of `scene.Objective` that weighs it
    unit: str
    description: str
    scope: Scope  # what its function is of; batch: the host makes it from other sums, see `model.objective.term_values`
    follows_cycles: bool = False  # asks where feet are in their gait cycles
    models: tuple[str, ...] = ()  # it has a function for each of these, of which the scene chooses one

    @property
    def sums(self) -> tuple[str, ...]:
        """Names of its functions, and of what a batch sums up for it."""
        return tuple(f"{self.name}_{model}" for model in self.models) or (self.name,)


_TERMS = (
    # Bergmann 2017, section 6
    Term("torque", "N m s", "feedback torque, summed over joints and time", "batch"),
    Term("fall", "s", "time missed by falling or failing otherwise", "batch"),
    Term("applied_torque", "N m s", "torque that drives the joints, summed over joints and time", "body"),
    Term("effort_squared", "s", "activation squared, summed over muscles and time", "muscle"),
    Term("effort_cubed", "s", "activation cubed, summed over muscles and time", "muscle"),
    Term(
        "metabolic", "J", "metabolic energy of the muscles, and of the body at rest", "muscle",
        models=("wang", "umberger", "bhargava"),
    ),
    Term(
        "cost_of_transport", "J/(kg m)", "metabolic energy over body mass and distance, counted as 1 m at least",
        "batch",
    ),
    Term("speed", "m^2/s", "squared error of the forward speed, over time", "whole"),
    Term("heading", "rad^2 s", "squared error of the heading, over time", "whole"),
    Term("head", "rad^2/s", "squared angular velocity of the head, over time", "whole"),
    Term("joint_limits", "N m s", "torque of the joints' limits, summed over joints and time", "body"),
    Term("ground_force", "s", "vertical force on a foot beyond its bound, in body weights, over time", "whole"),
    Term("smoothness", "rad^2/s^3", "squared acceleration of the joints, summed and over time", "body"),
    Term(
        "tracking", "rad^2 s", "squared angles between the joints and the tracked gait, summed and over time", "body",
        follows_cycles=True,
    ),
    Term(
        "norms", "s", "squared angles, in half-bands, between legs and human ones, summed and over time", "body",
        follows_cycles=True,
    ),
    Term(
        "norm_force", "s", "squared vertical force, in half-bands, between feet and human ones, over time", "whole",
        follows_cycles=True,
    ),
    Term(
        "step_width", "m^2 s", "squared width of each foot's last step, less that of people's steps, summed, over time",
        "whole", follows_cycles=True,
    ),
    Term("passive_force", "N s", "force of stretched fibres, summed over muscles and time", "muscle"),
)  # fmt: skip
TERMS = {term.name: term for term in _TERMS}
