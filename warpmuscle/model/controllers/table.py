"""All controllers, and what is made of those that a scene has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import warp as wp

from warpmuscle.kernels.control.control import NO_CONTROLLER, ControllerKind
from warpmuscle.kernels.control.reflex import added_reflex_force, reflex_force, reflex_stage
from warpmuscle.model.controllers import gait_states, simbicon
from warpmuscle.model.controllers.declared import declared_controller, has_declared
from warpmuscle.model.controllers.entry import Entry, Zeros
from warpmuscle.model.controllers.reflexes import has_reflexes
from warpmuscle.scene import Scene
from warpmuscle.scene.topology import Topology


def _reflex_force(scene: Scene) -> Any:
    """The Warp function of the force that reflexes want of a muscle."""
    controller = scene.simbicon
    besides = controller is not None and controller.reflexes is not None and controller.reflexes.besides
    return added_reflex_force if besides else reflex_force


# In the order in which they are put together: a later one may replace what one before does.
TABLE = (
    Entry(
        "simbicon",
        applies=lambda scene, muscles: scene.simbicon is not None,
        compiled=lambda before, scene: simbicon.compiled(scene),
        fields=simbicon.model_fields,
        state=simbicon.state_arrays,
        start=simbicon.start_values,
        recorded=("simbicon.phase", "simbicon.stance", "simbicon.machine_state"),
    ),
    Entry(
        "reflexes",
        applies=has_reflexes,
        compiled=lambda before, scene: before._replace(sense=reflex_stage, force=_reflex_force(scene)),
    ),
    Entry(
        "gait states",
        applies=gait_states.has_gait_states,
        compiled=gait_states.compiled,
        state=gait_states.state_arrays,
    ),
    Entry(  # by type, from a module of the user's or of `kernels`
        "declared",
        applies=lambda scene, muscles: has_declared(scene),
        compiled=lambda before, scene: before._replace(custom=declared_controller(scene)),
    ),
)


def entries_of(scene: Scene, muscles: Sequence[str] = ()) -> tuple[Entry, ...]:
    """Those that a scene with these simulated muscles has."""
    return tuple(entry for entry in TABLE if entry.applies(scene, muscles))


def compiled_controller(scene: Scene, muscles: Sequence[str]) -> ControllerKind:
    """What a step has compiled in of the controllers of a scene with these simulated muscles.

    Raises:
        SceneError: the scene names a controller of its own that cannot be used.
    """
    controller = NO_CONTROLLER
    for entry in entries_of(scene, muscles):
        controller = entry.compiled(controller, scene)
    return controller


def controller_fields(scene: Scene, names: Topology, device: Any) -> dict[str, Any]:
    """Parts of the model that are of controllers, by place in `kernels.structs.Model`."""
    found: dict[str, Any] = {}
    for entry in entries_of(scene):
        found |= entry.fields(scene, names, device)
    return found


def controller_state(scene: Scene, instances: int, names: Topology, zeros: Zeros) -> dict[str, wp.array]:
    """Room for the states of controllers, by place in `kernels.structs.State`."""
    found: dict[str, wp.array] = {}
    for entry in entries_of(scene):
        found |= entry.state(scene, instances, names, zeros)
    return found


def controller_start(scene: Scene) -> dict[str, int]:
    """What of these starts at anything but 0, by place."""
    found: dict[str, int] = {}
    for entry in entries_of(scene):
        found |= entry.start(scene)
    return found


def recorded_places(controller: ControllerKind) -> tuple[str, ...]:
    """Places in `kernels.structs.Record` that a compiled controller writes, but for the memory of a declared one."""
    return TABLE[0].recorded if controller.record is not None else ()
