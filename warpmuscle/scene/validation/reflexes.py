"""What the types of a scene cannot say about muscle reflexes."""

from __future__ import annotations

from collections.abc import Collection

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Reflex, Reflexes
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.reflexes import OF_MUSCLES
from warpmuscle.scene.validation.checks import Checks, known

SIDES = "lr"
WITH_RATES = ("length", "lean", "angle")


def check_reflexes(checks: Checks, key: str, reflexes: Reflexes) -> None:
    """Check the reflexes of a scene whose character is sound.

    Raises:
        SceneError: the first thing wrong, with its key, such as `controller.reflexes.muscles.SOL.force.of`.
    """
    character = checks.checked.character
    known(reflexes.trunk, character.bodies, "body", f"{key}.trunk")
    pairs = _on_both_sides(character.muscles)
    for name, own in reflexes.muscles.items():
        place = f"{key}.muscles.{name}"
        known(name, pairs, "muscle of both legs (without its l or r)", place)
        if not own:
            raise SceneError("a muscle with reflexes needs at least one; leave it out, or add one", key=place)
        for what, reflex in own.items():
            _reflex(checks, f"{place}.{what}", reflex, pairs)


def _reflex(checks: Checks, key: str, reflex: Reflex, pairs: list[str]) -> None:
    """A reflex senses something that there is, and looks ahead only where there is a rate."""
    character = checks.checked.character
    if reflex.signal == "angle":
        if not reflex.of:
            raise SceneError("an angle needs the joint that it is `of`", key=f"{key}.of")
        known(reflex.of, _on_both_sides(character.joints), "joint of both legs (without its l or r)", f"{key}.of")
        for side in SIDES:
            kind = joint_type(character.joints[side + reflex.of])
            if not kind.scalars:
                raise SceneError(f"a {kind.name} joint has no angle for a reflex", key=f"{key}.of")
    elif reflex.signal in OF_MUSCLES:
        if reflex.of:
            known(reflex.of, pairs, "muscle of both legs (without its l or r)", f"{key}.of")
    elif reflex.of:
        raise SceneError(f"the signal {reflex.signal!r} is not of a muscle or joint; leave `of` out", key=f"{key}.of")
    if reflex.signal not in WITH_RATES:
        least, greatest = checks.interval(reflex.lead)
        if least != 0.0 or greatest != 0.0:
            raise SceneError(f"the signal {reflex.signal!r} has no rate to look ahead by", key=f"{key}.lead")
        if reflex.moving != "either":
            raise SceneError(f"the signal {reflex.signal!r} has no rate; leave it out", key=f"{key}.moving")


def _on_both_sides(names: Collection[str]) -> list[str]:
    """Names without their first letter of what there is with both l and r."""
    found = set(names)
    return [name[1:] for name in names if name[:1] == SIDES[0] and SIDES[1] + name[1:] in found]
