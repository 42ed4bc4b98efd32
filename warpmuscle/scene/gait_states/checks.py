"""What the types of a scene cannot say about states of gait."""

from __future__ import annotations

from functools import partial

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene.gait_states.part import ROOT, GaitReflex, GaitStates, sided
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.validation.checks import Checks, known

KEY = "gait_states"
SIDES = "lr"


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
    checks.positive(KEY, states, "leg_length", "control_step")
    checks.not_negative(KEY, states, "stance_load")
    if states.swing_load is not None:
        checks.not_negative(KEY, states, "swing_load")
    checks.fraction(f"{KEY}.least", states.least)
    if states.control_step < scene.time_step:
        message = f"is shorter than a step of the simulation, {scene.time_step:g} s"
        raise SceneError(message, key=f"{KEY}.control_step")
    if not states.reflexes:
        raise SceneError("it needs a reflex at least", key=f"{KEY}.reflexes")
    for name, reflex in states.reflexes.items():
        _reflex(checks, f"{KEY}.reflexes.{name}", reflex, states.control_step)


def _reflex(checks: Checks, key: str, reflex: GaitReflex, control_step: float) -> None:
    """A reflex acts on and senses what there is on both sides, in a state at least, and not too late."""
    character = checks.checked.character
    for side in SIDES:
        muscles = character.muscles
        known(sided(reflex.muscle, muscles, side), muscles, "muscle", f"{key}.muscle")
        if reflex.of:
            known(sided(reflex.of, muscles, side), muscles, "muscle", f"{key}.of")
        for field in ("joint", "within_joint"):
            named = getattr(reflex, field)
            if not named or (named == ROOT and field == "joint"):
                continue
            joint = sided(named, character.joints, side)
            known(joint, character.joints, "joint", f"{key}.{field}")
            kind = joint_type(character.joints[joint])
            if kind.scalars != 1:
                raise SceneError(f"a {kind.name} joint has no angle for a reflex", key=f"{key}.{field}")
    if sided(reflex.muscle, character.muscles, "l") == sided(reflex.muscle, character.muscles, "r"):
        raise SceneError("a muscle of both legs is named without its side", key=f"{key}.muscle")
    if not reflex.during:
        raise SceneError("it acts in no state; name one at least", key=f"{key}.during")
    for field in ("angle_gain", "rate_gain"):
        if not reflex.joint and checks.interval(getattr(reflex, field)) != (0.0, 0.0):
            raise SceneError("needs a `joint` to sense", key=f"{key}.{field}")
    checks.not_negative(key, reflex, "delay")
    most = checks.interval(reflex.delay)[1] / control_step
    check_size("delay", most, partial(SceneError, key=f"{key}.delay"))
