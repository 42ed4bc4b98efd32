"""Parameters and states of controller and forces on a device; `kernels.force.extensions` says where a step has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import warp as wp

from warpmuscle.core.arrays import rows, structs_to_device, to_device
from warpmuscle.kernels.step import extensions_of
from warpmuscle.model.body_contact import ShapePair, contact_parameters
from warpmuscle.model.controllers.declared import parameters_of, parameters_of_each
from warpmuscle.model.expressions.programs import expression_tables
from warpmuscle.model.objects.arrays import put_numbers, put_places
from warpmuscle.model.structure import Structure
from warpmuscle.model.water.arrays import put_water
from warpmuscle.scene import Scene


def extensions_struct(structure: Structure, instances: int, device: Any) -> Any:
    """The last argument of the fused kernel, without parameters, for so many instances whose states are zero."""
    s = extensions_of(structure.controller, structure.force_kinds)()
    floats = structure.controller.custom.memory(len(structure.names.bodies))
    if floats:
        s.first.memory = wp.zeros((instances, 1, floats), dtype=float, device=device)
    part = s.rest
    for entries in structure.forces:
        if entries.objects is not None:
            put_places(part.first, entries.objects, instances, device)
        elif entries.kind.touch is not None:
            part.first.first, part.first.second = (
                to_device(bodies, int, device) for bodies in zip(*entries.ends, strict=True)
            )
        else:
            part.first.start = to_device(entries.start, int, device)
        if entries.kind.pair is not None:
            part.first.other = to_device(entries.other, int, device)
            part.first.second = to_device(entries.second, int, device)
        if entries.kind.state:
            shape = (instances, len(entries.names), entries.kind.state)
            part.first.memory = wp.zeros(shape, dtype=float, device=device)
        part = part.rest
    return s


def put_parameters(extensions: Any, scene: Scene, structure: Structure, device: Any) -> None:
    """Let that argument have the parameters of a scene of numbers, see `scene.parameters.substitute`."""
    put_of_controller(extensions, scene, structure, device)
    part = extensions.rest
    starts = expression_tables(scene).starts
    for entries in structure.forces:
        if entries.objects is not None:
            put_numbers(part.first, scene, structure.names, device)
        elif entries.kind.water:
            put_water(part.first, scene, structure.names, device)
        else:
            given: list[Mapping[str, Any]] = [
                contact_parameters(scene, name)
                if isinstance(name, ShapePair)
                else {**scene.forces[name].parameters, **starts.get(name, {})}
                for name in entries.names
            ]
            _put(part.first, entries.kind.parameters, given, device)
        part = part.rest


def put_of_controller(extensions: Any, scene: Scene, structure: Structure, device: Any) -> None:
    """Let that argument have the parameters of the controller in a scene of numbers."""
    custom = structure.controller.custom
    own, defaults = extensions.first, dict(custom.defaults)
    _put(own, custom.parameters, [parameters_of(scene, defaults)], device)
    whose = {
        "by_joint": ("", *structure.names.joints), "by_body": structure.names.bodies,
        "by_muscle": structure.actuation.muscles or ("",),
    }  # fmt: skip
    for place, names in whose.items():
        struct = getattr(custom, place)
        if struct is not None:
            _put(own, struct, list(parameters_of_each(scene, place, names, struct, defaults)), device, place)


def _put(
    extension: Any, struct: Any, entries: Sequence[Mapping[str, Any]], device: Any, field: str = "parameters"
) -> None:
    """Let an extension have the parameters of its entries, as an array (rows, entries) of their structure."""
    if struct is not None:
        columns = {name: rows([entry[name] for entry in entries]) for name in struct.vars}
        setattr(extension, field, structs_to_device(struct, columns, device))
