"""The terms of the objective and the rewards of decisions, one declaration each, with its sign.

They know nothing of Warp, so that scenes need not wait for it. What a term of a muscle, body or whole instance adds in
a step is the function of its name in `term_functions.py`; what a decision is worth, that in `rewards.py`. Every term
may be a reward, too: `learning.rewards.custom` names it.
"""

from warpmuscle.kernels.objective.declaration import Declaration as Term

_TERMS = (
    # Bergmann 2017, section 6
    Term("torque", "N m s", "feedback torque, summed over joints and time", "batch"),
    Term("fall", "s", "time missed by falling or failing otherwise", "batch"),
    Term("applied_torque", "N m s", "torque that drives the joints, summed over joints and time", "body"),
    Term("effort_squared", "s", "activation squared, summed over muscles and time", "muscle"),
    Term("effort_cubed", "s", "activation cubed, summed over muscles and time", "muscle"),
    Term("mass_effort_squared", "kg s", "activation squared times muscle mass, summed over muscles and time", "muscle"),
    Term("mass_effort_cubed", "kg s", "activation cubed times muscle mass, summed over muscles and time", "muscle"),
    Term(
        "metabolic", "J", "metabolic energy of the muscles, and of the body at rest", "muscle",
        models=("wang", "umberger", "bhargava", "margaria"),
    ),
    Term(
        "cost_of_transport", "J/(kg m)", "metabolic energy over body mass and distance, counted as 1 m at least",
        "batch",
    ),
    Term("speed", "m^2/s", "squared error of the forward speed, over time", "instance"),
    Term(
        "stride_speed", "m^2/s", "squared error of the speed of each foot's last stride, summed, over time", "instance",
        follows_cycles=True,
    ),
    Term("heading", "rad^2 s", "squared error of the heading, over time", "instance"),
    Term("head", "rad^2/s", "squared angular velocity of the head, over time", "instance"),
    Term("joint_limits", "N m s", "torque of the joints' limits, summed over joints and time", "body"),
    Term("ground_force", "s", "vertical force on a foot beyond its bound, in body weights, over time", "instance"),
    Term("smoothness", "rad^2/s^3", "squared acceleration of the joints, summed and over time", "body"),
    Term(
        "tracking", "rad^2 s", "squared angles between the joints and the tracked gait, summed and over time", "body",
        follows_cycles=True,
    ),
    Term(
        "norms", "s", "squared angles, in half-widths, between legs and human ones, summed and over time", "body",
        follows_cycles=True,
    ),
    Term(
        "norm_force", "s", "squared vertical force, in half-widths, between feet and human ones, over time", "instance",
        follows_cycles=True,
    ),
    Term(
        "norm_moments", "s",
        "squared sagittal moments, in standard deviations, at most 16, between legs and people's, summed and over time",
        "body", follows_cycles=True,
    ),
    Term(
        "step_width", "m^2 s", "squared width of each foot's last step, less that of people's steps, summed, over time",
        "instance", follows_cycles=True,
    ),
    Term("passive_force", "N s", "force of stretched fibres, summed over muscles and time", "muscle"),
    Term(
        "fibre_range", "s", "squared l_opt by which fibres are beyond 0.5 to 1.5, summed over muscles and time",
        "muscle",
    ),
    Term("rise", "m", "how far the centre of mass came above where it started", "instance", sign="earned"),
)  # fmt: skip

# In the order in which they are logged; each counts for the time of the decision, but for those in `PER_DECISION`.
_REWARDS = (
    Term("speed", "1/s", "exp(-((v - wanted)/speed_width)^2) of the speed along the wanted heading", sign="earned",
         weight=10.0),
    Term("progress", "1/s", "share of the wanted speed along the wanted heading, 0 to 1; 1 where none is wanted",
         sign="earned"),
    Term("alive", "1/s", "1", sign="earned", weight=5.0),
    Term("upright", "1/s", "the vertical part of the trunk's long axis", sign="earned"),
    Term("pose", "1/s", "exp(-mean squared error/pose_width^2) of wanted coordinates", sign="earned", weight=10.0),
    Term("imitation", "1/s", "weighted mean over joints of exp(-(angle/width)^2)", sign="earned", weight=20.0),
    Term("force", "1/s", "mean of exp(-((F - norm)/force_width)^2) over feet, F in body weights", sign="earned"),
    Term("contact", "1/s", "share of the feet that carry, or do not, as people's do at this part of the cycle",
         sign="earned"),
    Term("effort", "1/s", "mean of squared excitations, or of squared torques or activations", sign="cost", weight=3.0),
    Term("action", "1/s", "mean squared action, at most 4", sign="cost", weight=1.0),
    Term("action_rate", "1/s", "mean squared change of the action", sign="cost"),
    Term("overload", "1/s", "vertical force on each foot beyond force_limit, body weights", sign="cost"),
    Term("heading", "1/s", "1 - cos of the heading's error", sign="cost", weight=3.0),
    Term("side", "1/(m s)", "distance to the side of the wanted way, m, at most 1", sign="cost", weight=3.0),
    Term("objective", "1", "what the decision adds to the scene's weighted objective", sign="cost"),
    Term("failure", "1", "1 where an episode ends by failing", sign="cost"),
)  # fmt: skip


def scoped(term: Term) -> Term:
    """A term that says what it is of; TypeError if it does not, since nothing would sum it up."""
    if not term.scope:
        raise TypeError(f"term {term.name!r} in objective_terms.py has no scope: give unit, description and scope")
    return term


def signed(reward: Term) -> Term:
    """A reward that says whether it is earned; TypeError if it does not, since nothing else tells it from a cost."""
    if not reward.sign:
        raise TypeError(f'reward {reward.name!r} in objective_terms.py has no sign: add sign="earned" or sign="cost"')
    return reward


PER_DECISION = ("objective", "failure")
SIZES = ("speed_width", "pose_width", "imitation_width", "force_width", "force_limit")  # beside the weights of rewards
TERMS = {term.name: scoped(term) for term in _TERMS}
REWARDS = {term.name: signed(term) for term in _REWARDS}
