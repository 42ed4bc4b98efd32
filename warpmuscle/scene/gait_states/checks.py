"""What the types of a scene cannot say about states of gait."""

from __future__ import annotations

from functools import partial

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene.gait_states.part import ROOT, GaitPattern, GaitReflex, GaitStates, sided
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.validation.checks import Checks, known

KEY = "gait_states"
SIDES = "lr"
MOST_KNOTS = 99


def check_gait_states(checks: Checks) -> None:
    """Check the states of gait of a scene whose character is sound, if it has any.

    Raises:
        SceneError: the first thing wrong, with its key, such as `gait_states.reflexes.stretch.of`.
    """
    scene = checks.checked
    states: GaitStates | None = scene.gait_states
    if states is None:
        return
    if scene.controller is not None or scene.custom_controller:
        raise SceneError("there is another controller: leave out one of them", key=KEY)
    if scene.feet is None:
        raise SceneError("it needs the feet of the character: name them in character.feet", key=KEY)
    known(states.base, scene.character.bodies, "body", f"{KEY}.base")
    if states.control_step < scene.time_step:
        message = f"is shorter than a step of the simulation, {scene.time_step:g} s"
        raise SceneError(message, key=f"{KEY}.control_step")
    if not states.reflexes and not states.patterns:
        raise SceneError("it needs a reflex or a pattern at least", key=f"{KEY}.reflexes")
    for name, reflex in states.reflexes.items():
        _reflex(checks, f"{KEY}.reflexes.{name}", reflex, states.control_step)
    for name, pattern in states.patterns.items():
        _pattern(checks, f"{KEY}.patterns.{name}", pattern)
    if states.noise is not None and not 0 <= states.noise.seed < 2**31:
        raise SceneError("must be a whole number from 0 to 2147483647", key=f"{KEY}.noise.seed")


def _pattern(checks: Checks, key: str, pattern: GaitPattern) -> None:
    """A pattern acts on a muscle, in a state at least, and has knots one after the other."""
    muscles = checks.checked.character.muscles
    for side in _sides(pattern):
        known(sided(pattern.muscle, muscles, side), muscles, "muscle", f"{key}.muscle")
    if not pattern.during:
        raise SceneError("it acts in no state; name one at least", key=f"{key}.during")
    if not 1 <= len(pattern.values) <= MOST_KNOTS:
        raise SceneError(f"it needs 1 to {MOST_KNOTS} values, has {len(pattern.values)}", key=f"{key}.values")
    wanted = 0 if pattern.shape == "polynomial" else len(pattern.values) - 1
    if len(pattern.intervals) != wanted:
        raise SceneError(f"it needs {wanted} of them, has {len(pattern.intervals)}", key=f"{key}.intervals")


def _sides(part: GaitReflex | GaitPattern) -> str:
    """The sides that it acts on."""
    return {"both": SIDES, "left": "l", "right": "r"}[part.side]


def _reflex(checks: Checks, key: str, reflex: GaitReflex, control_step: float) -> None:
    """A reflex acts on and senses what there is on both sides, in a state at least, and not too late."""
    character = checks.checked.character
    for side in _sides(reflex):
        muscles = character.muscles
        known(sided(reflex.muscle, muscles, side), muscles, "muscle", f"{key}.muscle")
        sensed = SIDES[1 - SIDES.index(side)] if reflex.opposite else side
        if reflex.of:
            known(sided(reflex.of, muscles, sensed), muscles, "muscle", f"{key}.of")
        for field, body in _bodies(reflex):
            known(sided(body, character.bodies, sensed), character.bodies, "body", f"{key}.{field}")
        for field in ("joint", "within_joint"):
            named = getattr(reflex, field)
            if not named or (named == ROOT and field == "joint"):
                continue
            joint = sided(named, character.joints, sensed if field == "joint" else side)
            known(joint, character.joints, "joint", f"{key}.{field}")
            kind = joint_type(character.joints[joint])
            if kind.scalars != 1:
                raise SceneError(f"a {kind.name} joint has no angle for a reflex", key=f"{key}.{field}")
    if sided(reflex.muscle, character.muscles, "l") == sided(reflex.muscle, character.muscles, "r"):
        raise SceneError("a muscle of both legs is named without its side", key=f"{key}.muscle")
    if not reflex.during:
        raise SceneError("it acts in no state; name one at least", key=f"{key}.during")
    _sensed(checks, key, reflex)
    most = checks.interval(reflex.delay)[1] / control_step
    check_size("delay", most, partial(SceneError, key=f"{key}.delay"))


def _bodies(reflex: GaitReflex) -> list[tuple[str, str]]:
    """The bodies that a reflex senses, by field."""
    found = [(f"{name}.body", part.body) for name in ("point", "turn") if (part := getattr(reflex, name)) is not None]
    if reflex.balance is not None and reflex.balance.pivot:
        found.append(("balance.pivot", reflex.balance.pivot))
    return found


def _sensed(checks: Checks, key: str, reflex: GaitReflex) -> None:
    """Angles are of one thing, positions of another; gains have something to sense, and directions a length."""
    if reflex.joint and reflex.turn is not None:
        raise SceneError("an angle is sensed of a joint or of a body's turn, not of both", key=f"{key}.turn")
    if reflex.point is not None and reflex.balance is not None:
        raise SceneError("a position is sensed of a point or of the centre of mass, not of both", key=f"{key}.balance")
    for field in ("angle_gain", "rate_gain"):
        if not reflex.joint and reflex.turn is None and checks.interval(getattr(reflex, field)) != (0.0, 0.0):
            raise SceneError("needs a `joint` or a `turn` to sense", key=f"{key}.{field}")
    for field in ("position_gain", "speed_gain"):
        none = reflex.point is None and reflex.balance is None
        if none and checks.interval(getattr(reflex, field)) != (0.0, 0.0):
            raise SceneError("needs a `point` or a `balance` to sense", key=f"{key}.{field}")
    if reflex.point is None and checks.interval(reflex.acceleration_gain) != (0.0, 0.0):
        raise SceneError("needs a `point` to sense", key=f"{key}.acceleration_gain")
    still = reflex.balance is None or checks.interval(reflex.speed_gain) == (0.0, 0.0)
    if not still and checks.checked.ground.treadmill is not None:
        message = "how fast the centre of mass goes from its pivot is not known on a treadmill"
        raise SceneError(message, key=f"{key}.speed_gain")
    if reflex.turn is not None:
        checks.not_zero(f"{key}.turn.axis", reflex.turn.axis, "the axis")
    if reflex.point is not None:
        checks.not_zero(f"{key}.point.direction", reflex.point.direction, "the direction")
    if reflex.balance is not None:
        x, _, z = reflex.balance.direction
        checks.not_zero(f"{key}.balance.direction", (x, 0.0, z), "the level part of the direction")
