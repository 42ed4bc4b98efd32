"""What a viewer shows until it has a motion: the scene's first pose, and words about what is being done."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.results.recorded_quantities import NAMED, QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import world_poses
from warpmuscle.scene.masses import center_of_mass
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.topology import topology
from warpmuscle.view.page import page_of
from warpmuscle.view.server import PROTOCOL, Message, PageServer
from warpmuscle.view.track import track_of


class Waiting:
    """A page that is there at once, and gives way to another one at its address.

    Attributes:
        server: of the page; what comes later takes it over.
    """

    def __init__(self, scene: Scene, host: str = "127.0.0.1", port: int = 8080) -> None:
        """Show the first pose of a scene, its free parameters at their start values.

        Raises:
            Error: as `PageServer` does.
        """
        self._words = "preparing"
        self.server = PageServer(host, port, waiting_page(scene).encode())
        self.server.on_open = self._opening

    def _opening(self) -> list[Message]:
        return [json.dumps({"words": self._words})]

    def say(self, words: str) -> None:
        """Say what is being done; the page counts its seconds."""
        self._words = words
        self.server.tell(json.dumps({"words": words}))

    def fail(self, why: str) -> None:
        """Say why there will be no motion, and end."""
        self.server.tell(json.dumps({"failed": why}))
        self.server.stop()


def waiting_page(scene: Scene) -> str:
    """The page of a scene's first pose, which hears from its server when there is more to see."""
    numeric = at_start(scene)
    track = track_of(first_pose(numeric), numeric)
    return page_of([track], [numeric], scene.name, autoplay=False, plots=False, waiting={"protocol": PROTOCOL})


def first_pose(scene: Scene) -> Recording:
    """The initial pose of a scene without free parameters, as a recording of one frame without muscles and forces."""
    names, poses = topology(scene.character), world_poses(scene)
    position, orientation = (np.array([poses[name][part] for name in names.bodies]) for part in (0, 1))
    counts = {"frame": 1, "joint": len(names.joints), "body": len(names.bodies)}
    arrays: dict[str, NDArray[Any]] = {
        name: np.zeros([counts.get(axis, len(axis.split())) for axis in quantity.axes])
        for name, quantity in QUANTITIES.items()
        if not (set(NAMED) - set(counts)) & set(quantity.axes)
    }
    for name, quantity in QUANTITIES.items():
        if quantity.axes[-1] == "x y z w":
            arrays[name][..., 3] = 1.0
    arrays |= {name: np.zeros(1, dtype=np.int32) for name in ("stance", "state")}
    arrays |= {
        "root_position": position[None, 0],
        "root_orientation": orientation[None, 0],
        "body_position": position[None],
        "body_orientation": orientation[None],
        "com": center_of_mass(scene.character, dict(zip(names.bodies, position, strict=True)))[None],
    }
    return Recording.of(arrays, names.joints, names.bodies)
