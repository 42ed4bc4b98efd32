"""What a policy learns in a scene: how it acts, what it senses, what it is told to do, and what it is rewarded for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from warpmuscle.kernels.objective.objective_terms import REWARDS
from warpmuscle.scene.part import ABOVE_0, FRACTION, FROM_0, Part

Interval = tuple[float, float]
MOVED = ("speed", "turning_rate")  # commands that every task has, before wanted coordinates


class Sense(Part):
    """How a group of observations reaches the policy."""

    delay: Annotated[float, "s", FROM_0] = 0.0
    noise: Annotated[float, "1", FROM_0] = 0.0  # standard deviation of what is added, in the units of the group
    history: int = 0  # of so many decisions before, what was observed then comes besides


if TYPE_CHECKING:

    class _Weights(Part):
        """One number a reward."""

        def __init__(self, **fields: Any) -> None: ...
        def __getattr__(self, reward: str) -> float: ...

else:
    _Weights = msgspec.defstruct(
        "_Weights",
        [(one.name, Annotated[float, one.unit, FROM_0], one.weight) for one in REWARDS.values()],
        bases=(Part,),
    )


class Rewards(_Weights):
    """Weights of what a decision earns, and of what it costs; each counts for the time that a decision takes.

    Earned are `speed`, `progress`, `alive`, `upright`, `pose`, `imitation`, `contact` and `force`, whose people's norm
    is that at this part of the cycle and this speed, smoothed as the force is, see `walking_force` and `running_force`
    of `scene.norms`. A foot that carries more than 3 % of the weight is in contact. All others are taken off. `speed`
    hardly tells a body that stands from one that walks much too slowly; `progress` does. `effort` is of excitations, of
    torques over their limit, or, where joints are aimed at targets, of activations; `overload` is summed over the feet,
    of the force at the end of the decision. `objective` weighs what the decision adds to the scene's weighted
    objective, and `failure` is taken off once where an episode ends by failing: these two do not count for time. With
    `speed_smoothing` v is a mean over steps, in each of which a body slows down and speeds up: a narrow `speed_width`
    then asks for the mean speed, and not for an even one.
    `custom` weighs terms of the objective, by name, and parts of one's own, `module:name`; what is summed up over time
    counts as the decision adds to it. Its sign is that which it declares, see `kernels/objective/declaration.py`.
    What `at_speed` names counts in full where that speed is wanted, and elsewhere exp(-(difference/width)^2) of it, as
    moments of people that are known at one speed.
    """

    speed_width: Annotated[float, "m/s", ABOVE_0] = 0.5
    speed_smoothing: Annotated[float, "s", FROM_0] = 0.0  # time constant of a low-pass of first order, of v in `speed`
    pose_width: Annotated[float, "rad", ABOVE_0] = 0.3
    imitation_width: Annotated[float, "rad", ABOVE_0] = 0.2
    force_width: Annotated[float, "1", ABOVE_0] = 0.25  # body weights
    force_smoothing: Annotated[float, "s", FROM_0] = 0.02  # time constant of a low-pass of first order
    force_limit: Annotated[float, "1", FROM_0] = 1.15  # body weights
    custom: Annotated[dict[str, float], "1"] = {}  # weights of terms, and of parts of one's own
    at_speed: Annotated[dict[str, Interval], "m/s"] = {}  # of some of these, a wanted speed and a width


class Goal(Part):
    """What is wanted in an episode: a point in space, or another number; drawn anew where an episode begins.

    Either it lies evenly between `low` and `high`, three numbers of a point, world, or one of something else; or a
    function of one's own draws it. The group of observations `goal` has points as they are seen from the root.
    """

    low: Annotated[list[float], "m or 1"] = []
    high: Annotated[list[float], "m or 1"] = []
    draw: str = ""  # `module:name` in place of both


class ImitatedRun(Part):
    """The run of people that a gait becomes where the body is to be fast."""

    above: Annotated[float, "m/s", ABOVE_0] = 2.0  # the wanted speed; people change to a run there (Diedrich, Warren
    # 1995, J. Exp. Psychol. Hum. Percept. Perform. 21:183)
    norm: str = "Fukuchi 2017"  # whose hips, knees and ankles bend
    cycle_time: Annotated[float, "s", ABOVE_0] = 0.73
    clock_speed: Annotated[float, "m/s", ABOVE_0] = 3.0  # at which a cycle takes that time
    cadence_power: Annotated[float, "1", FROM_0] = 0.2


class Imitation(Part):
    """A gait that is imitated: that of the scene's own controller, the angles of a norm, or a recorded one.

    In a scene without a controller, or with `norm_alone`, the norm is all of the gait: other joints stay as the scene
    starts, the root is upright, and `start_states` are poses over its cycle, see `learning.imitation.people`.

    With `file`, coordinates of joints are those of a recorded motion, whose names have to be the scene's, means over
    its whole gait cycles by the forces on the left foot; episodes start the clock where the recorded pose is nearest.

    A clock, which episodes start as the gait stands in their starts, runs from one contact of the left foot to the
    next; the policy may read it in the observations `clock`. It runs faster the faster the body is to walk, as
    (wanted speed/clock_speed)^cadence_power; people's step rate does so with 0.58 (Kuo 2001, J. Biomech. Eng. 123:264).
    """

    file: str = ""  # a result file with a motion, such as one of `warpmuscle inverse`
    replay: Annotated[int, FROM_0] = 0  # which motion of the file
    norm: str = ""  # whose hips, knees and ankles bend, see `scene.norms.IMITATED`; by default those of the gait
    norm_alone: bool = False  # the scene's own controller does something else, as to walk where a run is learnt
    cycle_time: Annotated[float | None, "s", ABOVE_0] = None  # by default that of the gait
    clock_speed: Annotated[float, "m/s", ABOVE_0] = 1.25  # at which a cycle takes that time
    cadence_power: Annotated[float, "1", FROM_0] = 0.0
    moving: bool = False  # the norm's angles change with the wanted speed, see `gait.likeness`, and of a run
    # `scene.people.fukuchi`
    run: ImitatedRun | None = (
        None  # at fast wanted speeds, with a clock of its own; by default it is the same gait at all
    )
    step_width: Annotated[float | None, "m", FROM_0] = None  # hips and ankles turn sideways so; by default the gait's
    pelvis: bool = False  # it turns sideways as people's in one centre (Pinzone 2014), below a trunk and over legs that
    # lean as in the gait
    pelvis_tilt: Annotated[float | None, "deg"] = None  # by which it leans forwards, below a trunk that leans as in the
    # gait; a norm's hips bend from there: 4 with "key points", 11 with the others put the foot flat on the ground in
    # mid-stance; by default as in the gait
    settle: Annotated[float, "s", FROM_0] = 2.0  # at the start, in which the gait does not count
    uneven: Annotated[float, "m", FROM_0] = 0.0  # where the way rises or falls by this within 10 cm, from 0.3 m behind
    # the root to 0.6 m ahead, the gait and its force count as met, for stairs ask for other steps; by half of it, they
    # count as on even ground, and in between in part; 0: they count everywhere
    weights: Annotated[dict[str, float], "1", FROM_0] = {}  # of joints, and of how upright the `root` is; by default 1


ANY_PHASE = (0.0, 1.0)
ANY_DIRECTION = (-180.0, 180.0)  # deg
GROWING = ("velocity_noise", "push", "delay", "noise")  # disturbances that can grow as episodes last


class Variation(Part):
    """How instances differ from each other; drawn anew for every episode.

    Masses, strengths, slopes and the scene's commands come from so many `variants`, and starts with other angles from
    so many `poses`, which are drawn once; an episode draws one of them.
    """

    velocity_noise: Annotated[float, "m/s", FROM_0] = 0.05  # standard deviation of the root's along each axis
    mass: Annotated[float, "1", FROM_0] = 0.0  # 0.1: of every body up to 10 % more or less, and its inertia with it
    strength: Annotated[float, "1", FROM_0] = 0.0  # 0.1: f_max of every muscle up to 10 % more or less
    side_strength: Annotated[float, "1", FROM_0] = 0.0  # the same for all muscles of the left, the right, and neither
    delay: Annotated[float, "s", FROM_0] = 0.0  # up to which all that is observed of the body comes later still in an
    # episode, in whole decisions; wanted commands, goals, the clock and the last action are known at once
    noise: Annotated[float, "1", FROM_0] = (
        0.0  # up to which standard deviation, drawn for each episode, all that is observed of
    )
    # the body has noise besides that of its group, in the units of each group
    slope: Annotated[float, "rad", FROM_0] = 0.0  # steepest slope of the ground, up or down
    commands: list[str] = []  # of the scene, such as a load, each drawn evenly over its range in half of the variants,
    # and as the scene has it in the others
    graded: str = ""  # one of these commands: an episode of difficulty d, 0 to 1, of the task's curriculum has one of
    # the share d of all variants that are nearest to the command's reference, and so at first that one alone
    graded_share: Annotated[float, "1"] = 1.0  # of all variants; an episode has one of the hardest so many of that
    # share d
    push: Annotated[float, "N s", FROM_0] = 0.0  # greatest horizontal impulse on the root
    push_least: Annotated[float, "1", FRACTION] = 0.0  # share of the greatest impulse that every push has: what all
    # bodies withstand teaches nothing
    push_growth: Annotated[float, "1", FRACTION] = 0.0  # 0.1: pushes grow by themselves, whatever `growth` says, and in
    # each of four directions along the wanted heading: ahead, to the left, back, and to the right. An instance begins
    # without them; after one that it withstands until the next one, or until the episode has lasted, those to that
    # side are a tenth of `push` harder; after one that it does not, they are less hard, by what `lasting` says
    pushed_share: Annotated[float, "1", FRACTION] = 1.0  # of episodes in which there are pushes; others are quiet,
    # as a walk is in which angles and forces are measured
    push_interval: Annotated[float, "s", ABOVE_0] = 4.0  # between two pushes, in the mean
    push_duration: Annotated[float, "s", ABOVE_0] = 0.1
    push_phase: Annotated[Interval, "1"] = ANY_PHASE  # of the imitated gait's cycle, from a contact of the left foot to
    # the next, between which pushes begin: one that is due waits for it; (0.9, 1.1) goes on in the next cycle
    push_direction: Annotated[Interval, "deg"] = ANY_DIRECTION  # from the wanted heading to the left, between which
    # pushes go; where the task is `symmetric`, half of them are mirror images: half a cycle later, to the other side
    aimed_share: Annotated[float, "1", FRACTION] = 1.0  # of pushes that have this phase and direction; the others come
    # at any time and go anywhere
    growth: Annotated[float, "1", FRACTION] = 0.0  # 0.1: an instance begins without what `growing` names; with each
    # episode that lasts its whole time it has a tenth more of them, up to all, and with each that fails less, by what
    # `lasting` says; 0: all from the start, as in trials of a policy
    growing: tuple[str, ...] = GROWING  # what does: `velocity_noise`, `push`, `delay` and `noise`
    lasting: Annotated[float, "1", FRACTION] = 0.5  # share of episodes that last where disturbances neither grow nor
    # shrink any more, and of pushes that are withstood where those have a growth of their own: 0.5: an episode that
    # fails takes off as much as one that lasts adds, 0.75: three times as much
    start_states: int = 0  # of a gait by the scene's own controller, that episodes start from, one in nine or so from
    # the initial state; 0: all do
    start_after: Annotated[float, "s", FROM_0] = 2.0  # of that gait, when the first of these states is taken
    joint_noise: Annotated[float, "rad or m", FROM_0] = 0.0  # standard deviation of what every coordinate of a joint is
    # off at the start; ball joints turn about any axis
    pose: Annotated[dict[str, Interval], "rad or m"] = {}  # where coordinates of joints start, drawn from intervals
    poses: int = 256  # starts that are drawn so
    start: str = ""  # `module:name` of one's own that changes each start, after all others
    start_file: str = ""  # whose states episodes start from, before joints are drawn: an .npz, see `learning.poses`, or
    # a result file, all of whose frames count; in place of the initial state and of states of the gait
    variants: int = 256  # of masses, strengths and slopes


class Tightening(Part):
    """Limits of `failure` that are wider, costs that are less, and rewards that are others, while learning begins.

    What is given here holds at first. It moves evenly to what the scene says over so many decisions of all instances
    together, from `held` to `decisions`. Trials of a policy have the scene's own limits and costs from the first
    decision of a training. So one training has several stages: a gait that is imitated roughly at first, then closely.
    """

    decisions: int = 50_000_000
    held: int = 0  # decisions in which it stays as it is at first
    com_height: Annotated[float | None, "1", FROM_0] = None
    heading: Annotated[float | None, "rad", FROM_0] = None
    leg_crossing: Annotated[float | None, "m", FROM_0] = None
    self_collision: Annotated[float | None, "m", FROM_0] = None
    no_progress: Annotated[float | None, "m/s", FROM_0] = None
    costs: Annotated[float | None, "1", FRACTION] = None  # share of all that rewards take off; at first a body that
    # falls soon would lose less than one that tries to stay up
    rewards: Annotated[dict[str, float], "1", FROM_0] = {}  # numbers of `rewards` by name: weights, widths, a limit
    custom: Annotated[dict[str, float], "1", FROM_0] = {}  # weights of `rewards.custom`, by name

    @property
    def first(self) -> dict[str, float]:
        """The limits that are given, by name."""
        others = ("decisions", "held", "costs", "rewards", "custom")
        given = {name: getattr(self, name) for name in self.__struct_fields__ if name not in others}
        return {name: limit for name, limit in given.items() if limit is not None}


class Task(Part):
    """What a policy learns: its actions, observations, commands, rewards, and how episodes differ.

    A policy decides every `decision_time`. What numbers it gives means:

    excitation: of each simulated muscle clip(offset + scale * action, 0, 1).
    synergies: of each synergy max(offset + scale * action, 0), times the weights of its muscles; their sum, at most 1,
    excites a muscle.
    joint_targets: for every speed of a joint its angle at the start + offset + scale * action, of ball joints along the
    rotation vector; PD with the gains of the scene's controller, or with `stiffness` and `damping`, asks muscles or
    motors for torques towards them, in every step of the simulation.
    torques: scale * action for every speed of a joint, N m, which muscles take as a wish.
    """

    decision_time: Annotated[float, "s", ABOVE_0] = 0.01
    episode_time: Annotated[float | None, "s"] = None  # by default the scene's duration
    actions: Literal["excitation", "synergies", "joint_targets", "torques"] = "excitation"
    action_offset: Annotated[float | None, "1"] = None  # by default 0.1 of excitations, else 0
    action_scale: Annotated[float | None, "1"] = None  # by default 0.4 of excitations, 0.5 rad, 100 N m
    synergies: Annotated[dict[str, dict[str, float]], "1"] = {}  # weights of muscles, by synergy
    stiffness: Annotated[float, "N m/rad", FROM_0] = 100.0
    damping: Annotated[float, "N m s/rad", FROM_0] = 10.0
    observations: dict[str, Sense] = {}  # by group, see `learning.senses.GROUPS`, or `module:name` of one's own; by
    # default the usual ones, at once
    goals: dict[str, Goal] = {}  # by names of one's own
    ends: list[str] = []  # `module:name` each: what ends an episode besides failures and its time
    curriculum: str = ""  # `module:name` of what makes the difficulty of the next episode, 0 to 1
    speed: Annotated[Interval, "m/s"] = (1.2, 1.2)  # that is wanted, drawn from this interval
    turning_rate: Annotated[Interval, "rad/s"] = (0.0, 0.0)  # of the wanted heading, positive to the left
    turning_share: Annotated[float, "1", FRACTION] = 1.0  # of what is drawn that turns at all; others go straight on
    pose: Annotated[dict[str, Interval], "rad or m"] = {}  # wanted coordinates, by name
    command_time: Annotated[float, "s", FROM_0] = 0.0  # after which others are drawn; 0: they last for the episode
    imitation: Imitation | None = None  # the gait that is rewarded
    symmetric: bool = False  # body and task are their own mirror images, so that one side learns from the other
    rewards: Rewards = msgspec.field(default_factory=Rewards)
    variation: Variation = msgspec.field(default_factory=Variation)
    tightening: Tightening | None = None  # of limits of failure, as learning goes on

    @property
    def command_names(self) -> tuple[str, ...]:
        """Of what it can be told: m/s, rad/s, then wanted coordinates."""
        return (*MOVED, *self.pose)
