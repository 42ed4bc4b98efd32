"""Work that devices do on the body over a stride, from the powers that a recording has of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.force import power_name
from warpmuscle.scene.masses import body_mass

WORK, POSITIVE = "work of ", "positive work of "  # before the name of a device
UNIT = "J/kg a stride"


def device_powers(recording: Recording, devices: Iterable[str]) -> dict[str, Floats]:
    """Powers (F,), W, of those forces of a scene that are devices, positive where they give energy to the body."""
    names = list(recording.recorded_names)
    places = {device: power_name(device) for device in devices}
    return {one: recording.recorded[:, names.index(name)] for one, name in places.items() if name in names}


def device_work(steady: Recording, scene: Scene, cadence: float | None) -> dict[str, float | None]:
    """Net and positive work of each device, J a stride over the mass of the body, as measures by name.

    Args:
        steady: the part of a motion that counts. scene: without free parameters.
        cadence: steps/min; None if there are no steps.
    """
    if not scene.forces or steady.frames == 0 or not cadence:
        return {}
    stride, mass = 120.0 / cadence, body_mass(scene.character)
    found: dict[str, float | None] = {}
    for device, power in device_powers(steady, scene.forces).items():
        found[WORK + device] = float(power.mean()) * stride / mass
        found[POSITIVE + device] = float(np.maximum(power, 0.0).mean()) * stride / mass
    return found
