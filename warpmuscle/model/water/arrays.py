"""Water of a scene: which capsules are in it, and their arrays on a device."""

from __future__ import annotations

from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.arrays import rows, starts, structs_to_device
from warpmuscle.core.pose import normalized, rotate
from warpmuscle.kernels.water.section import SECTIONS
from warpmuscle.kernels.water_structs import WaterRow
from warpmuscle.model.bodies import stacked
from warpmuscle.model.collisions import capsule_of
from warpmuscle.model.objects.arrays import joint_in_body
from warpmuscle.scene import Scene, Water
from warpmuscle.scene.topology import Topology
from warpmuscle.scene.water.capsules import WaterCapsule, added_mass, by_mass, capsule_volume


def part_starts(scene: Scene, names: Topology) -> tuple[int, ...]:
    """(bodies + 1,) first capsule of each body among all that are in water."""
    water, bodies = scene.water, scene.character.bodies
    assert water is not None
    return tuple(starts(len(bodies[name].shapes) if water.volume == "shapes" else 1 for name in names.bodies))


def put_water(extension: Any, scene: Scene, names: Topology, device: Any) -> None:
    """Let an extension have the numbers of a scene whose numbers are floats, or (n,) arrays."""
    assert scene.water is not None
    found = [_columns(scene, names, name, capsule) for name in names.bodies for capsule in _capsules(scene, name)]
    columns = {field: stacked([one[field] for one in found]) for field in found[0]}
    flat = {field: values[..., 0] if values.shape[-1] == 1 else values for field, values in columns.items()}
    extension.row = structs_to_device(WaterRow, flat, device)


def _capsules(scene: Scene, name: str) -> list[WaterCapsule]:
    """Those of a body."""
    water, body = scene.water, scene.character.bodies[name]
    assert water is not None
    if water.volume == "mass":
        mass, inertia = rows([body.mass])[:, 0], rows(list(body.inertia))
        capsule = by_mass(mass, inertia, rows([water.body_density])[:, 0])
        if body.inertia_axes is not None:
            turn = normalized(rows(list(body.inertia_axes)))
            capsule = capsule._replace(half=rotate(turn, capsule.half))
        return [capsule]
    found = []
    for middle, half, radius in map(capsule_of, body.shapes):
        length = np.linalg.norm(half, axis=1)
        along = np.where(length[:, None] > 0.0, half / np.maximum(length, 1e-12)[:, None], [0.0, 1.0, 0.0])
        reach, radius = np.broadcast_arrays(length + radius, radius)
        found.append(WaterCapsule(middle, along * reach[:, None], radius, capsule_volume(reach, radius)))
    return found


def _columns(scene: Scene, names: Topology, name: str, capsule: WaterCapsule) -> dict[str, Floats]:
    """`kernels.water_structs.WaterRow` of a capsule of a body by field, (rows, numbers) each."""
    water = scene.water
    assert isinstance(water, Water)
    half_length = np.linalg.norm(capsule.half, axis=1)[:, None]
    radius = capsule.radius[:, None]
    along, across = added_mass(half_length, radius)
    ball = radius > 0.999 * half_length  # which is as wide along any axis
    drag, axial, factor = rows([water.drag]), rows([water.axial_drag]), rows([water.added_mass])
    end = np.pi * radius**2
    return {
        "middle": capsule.middle - joint_in_body(scene, names, name), "half": capsule.half,
        "reach": half_length, "radius": radius,
        "volume": capsule.volume[:, None], "share": 1.0 / _squares(half_length, radius),
        "level": rows([water.level]), "density": rows([water.density]),
        "across": drag * (end + 4.0 * radius * (half_length - radius)), "along": np.where(ball, drag, axial) * end,
        "added_across": factor * across, "added_along": factor * along,
        "current": rows([water.current]) * np.array([0.0, 0.0, 1.0]),
    }  # fmt: skip


def _squares(half_length: Floats, radius: Floats) -> Floats:
    """Sum of the squared radii of all sections, m^2, as `kernels.water.section.squared_radius` has them."""
    places = (np.arange(SECTIONS) + 0.5) * (2.0 / SECTIONS) - 1.0
    into_end = np.maximum(np.abs(places * half_length) - (half_length - radius), 0.0)
    return np.asarray(np.maximum(radius**2 - into_end**2, 0.0).sum(axis=1, keepdims=True))
