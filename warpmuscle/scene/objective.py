"""What a simulation is for: limits of failure, the objective of a search, disturbed runs, and stages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

import msgspec

from warpmuscle.kernels.objective.objective_terms import TERMS
from warpmuscle.kernels.status import Status
from warpmuscle.scene.number import Number
from warpmuscle.scene.part import ABOVE_0, FROM_0, Part


class Failure(Part):
    """When an instance has failed; it then stops and costs more than any that has not.

    Every limit names the status of those that went beyond it; one of 0 switches its test off.
    The heading is compared with the one at the start, and where the controller controls it, with the nearest one on the
    shorter way from there to the desired heading. No gait is as fast as the bound on the centre of mass: sprinters
    come to some 12 m/s, and a body that falls from 20 m to 20 m/s. What the ground throws out of itself is faster.
    Bodies that collide are spheres, capsules, and boxes as the capsule inside them along their longest edge, as thick
    as their shortest one. Without `self_collision_pairs` all bodies with shapes are tested with each other but for
    those that a joint joins, and those that have a neighbour in common and overlap in the initial pose. They are tested
    every 0.002 s.
    """

    com_height: Annotated[Number, "1", Status.FELL, FROM_0] = (
        0.9  # of the centre of mass above the ground, over the initial one
    )
    heading: Annotated[Number, "rad", Status.TURNED, FROM_0] = 0.7853981633974483  # largest turn from its heading
    body_contact: Annotated[bool, Status.TOUCHED] = False  # any body but the feet and their children touches the ground
    leg_crossing: Annotated[Number, "m", Status.CROSSED, FROM_0] = 0.0  # how far a foot may cross beyond the other
    self_collision: Annotated[Number, "m", Status.COLLIDED, FROM_0] = 0.0  # how deep two bodies may overlap
    self_collision_pairs: list[tuple[str, str]] = []  # bodies that are tested; if empty, all that may not touch
    no_progress: Annotated[Number, "m/s", Status.STOPPED, FROM_0] = 0.0  # slowest mean speed over the ground
    no_progress_window: Annotated[float, "s", Status.STOPPED, ABOVE_0] = 2.0  # of the mean, one after another
    custom: Annotated[list[str], Status.FAILED] = []  # `module:function` each, conditions of the scene's own
    max_speed: Annotated[Number, "m/s or rad/s", Status.DIVERGED, ABOVE_0] = 1000.0  # of joints and root
    max_com_speed: Annotated[float, "m/s", Status.DIVERGED, ABOVE_0] = 20.0  # of the centre of mass


def never_failing(failure: Failure) -> Failure:
    """The same limits, of which only those of speeds hold."""
    return msgspec.structs.replace(
        failure, com_height=0.0, heading=0.0, body_contact=False, leg_crossing=0.0, self_collision=0.0, no_progress=0.0,
        custom=[],
    )  # fmt: skip


if TYPE_CHECKING:

    class _Weights(Part):
        """One number a term."""

        def __init__(self, **fields: Any) -> None: ...
        def __getattr__(self, term: str) -> Number: ...

else:
    _Weights = msgspec.defstruct(
        "_Weights", [(t.name, Annotated[Number, "1", FROM_0], 0.0) for t in TERMS.values()], bases=(Part,)
    )


class Objective(_Weights):
    """What a search minimises: the weighted sum of terms. It has a weight of the name of each term of `TERMS`, 0 if not
    given; where a scene weighs nothing at all, see `optimization.usual_objective`.

    Squared errors and efforts are summed over time. The cost of an instance is at most the failure cost; one that
    fails costs that, and as much of it again as it missed of the time.
    """

    gait: Literal["", "walk", "run"] = ""  # whose norms judge it; if empty, a gait with flight is a run
    target_speed: Annotated[Number, "m/s"] = 1.0  # forward
    ground_force_bound: Annotated[Number, "1", FROM_0] = 1.5  # body weights, vertical, on each foot
    head_body: str = "head"
    metabolic_model: Literal["wang", "umberger", "bhargava", "margaria"] = "wang"  # sources stand in `accounting.py`
    metabolic_work: Literal["net", "positive"] | None = None  # of fibres; by default as the model has it
    basal_rate: Annotated[Number | None, "W/kg", FROM_0] = None  # at rest; by default that of the model
    torque_by_joint: Annotated[dict[str, Number], "1", FROM_0] = {}  # weights of joints' feedback torques; by default 1
    failure_cost: Annotated[float, "1", ABOVE_0] = 1.0e6
    reported: list[str] = []  # terms that are summed up though they weigh nothing, by name or `module:name`
    custom: Annotated[dict[str, Number], "1"] = {}  # weights of `module:function`, see `CustomPart`


class Tracking(Part):
    """A gait whose joint angles the objective compares with, over the phase of a step in left and in right stance.

    A file is an HDF5 file with recorded motions, or a `.npz` file of NumPy: `phase` (K,) and `stance` (K,), or `cycle`
    (K,) over the gait cycle from one contact of the left foot to its next; `time` (K,) in s if wanted; and a joint's
    angles in rad or quaternions under its name (see `formats/npz.py`); or a `.mot`, `.sto` or `.csv` file with columns
    of coordinates, as exports and OpenSim's files have (see `formats/motion_table.py`).
    """

    scene: str = ""  # a scene that is run for it: a shipped one, or a TOML file
    file: str = ""  # or an HDF5, .npz, .mot, .sto or .csv file with a recorded motion
    replay: Annotated[int, FROM_0] = 0  # which one of an HDF5 file
    start: Annotated[float, "s", FROM_0] = 2.0  # from where on the motion counts, if it has times
    joints: list[str] = []  # those that count; all if empty
    weights: Annotated[dict[str, float], "1", FROM_0] = {}  # of squared angles, by joint; 1 where none is given


class RecordedNorms(Part):
    """Recorded gait cycles that the terms `norms`, `norm_force` and `norm_moments` compare with, in place of people's.

    Each leg is compared with its own means over all whole cycles of the motions, from contact to contact of its foot by
    the forces on it. Bands stay as wide as people's, so that weights mean the same. Moments count by the mass of the
    recorded body, forces by its weight.
    """

    file: str  # a result file with motions, such as one of `warpmuscle inverse`
    replays: Annotated[list[int], FROM_0] = []  # which motions of the file; all if empty
    start: Annotated[float, "s", FROM_0] = 0.0  # from where on they count


class Robustness(Part):
    """Several simulations a candidate, disturbed in the same way for all candidates; their costs become one."""

    runs: int = 1  # of which the first is not disturbed if there are several
    cost: Literal["mean", "worst"] = "mean"
    velocity_noise: Annotated[float, "m/s", FROM_0] = 0.0  # standard deviation of the root's initial velocity by axis
    push: Annotated[float, "N s", FROM_0] = 0.0  # horizontal impulse on the root at a random time, any direction
    push_duration: Annotated[float, "s", ABOVE_0] = 0.1
    slope: Annotated[float, "rad", FROM_0] = 0.0  # steepest slope of the ground, up or down
    mass: Annotated[float, "1", FROM_0] = 0.0  # largest part by which the mass of each body is more or less
    commands: dict[str, list[float]] = {}  # by command, of the runs in order; the list begins again where it ends
    seed: int = 1


class SearchStage(Part):
    """A part of a search, which begins at the best candidate of the part before it, the first one at the scene itself.

    Parameters that it does not free stay as they were in that candidate. What it does not say is as in the scene, or as
    asked for of the whole search (see `optimization.stages`).
    """

    name: str
    objective: Annotated[dict[str, float | str], "1"] = {}  # in place of these fields of the scene's objective
    failure: Annotated[dict[str, float | bool], "1"] = {}  # in place of these of its failure limits
    duration: Annotated[float | None, "s", ABOVE_0] = None  # of a simulation
    robustness: Annotated[dict[str, int | float | str], "1"] = {}  # in place of these of its robustness
    free: list[str] = []  # names of the parameters that may change, or patterns such as `controller.*`; all if empty
    candidates: Annotated[float | None, "1", ABOVE_0] = None  # at most; below 1: a part of those of the whole search
    strategy: str | None = None  # see `search.strategies`, like the next four
    population: Annotated[int | None, ABOVE_0] = None
    sigma: Annotated[float | None, "1", ABOVE_0] = None
    restarts: str | None = None
    searches: Annotated[int | None, ABOVE_0] = None
    until: Annotated[float | None, "s", ABOVE_0] = None  # of wall time that it may take
    target: Annotated[float | None, "1"] = None  # cost at which the next stage begins
