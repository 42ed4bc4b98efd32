"""What the types of a scene cannot say about ground that moves along itself."""

from __future__ import annotations

import math

from warpmuscle.core.errors import SceneError
from warpmuscle.core.limits import check_size
from warpmuscle.scene.validation.checks import Checks

FASTEST = 100.0  # m/s


def check_treadmill(checks: Checks) -> None:
    """Check how fast belts are, and the profile of their speeds.

    Raises:
        SceneError: a number out of its range, or a scene that cannot take a treadmill.
    """
    scene, key = checks.checked, "ground.treadmill"
    treadmill = scene.ground.treadmill
    if treadmill is None:
        return
    if scene.ground.terrain is not None:
        raise SceneError("belts are flat; leave out either terrain or treadmill", key)
    if scene.learning is not None:
        raise SceneError("policies learn on ground that stands still; leave the treadmill out", key)
    if not checks.start(scene.ground.normal[1]) > 0.0:
        raise SceneError("belts run on a plane whose normal points upwards", "ground.normal")
    for name in ("speed", "left", "right", "sideways"):
        low, high = checks.interval(getattr(treadmill, name))
        if max(-low, high) > FASTEST:
            raise SceneError(f"belts run at {FASTEST:g} m/s at most", f"{key}.{name}")
    check_size("profile", len(treadmill.profile), lambda text: SceneError(text, f"{key}.profile"))
    for number, pair in enumerate(treadmill.profile):
        if not all(map(math.isfinite, pair)) or abs(pair[1]) > FASTEST:
            message = f"is a time, s, and a factor of {FASTEST:g} at most, not {pair[0]:g} and {pair[1]:g}"
            raise SceneError(message, f"{key}.profile.{number}")
    checks.increasing(f"{key}.profile", [time for time, _ in treadmill.profile], "times of the profile")
