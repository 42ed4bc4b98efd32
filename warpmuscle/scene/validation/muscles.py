"""What the types of a scene cannot say about muscles and about what drives the joints."""

from __future__ import annotations

from functools import partial

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Actuation, Excitation, MujocoCurves, Muscle, PolynomialPath, Scene
from warpmuscle.scene.initial_pose import initial_pose, plain_number
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.masses import mass_warnings
from warpmuscle.scene.muscles import given, is_cable, law_of
from warpmuscle.scene.number import Number
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.trusted_code import CURVE_FIELDS
from warpmuscle.scene.validation.checks import Checks, known
from warpmuscle.scene.validation.muscle_values import check_common_values, check_special_values, those_of_law
from warpmuscle.scene.validation.paths import check_route, check_surfaces, usual_drive
from warpmuscle.scene.wrapping.path import path_length
from warpmuscle.scene.wrapping.route import route_stops

TENSIONS = (1.0e3, 1.0e8)  # Pa, far beyond those of any muscle: outside, another unit is meant
LONGEST_PATH = 10.0  # m, far beyond those of any body: above, another unit is meant
MOST_STRETCHED = 10.0  # of l_opt, far beyond what a fibre bears: its force would throw the body about
GREATEST_PENNATION = 1.4  # rad; near a right angle a fibre pulls on nothing
MUSCULAR = {"muscle", "assisted"}


class SceneWarning(UserWarning):
    """Something in a sound scene that is probably a mistake."""


def check_muscles(checks: Checks) -> None:
    """Check muscles, their model and what drives the joints, in a scene whose bodies and joints are sound.

    Raises:
        SceneError: the first thing wrong, with its key, such as `character.muscles.VAS.path.0.body`.
    """
    scene = checks.checked
    check_surfaces(checks, scene.character)
    for name, muscle in scene.character.muscles.items():
        _muscle(checks, f"character.muscles.{name}", muscle)
    _model(checks)
    for name, own in scene.actuation.items():
        _actuation(checks, f"actuation.{name}", name, own)


def _muscle(checks: Checks, key: str, muscle: Muscle) -> None:
    """A muscle has a path, force and lengths, and a delay within the simulation."""
    scene = checks.checked
    check_route(checks, key, muscle)
    check_special_values(checks, key, muscle)
    if not isinstance(given(muscle, checks.checked.muscle_model, "curve_shape"), MujocoCurves):
        checks.not_negative(f"{key}.l_slack", muscle.l_slack)
    longest = checks.interval(muscle.delay)[1]
    if longest >= scene.duration:
        raise SceneError(
            f"must be less than the scene's duration of {scene.duration:g} s, is {longest:g} s", f"{key}.delay"
        )
    check_size("delay", longest / scene.time_step, partial(SceneError, key=f"{key}.delay"))
    steepest = checks.interval(muscle.pennation)[1]
    if steepest >= GREATEST_PENNATION:
        raise SceneError(f"must be less than {GREATEST_PENNATION:g} rad, is {steepest:g}", key=f"{key}.pennation")
    if muscle.specific_tension is not None:
        _tension(checks, key, muscle.specific_tension)
    if muscle.excitation is not None:
        _excitation(checks, f"{key}.excitation", muscle.excitation)


def _tension(checks: Checks, key: str, tension: Number) -> None:
    """A specific tension is one that some muscle might have."""
    key = f"{key}.specific_tension"
    least, greatest = checks.interval(tension)
    if least < TENSIONS[0] or greatest > TENSIONS[1]:
        wrong = least if least < TENSIONS[0] else greatest
        raise SceneError(f"must be within {TENSIONS[0]:g} and {TENSIONS[1]:g} Pa, is {wrong:g}; 0.6 MPa are 6e5", key)


def _excitation(checks: Checks, key: str, excitation: Excitation) -> None:
    """Knots over time are in order, their values excitations."""
    if not excitation.time:
        raise SceneError("an excitation needs at least one knot", key=f"{key}.time")
    if len(excitation.time) != len(excitation.value):
        raise SceneError(
            f"{number_of(len(excitation.value), 'value')} for {number_of(len(excitation.time), 'time')}",
            key=f"{key}.value",
        )
    checks.increasing(f"{key}.time", excitation.time, "times")


def _model(checks: Checks) -> None:
    """The model of all muscles has rates, and does not ask for two laws at once."""
    key, model = "muscle_model", checks.checked.muscle_model
    _tension(checks, key, model.specific_tension)
    check_common_values(checks, key, model)
    if model.sharing != "each" and law_of(model) == "legacy":
        raise SceneError("legacy muscles cannot share torques; leave out `sharing` or `legacy`", key=f"{key}.sharing")
    if model.sharing != "each" and model.negative != "keep":
        raise SceneError("has no effect on muscles that share torques; leave it out", key=f"{key}.negative")
    if model.implicit_damping and (law_of(model) != "hill" or model.tendon != "rigid"):
        raise SceneError("implicit damping is for muscles with rigid tendons only", key=f"{key}.implicit_damping")
    for field in CURVE_FIELDS:
        if getattr(model, field) and law_of(model) != "hill":
            message = f"{those_of_law(model)} take no curve of one's own; leave it out"
            raise SceneError(message, key=f"{key}.{field}")
    if model.legacy and model.ideal:
        raise SceneError("muscles cannot be both legacy and ideal", key=f"{key}.ideal")
    if model.law not in ("hill", law_of(model)):
        raise SceneError(f"muscles cannot be both {law_of(model)} and {model.law}; leave one out", key=f"{key}.law")
    for field, default in (("tendon", "rigid"), ("curves", "lee")):
        if law_of(model) == "legacy" and getattr(model, field) != default:
            message = f"legacy muscles have a law of their own, tendon and curves included; leave out `{field}`"
            raise SceneError(message, key=f"{key}.{field}")


def _actuation(checks: Checks, key: str, name: str, own: Actuation) -> None:
    """What drives a joint: one word, or one a degree of freedom; muscles only where there are some."""
    character = checks.checked.character
    known(name, character.joints, "joint", key)
    kind = joint_type(character.joints[name])
    if not kind.moves:
        raise SceneError(f"a {kind.name} joint cannot be driven", key=key)
    words = [own.drive] if isinstance(own.drive, str) else own.drive
    if not isinstance(own.drive, str) and len(words) != len(kind.speeds):
        message = f"a {kind.name} joint takes one word or {len(kind.speeds)} in a list, got {len(words)}"
        raise SceneError(message, key=f"{key}.drive")
    if kind.quaternion and "kinematic" in words and set(words) != {"kinematic"}:
        raise SceneError(f"a {kind.name} joint is kinematic as a whole or not at all", key=f"{key}.drive")
    if MUSCULAR.intersection(words) and usual_drive(name, character) != "muscle":
        raise SceneError("no muscle crosses this joint", key=f"{key}.drive")


def muscle_warnings(scene: Scene) -> list[SceneError]:
    """What about the muscles of a checked scene is probably a mistake; see `slack_warnings` and `mass_warnings`."""
    return [*slack_warnings(scene), *mass_warnings(scene)]


def slack_warnings(scene: Scene) -> list[SceneError]:
    """Muscles whose tendon alone is as long as their path in the initial pose, or whose path is far too long.

    Free parameters are at their start values.

    Legacy and ideal muscles have no such bound.

    Args:
        scene: checked scene.

    Returns:
        Errors that are not raised, so that a reader can give them file and line; their keys name the muscles.
    """
    if law_of(scene.muscle_model) != "hill" or not scene.character.muscles:
        return []
    plain = at_start(scene)
    lengths = initial_path_lengths(plain)
    found = []
    for name, muscle in plain.character.muscles.items():
        key = f"character.muscles.{name}"
        if lengths[name] > LONGEST_PATH:
            message = f"its path is {lengths[name]:.3g} m long in the initial pose: are its points in metres?"
            found.append(SceneError(message, key=key))
        elif lengths[name] <= plain_number(muscle.l_slack) and not is_cable(muscle):
            found.append(SceneError(_no_fibre(muscle, lengths[name]), key=f"{key}.l_slack"))
        elif not is_cable(muscle):
            fibre, opt = lengths[name] - plain_number(muscle.l_slack), plain_number(muscle.l_opt)
            if fibre > MOST_STRETCHED * opt:
                message = f"its fibre is stretched to {fibre / opt:.3g} times l_opt {opt:.3g} m in the initial pose, "
                message += f"where the path is {lengths[name]:.3g} m: are l_opt and l_slack in metres?"
                found.append(SceneError(message, key=f"{key}.l_opt"))
    return found


def initial_path_lengths(scene: Scene) -> dict[str, float]:
    """Length, m, of every muscle's path in the initial pose of a scene without free parameters.

    A conditional point counts where its angle is within its interval, without the blend about both ends.
    """
    poses, angles = initial_pose(scene)
    lengths = {}
    for name, muscle in scene.character.muscles.items():
        if muscle.pulleys:
            lengths[name] = _pulley_length(muscle, angles)
            continue
        if muscle.polynomial is not None:
            lengths[name] = _polynomial_length(muscle.polynomial, angles)
            continue
        lengths[name] = path_length(route_stops(scene.character, muscle, poses, angles))
    return lengths


def _pulley_length(muscle: Muscle, angles: dict[str, Floats]) -> float:
    """Length of a muscle on pulleys at angles of the joints, rad."""
    assert muscle.rest_length is not None
    taken = (
        plain_number(p.moment_arm) * (float(angles[p.joint][p.axis]) - plain_number(p.rest_angle))
        for p in muscle.pulleys
    )
    return plain_number(muscle.rest_length) - sum(taken)


def _polynomial_length(polynomial: PolynomialPath, angles: dict[str, Floats]) -> float:
    """Length of a muscle whose path is a polynomial of joints' coordinates."""
    axes = polynomial.axes or [0] * len(polynomial.joints)
    q = np.array([float(angles[joint][axis]) for joint, axis in zip(polynomial.joints, axes, strict=True)])
    terms = np.prod(q ** np.array(polynomial.exponents), axis=1)
    return float(np.dot([plain_number(c) for c in polynomial.coefficients], terms))


def _no_fibre(muscle: Muscle, length: float) -> str:
    """What is wrong with a slack length, m, that a path of this length, m, leaves no room beside."""
    fitting = length - plain_number(muscle.l_opt) * float(np.cos(plain_number(muscle.pennation)))
    hint = f"{fitting:.3g} m would fit (path minus l_opt)"
    if fitting <= 0.0:
        hint = f"l_opt {plain_number(muscle.l_opt):.3g} m alone is as long"
    slack = plain_number(muscle.l_slack)
    return f"slack length {slack:.3g} m leaves no fibre in the initial pose, where the path is {length:.3g} m; {hint}"
