"""What the page is sent of ground that is not flat: a mesh below each biped, in its lane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Ground
from warpmuscle.scene.terrain.mesh import MOST, in_world, mesh_of
from warpmuscle.scene.terrain.surface import surface

AROUND = 12.0  # m beyond where the centre of mass is, that the ground is seen
ANYWHERE = (12.0, 24.0)  # m about the origin along x and z, where it is not known yet where a biped will go
FEW = 4  # bipeds, each of which stands on fine ground
DIGITS = 4  # of a height, m


def terrain_content(
    grounds: Sequence[Ground],
    motions: Sequence[Recording] | None = None,
    offsets: Sequence[Floats] = (),
    width: float = 0.0,
) -> list[dict[str, Any]]:
    """Meshes of the grounds that are not flat, each with how far it is drawn from its place, m.

    Args:
        motions: of the bipeds on them; none: they may go anywhere. offsets: (3,) where bipeds are drawn, m.
        width: m, of a lane; 0: there is one only.
    """
    found = []
    for number, ground in enumerate(grounds):
        surrounding = surface(ground)
        if surrounding.lie is None:
            continue
        com = np.zeros((1, 3)) if motions is None else motions[number].com.astype(float)
        beside = np.array([0.5 * width if width else AROUND, AROUND]) if motions is not None else np.array(ANYWHERE)
        places = com[np.isfinite(com).all(axis=1)][:, [0, 2]]
        places = places if len(places) else np.zeros((1, 2))
        most = MOST if len(grounds) <= FEW else MOST // 4
        mesh = mesh_of(surrounding.lie, places.min(axis=0) - beside, places.max(axis=0) + beside, most)
        points = in_world(surrounding.lie, mesh, surrounding)
        offset = [0.0, 0.0, 0.0] if not len(offsets) else np.asarray(offsets[number]).tolist()
        shape = [len(mesh.z), len(mesh.x)]
        found.append({"shape": shape, "points": np.round(points, DIGITS).ravel().tolist(), "offset": offset})
    return found
