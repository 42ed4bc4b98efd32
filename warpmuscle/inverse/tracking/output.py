"""What tracking found as named arrays of a file, and as columns with the names of OpenSim's CMC."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.inverse.named_array import NamedArray
from warpmuscle.inverse.tracking.tracked import Tracked


def tracked_arrays(one: Tracked) -> list[NamedArray]:
    """Arrays over the times between windows, and over windows."""
    generalised, between, windows = "N m or N", "tracking_time", "window_time"
    ground = []
    if one.ground is not None:
        axes = "foot", "ground_axis"
        ground = [
            NamedArray("ground_force", axes, "N", one.ground.force, "of the simulated ground on a foot", windows),
            NamedArray("ground_force_of_plates", axes, "N", one.ground.plates, "of the plates then", windows),
            NamedArray("lift", (), "m", one.ground.lift, "of the root, onto the ground", between),
        ]
    return [
        *ground,
        NamedArray("tracked_value", ("coordinate",), "rad or m", one.values, "of the simulation", between),
        NamedArray("tracking_error", ("coordinate",), "rad or m", one.error, "simulated less recorded", between),
        NamedArray("tracked_activation", ("muscle",), "1", one.activation, "of the simulation", between),
        NamedArray(
            "excitation", ("muscle",), "1", one.excitation, "that the simulation follows, a window long", windows
        ),
        NamedArray("tracked_force", ("muscle",), "N", one.force, "along the tendon, as the window ends", windows),
        NamedArray("tracking_effort", ("coordinate",), generalised, one.effort, "that acted beside muscles", windows),
        NamedArray("tracking_lack", ("coordinate",), generalised, one.lacking, "that muscles could not make", windows),
        NamedArray("tracking_iterations", (), "1", one.iterations, "-1 where moments were not balanced", windows),
    ]


def tracked_storages(one: Tracked) -> dict[str, tuple[str, dict[str, Any]]]:
    """Titles and columns by the ending of files' names; angles in rad, as `.sto` files here have them."""

    def columns(times: Any, names: tuple[str, ...], values: Any) -> dict[str, Any]:
        return {"time": times} | dict(zip(names, np.asarray(values).T, strict=True))

    efforts = tuple(
        f"{name}_{'residual' if k < one.residuals else 'reserve'}" for k, name in enumerate(one.names)
    )  # fmt: skip
    return {
        "CMC_controls": ("controls", columns(one.times[:-1], one.muscles, one.excitation)),
        "CMC_activation": ("activations", columns(one.times, one.muscles, one.activation)),
        "CMC_Kinematics_q": ("Coordinates", columns(one.times, one.names, one.values)),
        "CMC_pErr": ("errors", columns(one.times, one.names, one.error)),
        "CMC_Actuation_force": (
            "Actuator forces",
            columns(one.times[1:], one.muscles, one.force) | dict(zip(efforts, one.effort.T, strict=True)),
        ),
    }
