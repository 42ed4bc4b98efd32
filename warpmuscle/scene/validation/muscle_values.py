"""What the types cannot say about the numbers of fibres, tendons and curves, a muscle's own or common to all."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import (
    CurveShape,
    Ligament,
    MillardCurves,
    MujocoCurves,
    Muscle,
    MuscleModel,
    Spline,
    SplineCurves,
    ThelenCurves,
)
from warpmuscle.scene.joints.displacement import rates
from warpmuscle.scene.muscles import is_cable, law_of
from warpmuscle.scene.muscles.cables import LIGAMENTS
from warpmuscle.scene.muscles.curves import SHAPED, SPECIAL, STRAINS, family
from warpmuscle.scene.number import Free
from warpmuscle.scene.trusted_code import CURVE_FIELDS
from warpmuscle.scene.validation.checks import Checks

ROUNDED = 1.0e-6  # of f_max, by which a curve may fall between its knots
OPENSIM_ACTIVATIONS = ("scaled", "blended", "excited", "excited_rise")  # that one scene may have side by side
FLATTEST = 1.5e-8  # slope of force over speed, as OpenSim has it


def check_common_values(checks: Checks, key: str, model: MuscleModel) -> None:
    """Check what `MuscleModel` says of every muscle.

    Raises:
        SceneError: a number out of its range, or one that the model's curves do not have.
    """
    _smoothing(key, model, model)
    shape = model.curve_shape
    if shape is not None and family(shape) not in (model.curves, "spline"):
        message = f"this is the shape of other curves; muscle_model.curves is {model.curves!r}"
        raise SceneError(message, key=f"{key}.curve_shape.type")
    _damping(checks, key, model, model.tendon == "compliant", _shaped(model, model))
    _shape(checks, key, model, model)


def check_special_values(checks: Checks, key: str, muscle: Muscle) -> None:
    """Check what a muscle has in place of the same of `MuscleModel`, and its slack length.

    Raises:
        SceneError: a number out of its range, or one that the muscle's curves or law do not have.
    """
    model = checks.checked.muscle_model
    if is_cable(muscle):
        _cable(checks, key, muscle, model)
        return
    if muscle.activation is not None and (law_of(model) != "hill" or model.activation not in OPENSIM_ACTIVATIONS):
        laws = "scaled, blended, excited or excited_rise"
        message = f"only where that of muscle_model is {laws} may a muscle have its own; leave it out"
        raise SceneError(message, key=f"{key}.activation")
    if muscle.activation_smoothing is not None:
        _smoothing(key, muscle, model)
    if muscle.tendon is not None and model.tendon == "switch":
        raise SceneError(
            "where the tendons of all muscles switch, a muscle cannot have another tendon", key=f"{key}.tendon"
        )
    compliant = (muscle.tendon or model.tendon) == "compliant"
    if compliant:
        checks.positive(f"{key}.l_slack", muscle.l_slack)
    if compliant and muscle.damping is None and muscle.tendon is not None:
        _damping(checks, "muscle_model", model, compliant, _shaped(muscle, model))
    if muscle.damping is not None:
        _damping(checks, key, muscle, compliant, _shaped(muscle, model))
    _shape(checks, key, muscle, model)


def _smoothing(key: str, part: Muscle | MuscleModel, model: MuscleModel) -> None:
    """Time constants that change smoothly are those of rates that depend on the activation."""
    activation = model.activation if part.activation is None else part.activation
    if (law_of(model) != "hill" or activation != "scaled") and part.activation_smoothing != 0.0:
        raise SceneError('only `activation = "scaled"` is smoothed; leave it out', key=f"{key}.activation_smoothing")


def those_of_law(model: MuscleModel) -> str:
    """The muscles of a law that is not Hill's, as errors have them."""
    return "legacy and ideal muscles" if law_of(model) in ("legacy", "ideal") else f"muscles of the law {law_of(model)}"


def _shaped(part: Muscle | MuscleModel, model: MuscleModel) -> bool:
    """Whether a muscle has OpenSim's bounds, see `MuscleModel`."""
    return any(getattr(one, field) is not None for one in (part, model) for field in SHAPED)


def _damping(checks: Checks, key: str, part: Muscle | MuscleModel, compliant: bool, shaped: bool) -> None:
    """A fibre with a compliant tendon has damping, unless its curves are those of OpenSim."""
    if compliant and not shaped:
        checks.positive(f"{key}.damping", part.damping or 0.0)


def _shape(checks: Checks, key: str, part: Muscle | MuscleModel, model: MuscleModel) -> None:
    """Strains and shape are those of a family of curves, and give curves that rise and fall where they should."""
    given = [field for field in SHAPED if getattr(part, field) is not None]
    own_tendon = ["tendon"] if isinstance(part, Muscle) and part.tendon is not None else []
    floor = ["minimum_activation"] if part.minimum_activation not in (None, 0.0) else []
    if law_of(model) != "hill":
        for field in [*given, *own_tendon, *floor]:
            raise SceneError(f"{those_of_law(model)} have no `{field}`; leave it out", key=f"{key}.{field}")
    if not given:
        return
    if any(getattr(model, field) for field in CURVE_FIELDS):
        raise SceneError("muscles with curves of your own take no shape; leave it out", key=f"{key}.{given[0]}")
    shape = part.curve_shape or model.curve_shape
    curves = family(shape) if shape is not None else model.curves
    if curves not in STRAINS or model.curves not in STRAINS:
        known = ", ".join(STRAINS)
        raise SceneError(f"{model.curves!r} curves have no `{given[0]}`; {known} have", key=f"{key}.{given[0]}")
    tendon, passive = (_strain(part, model, field, curves) for field in ("tendon_strain", "passive_strain"))
    for field, number in (("tendon_strain", tendon), ("passive_strain", passive)):
        of_table = field == "passive_strain" or (isinstance(shape, MillardCurves) and shape.tendon_slope is not None)
        if curves == "millard" and isinstance(number, Free) and of_table:
            message = "Millard's curves are tables, which no search can change; give a number"
            raise SceneError(message, key=f"{key if getattr(part, field) is not None else 'muscle_model'}.{field}")
    if shape is not None:
        place = f"{key}.curve_shape" if part.curve_shape is not None else "muscle_model.curve_shape"
        _curves(checks, place, shape, checks.start(tendon), checks.start(passive))


def _cable(checks: Checks, key: str, muscle: Muscle, model: MuscleModel) -> None:
    """An actuator or a ligament has nothing of a muscle's own, and stands beside muscles with curves of OpenSim's."""
    assert muscle.curve_shape is not None
    what = family(muscle.curve_shape).replace("_", " ")
    fibre = [field for field in SPECIAL if field != "curve_shape" and getattr(muscle, field) is not None]
    fibre += ["pennation"] if muscle.pennation != 0.0 else []
    if isinstance(muscle.curve_shape, LIGAMENTS):
        fibre += [field for field in ("excitation",) if muscle.excitation is not None]
    for field in fibre:
        raise SceneError(f"a {what} has no `{field}`; leave it out", key=f"{key}.{field}")
    place = f"{key}.curve_shape.type"
    if law_of(model) != "hill" or model.sharing != "each" or any(getattr(model, field) for field in CURVE_FIELDS):
        message = "needs muscles that are neither legacy nor ideal, share no torques and have OpenSim's curves"
        raise SceneError(f"a {what} {message}", key=place)
    if model.curves not in STRAINS:
        raise SceneError(f"a {what} needs muscles with curves of {', '.join(STRAINS)}", key=place)
    checks.positive(f"{key}.l_slack", muscle.l_slack)
    if isinstance(muscle.curve_shape, Ligament):
        check_knots(checks, f"{key}.curve_shape", muscle.curve_shape, "a ligament", "tension", "length")


def check_knots(checks: Checks, key: str, curve: Ligament | Spline, what: str, value: str, place: str) -> None:
    """Two knots at least, in order, with a value for each place.

    Raises:
        SceneError: they are not, with the key.
    """
    if len(curve.x) < 2:
        raise SceneError(f"{what} needs at least two knots, got {len(curve.x)}", key=f"{key}.x")
    if len(curve.x) != len(curve.y):
        raise SceneError(f"{number_of(len(curve.y), value)} for {number_of(len(curve.x), place)}", key=f"{key}.y")
    check_size("knots", len(curve.x), lambda message: SceneError(message, key=f"{key}.x"))
    checks.increasing(f"{key}.x", curve.x, f"{place}s")


def _strain(part: Muscle | MuscleModel, model: MuscleModel, field: str, curves: str) -> Any:
    """A strain at f_max: a muscle's own, that of its model, or that of its curves."""
    for one in (part, model):
        if getattr(one, field) is not None:
            return getattr(one, field)
    return STRAINS[curves][field == "passive_strain"]


def _curves(checks: Checks, key: str, shape: CurveShape, tendon_strain: float, passive_strain: float) -> None:
    """The numbers of a shape make curves."""
    if isinstance(shape, MillardCurves):
        _millard(key, shape, tendon_strain, passive_strain)
    elif isinstance(shape, ThelenCurves):
        _thelen(checks, key, shape)
    elif isinstance(shape, MujocoCurves):
        _mujoco(checks, key, shape)
    elif isinstance(shape, SplineCurves):
        _splines(checks, key, shape)


def _splines(checks: Checks, key: str, shape: SplineCurves) -> None:
    """Curves go through knots in order; those of tendon and speed rise, or no fibre would be in equilibrium."""
    for name in ("active", "passive", "tendon", "velocity"):
        curve = getattr(shape, name)
        if curve is not None:
            check_knots(checks, f"{key}.{name}", curve, "the curve", "value", "place")
    places = np.linspace(0.0, 1.0, 2001)
    tendon = rates(shape.tendon.displacement, places)
    if tendon[0].max() < 1.0 or np.any(np.diff(tendon[0]) < -ROUNDED):
        message = "must rise, and be 1 or more at some strain up to 1, as that of a tendon"
        raise SceneError(message, key=f"{key}.tendon.y")
    if shape.velocity is not None and any(
        after < before for before, after in itertools.pairwise(shape.velocity.y)
    ):  # fmt: skip
        raise SceneError("must not fall: a fibre that lengthens faster pulls more", key=f"{key}.velocity.y")


def _mujoco(checks: Checks, key: str, shape: MujocoCurves) -> None:
    for field, least, most in (
        ("active_from", 0.0, 1.0),
        ("active_until", 1.0, 1.0e3),
        ("lengthening_force", 1.0, 1.0e3),
    ):
        low, high = checks.interval(getattr(shape, field))
        if low < least or high > most or (field != "lengthening_force" and 1.0 in (low, high)):
            wrong = low if low < least or low == 1.0 else high
            raise SceneError(f"must be between {least:g} and {most:g}, is {wrong:g}", key=f"{key}.{field}")
    begins = checks.interval(shape.passive_from)[1]
    ends, field = shape.passive_until, "passive_until"
    if ends is None:
        ends, field = shape.active_until, "passive_from"
    if not checks.interval(ends)[0] > begins:
        message = f"the passive force must begin, at {begins:g}, before it ends, at {checks.interval(ends)[0]:g}"
        raise SceneError(message, key=f"{key}.{field}")


def _thelen(checks: Checks, key: str, shape: ThelenCurves) -> None:
    least = checks.interval(shape.lengthening_force)[0]
    if least <= 1.0:
        raise SceneError(f"must be greater than 1, is {least:g}", key=f"{key}.lengthening_force")
    low, high = checks.interval(shape.straight_from)
    if low * least <= 1.0 or high >= 1.0:
        wrong, bound = (high, "less than 1") if high >= 1.0 else (low, "greater than 1/lengthening_force")
        raise SceneError(f"must be {bound}, is {wrong:g}", key=f"{key}.straight_from")


def _millard(key: str, c: MillardCurves, tendon_strain: float, passive_strain: float) -> None:
    """The conditions of OpenSim's curves, which else bend back."""
    _between(key, c, "active_from", 0.0, "active_bend")
    _between(key, c, "active_bend", "active_from", 0.95)
    _between(key, c, "active_until", 1.1, 1.0e3)
    _between(key, c, "active_slope", 0.0, 1.0 / (0.95 - c.active_bend), closed=True)
    _between(key, c, "active_least", 0.0, 1.0, closed=True)
    _between(key, c, "shortening_end_slope", 0.0, 1.0, closed=True)
    _between(key, c, "shortening_slope", "shortening_end_slope", 1.0, closed=True)
    _between(key, c, "lengthening_force", 1.0, 1.0e3)
    _between(key, c, "lengthening_end_slope", 0.0, c.lengthening_force - 1.0, closed=True)
    _between(key, c, "lengthening_slope", "lengthening_end_slope", c.lengthening_force - 1.0, closed=True)
    for field in ("shortening_slope", "lengthening_slope"):  # of 0, they would be those of damped fibres' ends
        _between(key, c, field, FLATTEST, 1.0e3)
    _between(key, c, "isometric_slope", max(1.0, c.lengthening_force - 1.0), 1.0e4)
    for field in ("shortening_curviness", "lengthening_curviness", "passive_curviness", "tendon_curviness"):
        if getattr(c, field) is not None:
            _between(key, c, field, 0.0, 1.0, closed=True)
    rise = passive_strain - c.passive_slack
    if rise <= 0.0:
        raise SceneError(f"must be less than passive_strain {passive_strain:g}", key=f"{key}.passive_slack")
    if c.passive_low_slope is not None:
        _between(key, c, "passive_low_slope", 0.0, 1.0 / rise)
    for field, least in (("passive_slope", 1.0 / rise), ("tendon_slope", 1.0 / tendon_strain)):
        if getattr(c, field) is not None:
            _between(key, c, field, least, 1.0e6)
    if c.tendon_toe_force is not None:
        _between(key, c, "tendon_toe_force", 0.0, 1.0)


def _between(key: str, part: MillardCurves, field: str, low: Any, high: Any, closed: bool = False) -> None:
    """A number, which may be one of two others' names, lies between two numbers; closed: it may be the lower one."""
    value = getattr(part, field)
    least, greatest = (getattr(part, end) if isinstance(end, str) else end for end in (low, high))
    if not (least < value < greatest or (closed and value == least)):
        raise SceneError(f"must be between {least:.4g} and {greatest:.4g}, is {value:g}", key=f"{key}.{field}")
