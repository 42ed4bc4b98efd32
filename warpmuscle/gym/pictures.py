"""Pictures of a body as it stands, for environments that are watched."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.errors import Error
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.video.camera import Camera
from warpmuscle.video.film import Look, make_film
from warpmuscle.video.painter import Painter
from warpmuscle.video.triangles import Triangles

LOOK = Look(width=640, height=480, caption=False)
LENGTH = 0.5  # s, that room is made for; longer than delays of muscles
STEPS = 2  # that a picture takes, since a film has two frames at least


class Pictures:
    """Draws states of a batch as frames (480, 640, 3); the camera stays as far away as it was at first."""

    def __init__(self, rollout: Rollout) -> None:
        """Prepare to draw instances of a batch, in a batch of one that is put to where they are."""
        scene = msgspec.structs.replace(rollout.scene, duration=min(rollout.scene.duration, LENGTH), learning=None)
        rate = 1.0 / scene.time_step
        self._one = Rollout(scene, 1, str(rollout.device), record=[0], record_rate=rate, threads=1)
        self._camera: Camera | None = None
        self._figure: Triangles | None = None
        self._last: NDArray[np.uint8] = np.zeros((LOOK.height, LOOK.width, 3), dtype=np.uint8)

    def of(self, rollout: Rollout, instance: int = 0) -> NDArray[np.uint8]:
        """An instance as it stands now; the last picture where numbers have left all bounds."""
        state, one = rollout.state, self._one
        coordinates, speeds = (a.numpy()[instance : instance + 1] for a in (state.coordinates, state.speeds))
        activation: Any = None
        if rollout.excitable:
            activation = np.zeros((1, len(rollout.muscle_names)))
            columns = [rollout.muscle_names.index(name) for name in rollout.structure.actuation.muscles]
            activation[:, columns] = state.muscles.activation.numpy()[instance]
        try:
            one.set_initial(coordinates, speeds, activation)
            self._step(activation)
            film = make_film(one.recording(), one.scene, LOOK, figure=self._figure)
        except Error:
            return self._last
        self._camera, self._figure = self._camera or film.camera, film.figure
        self._last = Painter(replace(film, camera=self._camera)).frame(0)
        return self._last

    def _step(self, activation: Any) -> None:
        """Make the steps, with the kernel that environments use."""
        if activation is not None:
            self._one.step(STEPS, excitations=activation)
        else:
            self._one.step(STEPS, torques=np.zeros((1, len(self._one.torque_names))))
