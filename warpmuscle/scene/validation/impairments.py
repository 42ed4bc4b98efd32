"""What the types of a scene cannot say about impairments."""

from __future__ import annotations

from msgspec.structs import replace

from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Impairment, Scene
from warpmuscle.scene.impairments.impaired import impaired_muscles, impaired_number
from warpmuscle.scene.impairments.part import FACTORS
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.checks import Checks, near
from warpmuscle.scene.validation.muscles import check_muscles


def check_impairments(checks: Checks) -> None:
    """Every impairment is of muscles that have what it changes, and leaves sound ones whatever a search does.

    Raises:
        SceneError: the first thing wrong, with its key, such as `impairments.weak.muscles.0`.
    """
    scene = checks.checked
    if not scene.impairments:
        return
    for name, impairment in scene.impairments.items():
        _impairment(checks, f"impairments.{name}", impairment)
    for end in (0, 1):
        _sound(checks, end)


def _impairment(checks: Checks, key: str, impairment: Impairment) -> None:
    muscles = checks.checked.character.muscles
    if not impairment.muscles:
        raise SceneError('names no muscles; "*" are all', key=f"{key}.muscles")
    for index, pattern in enumerate(impairment.muscles):
        if not impaired_muscles(replace(impairment, muscles=[pattern]), muscles):
            raise SceneError(f"no muscle is called {pattern!r}{near(pattern, muscles)}", key=f"{key}.muscles.{index}")
    for field in FACTORS:
        if getattr(impairment, field) != 1.0:
            _has_number(checks.checked, key, impairment, field)


def _has_number(scene: Scene, key: str, impairment: Impairment, field: str) -> None:
    """Every muscle has a number that the factor of a field can multiply."""
    muscles = scene.character.muscles
    names = impaired_muscles(impairment, muscles)
    numbers = {name: impaired_number(muscles[name], scene.muscle_model, field) for name in names}
    without = [name for name, number in numbers.items() if number is None]
    if without:
        message = f"{without[0]} has no {field} that this could multiply: give muscle_model.{field}"
        raise SceneError(message, key=f"{key}.{field}")
    if field == "delay" and all(number == 0.0 for number in numbers.values()):
        raise SceneError("none of these muscles has a delay that this could multiply", key=f"{key}.{field}")


def _sound(checks: Checks, end: int) -> None:
    """Muscles are sound with all factors at the lower (0) or upper (1) ends of their intervals."""
    scene = checks.checked
    ends = {
        name: replace(one, **{field: checks.interval(getattr(one, field))[end] for field in FACTORS})
        for name, one in scene.impairments.items()
    }
    plain = replace(scene, impairments=ends)
    try:
        sound = Checks(at_start(plain))
        sound.ranges("", sound.checked)
        check_muscles(sound)
    except SceneError as error:
        name = error.key.removeprefix("character.muscles.").partition(".")[0]
        guilty = [key for key, one in ends.items() if impaired_muscles(one, [name])]
        raise SceneError(f"makes {error.key} wrong: {error.message}", f"impairments.{guilty[-1]}") from None
