"""The muscles of a scene: their paths, excitations and common model, and what drives the joints.

Units are SI and radians; see `scene.py`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, cast

from warpmuscle.kernels.curve.curve_sets import CurveSet
from warpmuscle.kernels.muscle.law_names import Law
from warpmuscle.scene.displacement import Displacement
from warpmuscle.scene.muscles.cables import CABLES
from warpmuscle.scene.muscles.curves import CurveShape
from warpmuscle.scene.number import Number, Vector
from warpmuscle.scene.part import ABOVE_0, FRACTION, FROM_0, Part


class Condition(Part):
    """The interval of a joint's coordinate in which a via point counts.

    The path slides on and off it about both ends, or with a blend of 0 jumps there, as OpenSim's conditional points do.
    With the angles of a ball joint it jumps; they are those that the joint's limits are of.

    Where it slides, its length changes by the detour over the point, however far the joint turns meanwhile. A "slope"
    is a moment arm with that, with which a tension does the work that the shortening takes, and large where the detour
    is. "weighted" moment arms leave it out, as OpenSim's do: they lie between those with the point and without it.
    """

    joint: str
    low: Annotated[Number, "rad or m"]
    high: Annotated[Number, "rad or m"]
    blend: Annotated[Number, "rad or m"] = 0.1  # width of the transition about each end
    axis: int = 0  # which angle of a universal or ball joint
    moment_arms: Literal["slope", "weighted"] = "slope"  # where the path slides


class PointMotion(Displacement):
    """How far a point of a path moves along an axis of its body, as a function of a joint's coordinate."""

    joint: str = ""  # one whose coordinates are numbers
    within: Annotated[list[float], "rad or m"] = []  # lowest and highest coordinate, beyond which the point stays


class ViaPoint(Part):
    """A point of a muscle's path, fixed to a body: at a position, or on a line, where a search may move it along.

    Positions are in the body's frame: from its centre of mass, m. The position on a line is start + at (end - start).
    What `motion` says is added to either.
    """

    body: str
    position: Annotated[Vector | None, "m"] = None
    condition: Condition | None = None  # a path goes from the first to the last point that counts
    start: Annotated[Vector | None, "m"] = None  # of the line, all three in place of `position`
    end: Annotated[Vector | None, "m"] = None
    at: Annotated[Number | None, "1"] = None  # 0 at the start of the line, 1 at its end
    motion: list[PointMotion] = []  # of a point that moves on its body while a joint does

    def place(self) -> tuple[Any, Any, Any]:
        """The position, m, of a checked point whose numbers are floats, or (n,) arrays with one value an instance."""
        if self.position is not None:
            return self.position
        start, end, at = cast("tuple[tuple[Any, ...], tuple[Any, ...], Any]", (self.start, self.end, self.at))
        x, y, z = (a + at * (b - a) for a, b in zip(start, end, strict=True))
        return x, y, z


class Excitation(Part):
    """Excitation over time, straight between knots and constant beyond them, in place of the controller's."""

    time: Annotated[list[Number], "s"]
    value: Annotated[list[Number], "1", FRACTION]  # 0..1
    period: Annotated[Number, "s", FROM_0] = 0.0  # after which it starts again; 0: never


class Pulley(Part):
    """A joint angle that a muscle runs over at a constant radius (Cruz Ruiz 2015, eq. 3)."""

    joint: str  # a hinge or a universal joint
    moment_arm: Annotated[Number, "m"]  # positive if the muscle turns the child towards greater angles
    rest_angle: Annotated[Number, "rad"] = 0.0  # at which it takes nothing from the muscle's rest length
    axis: int = 0  # which angle of a universal joint


class Wrap(Part):
    """A surface of the character that a path wraps around, where it would run through it.

    `first` and `last` are the points of the path, counted from 1, between which it does; all of them if not given.
    `method`: how the path runs over an ellipsoid, which other surfaces do not ask for: in the plane through its middle
    (`midpoint`), in one along its axis that is nearest to the muscle's way (`axial`), or between the two (`hybrid`).
    The surfaces of a path are gone round in their order, as OpenSim does it.
    """

    surface: str
    first: int | None = None
    last: int | None = None
    method: Literal["hybrid", "midpoint", "axial"] = "hybrid"


class Branch(Part):
    """A part of a path with a tension of its own: the path runs over a pulley there, as a tendon of MuJoCo's does.

    Lengths of the branch count by 1/divisor, and it pulls with that part of the muscle's force. It is not joined to
    the branch before: the way from the point before it counts nothing.
    """

    first: int  # point of the path, counted from 1, with which it begins; it ends before the next branch
    divisor: Annotated[Number, "1", ABOVE_0] = 1.0


class PolynomialPath(Part):
    """The length of a muscle as a polynomial of joints' coordinates, in place of points.

    It is the sum over k of coefficients[k] times the product over i of q_i^exponents[k][i]; its gradient gives the
    moment arms. Such paths are fitted to others (see `warpmuscle fit-paths`).
    """

    joints: list[str]  # whose coordinates are numbers
    exponents: list[list[int]]  # a row a term, with one exponent a joint
    coefficients: Annotated[list[Number], "m"]  # one a term; over coordinates in rad or m
    axes: list[int] = []  # which angle of each joint; the first if not given


class Muscle(Part, kw_only=True):
    """A musculotendon unit: where it runs, and the properties of fibre and tendon.

    It has a path of points from origin to insertion, which may wrap around surfaces and have branches; or pulleys: then
    its length is rest_length less the sum of moment_arm (angle - rest_angle) over them; or a polynomial.
    From `tendon` on, what it has in place of the same of `MuscleModel`, whose it is where nothing is given.
    With a `curve_shape` of the type `path_actuator` or `ligament` it is none, but pulls along its path as these say.
    """

    path: list[ViaPoint] = []
    wraps: list[Wrap] = []
    branches: list[Branch] = []
    polynomial: PolynomialPath | None = None
    pulleys: list[Pulley] = []
    rest_length: Annotated[Number | None, "m", ABOVE_0] = None  # of the unit with its tendon; with pulleys only
    f_max: Annotated[Number, "N", ABOVE_0]  # maximum isometric force
    l_opt: Annotated[Number, "m", ABOVE_0]  # optimal fibre length
    l_slack: Annotated[Number, "m"]  # slack length of the tendon
    delay: Annotated[Number, "s", FROM_0] = 0.0  # from controller to muscle
    pennation: Annotated[Number, "rad", FROM_0] = 0.0  # at the optimal fibre length
    slow_fibres: Annotated[Number, "1"] = 0.5  # fraction of slow-twitch fibres, for the metabolic power
    specific_tension: Annotated[Number | None, "Pa"] = None  # in place of that of `MuscleModel`
    excitation: Excitation | None = None
    tendon: Literal["rigid", "compliant"] | None = None
    v_max: Annotated[Number | None, "l_opt/s", ABOVE_0] = None
    damping: Annotated[Number | None, "1", FROM_0] = None
    rise_time: Annotated[Number | None, "s", ABOVE_0] = None
    fall_time: Annotated[Number | None, "s", ABOVE_0] = None
    # Where `MuscleModel` has one of these:
    activation: Literal["scaled", "blended", "excited", "excited_rise"] | None = None
    activation_smoothing: Annotated[Number | None, "1", FROM_0] = None
    minimum_activation: Annotated[Number | None, "1", FRACTION] = None
    tendon_strain: Annotated[Number | None, "1", ABOVE_0] = None
    passive_strain: Annotated[Number | None, "1", ABOVE_0] = None
    curve_shape: CurveShape | None = None


class MuscleModel(Part):
    """What all muscles have in common; the sources of the curves stand in `kernels/curve/curve_sets.py`.

    `tendon`: rigid; switch, rigid up to l_opt and infinitely compliant beyond it (Bergmann 2017, section 4.1.1); or
    compliant, with the fibre length as a state (Millard 2013). Fibre length, speed and force stay within physical
    bounds. `legacy`: exactly as the original program computed it, unbounded, with its switch and its old moment arms.
    `ideal`: a muscle's force is the desired one, without activation and contraction (Bergmann 2017, section 7.1).
    `law`: the law of muscles by its name, see `kernels/muscle/law_names.py`; `legacy` and `ideal` are short for two.
    `activation`: linear, with constant rates; scaled, rates depend on the activation (Thelen 2003, eq. 1 and 2); or
    neural, linear after a neural signal that follows the excitation (Cruz Ruiz 2015, eq. 11); excited, the rate goes
    from 1/fall_time to 1/rise_time with the excitation, as in Hyfydy; excited_rise, it does so while the activation
    rises, as in OpenSim's Schutte1993Muscle_Deprecated; blended, it lies between the scaled ones, as in
    OpenSim's DeGrooteFregly2016Muscle.
    `activation_smoothing`: of scaled rates, by how much excitation and activation differ where the time constant goes
    smoothly from that of falling to that of rising (MuJoCo's `tausmooth`); at 0 it changes at once.
    `implicit_damping`: with rigid tendons, what force changes with speed is linearised over the step, so that strong
    muscles on light bodies stay stable; so are the dampers of the joints.
    `negative`: what a joint counts in a muscle's desired force that wants the muscle to push: keep it, drop the joint
    from the average, or clip it to zero.
    `sharing`: whose torque a muscle gives. Each: every muscle the whole torque of its joints, on average over them
    (Bergmann 2017, section 5.1). Least effort: all muscles together what all joints want along the degrees of freedom
    that muscles drive, by the activations of least sum of mass times activation squared; see `kernels.muscle.sharing`.
    `specific_tension`: force over physiological cross-section, from which the mass of muscles follows (see
    `masses.py`) and with it their metabolic heat, but no motion. The default is that of models of legs from which f_max
    is usually taken (Arnold 2010: 0.61 MPa for all muscles; Falisse 2022: 0.55 MPa in the mean). With it the leg
    muscles of Rajagopal 2016 weigh 15 kg of 75; with 0.25 MPa, the default of OpenSim and SCONE, 36 kg.
    `curve_shape`: numbers of the curves that are not their defaults. With one, or with a strain, muscles are bounded as
    OpenSim's are: no bound on passive force and speed, and the shortest fibre as in `curves.py`.
    """

    curves: CurveSet = "lee"
    active_force_length: str = ""  # `module:function` of a curve, see `user_functions`, in place of that of `curves`
    passive_force_length: str = ""
    force_velocity: str = ""
    tendon: Literal["rigid", "switch", "compliant"] = "rigid"
    legacy: bool = False
    ideal: bool = False
    negative: Literal["keep", "drop", "clip"] = "keep"
    sharing: Literal["each", "least_effort"] = "each"
    activation: Literal["linear", "scaled", "neural", "excited", "excited_rise", "blended"] = "linear"
    rise_time: Annotated[Number, "s", ABOVE_0] = 0.01  # time constant of activation
    fall_time: Annotated[Number, "s", ABOVE_0] = 0.01  # of deactivation
    activation_smoothing: Annotated[Number, "1", FROM_0] = 0.0  # of scaled rates, see above
    neural_time: Annotated[Number, "s", ABOVE_0] = 0.001  # of the neural signal that the activation follows
    initial_activation: Annotated[Number, "1", FRACTION] = 1.0e-4
    minimum_activation: Annotated[Number, "1", FRACTION] = 0.0  # the activation is never less
    v_max: Annotated[Number, "l_opt/s", ABOVE_0] = 10.0  # fastest shortening
    damping: Annotated[Number, "1", FROM_0] = 0.1  # of the fibre: beta of Millard 2013, f_max at v_max
    implicit_damping: bool = False
    specific_tension: Annotated[Number, "Pa"] = 6.0e5
    tendon_strain: Annotated[Number | None, "1", ABOVE_0] = None  # of the tendon at f_max; None: that of the curves
    passive_strain: Annotated[Number | None, "1", ABOVE_0] = None  # of the fibre whose passive force is f_max
    curve_shape: CurveShape | None = None
    law: Law = "hill"


def given(muscle: Muscle, model: MuscleModel, field: str) -> Any:
    """What a muscle has of a field of both: its own, or that of its model."""
    own = getattr(muscle, field)
    return getattr(model, field) if own is None else own


def law_of(model: MuscleModel) -> str:
    """The law of muscles, one of `law_names.NAMES`: by its name, or by the field that is short for it."""
    return "legacy" if model.legacy else "ideal" if model.ideal else model.law


def is_cable(muscle: Muscle) -> bool:
    """Whether it is an actuator or a ligament."""
    return isinstance(muscle.curve_shape, CABLES)


Drive = Literal["torque", "muscle", "assisted", "passive", "kinematic", "none"]  # none: not even the spring-damper


class Actuation(Part):
    """What drives a joint: one word, or one a degree of freedom.

    A ball joint has three, about the child's x, y and z; a universal joint two and a hinge one, about their axes.
    Torque: the controller's; muscle: what the muscles pull; assisted: both together; passive: neither; kinematic: it
    moves as the scene's `motion` says, or stays as in the initial state, whatever that takes. A spring-damper acts
    besides on muscle, assisted and passive degrees of freedom, if it has a stiffness or damping.
    A spring of a joint of one coordinate, such as a slide, acts along it, N/m and N s/m if it is a length; `rest` is
    then that coordinate times the joint's first axis.
    A joint that is not named is driven by the muscles that cross it, or by torque if there are none.
    """

    drive: Drive | list[Drive]
    stiffness: Annotated[Number, "N m/rad", FROM_0] = 0.0
    damping: Annotated[Number, "N m s/rad", FROM_0] = 0.0
    rest: Annotated[Vector, "rad"] = (0.0, 0.0, 0.0)  # rotation vector of the relaxed spring, from the reference pose
