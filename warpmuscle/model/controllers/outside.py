"""Controllers with what comes from outside the scene in their places: torques, or what a policy wants."""

from __future__ import annotations

from typing import Any

from warpmuscle.kernels.control.control import ControllerKind, given_effort
from warpmuscle.kernels.control.reflex import as_asked


def driven_from_outside(controller: ControllerKind) -> ControllerKind:
    """The controller with efforts that are given from outside in the place of its torques."""
    return moved_by(controller, given_effort, controller.custom.shipped)


def moved_by(controller: ControllerKind, effort: Any, shipped: bool = True) -> ControllerKind:
    """The controller with a Warp function for the efforts of joints, see `control.CustomController`, in their place."""
    return controller._replace(custom=controller.custom._replace(effort=effort, shipped=shipped))


def telling(controller: ControllerKind) -> ControllerKind:
    """The controller, and muscles tell what they feel, in `MuscleState.sensed`."""
    return controller if controller.excites else controller._replace(force=as_asked)
