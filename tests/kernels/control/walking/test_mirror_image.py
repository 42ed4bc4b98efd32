"""The walking controller does for a body's mirror image what it does for the body, mirrored."""

from __future__ import annotations

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.scene.joints.symmetry import counterpart
from warpmuscle.simulation.rollout import Rollout

VECTOR, TURN = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0])  # signs of images across the plane x = 0
ROOT, ROOT_SPEED = np.r_[VECTOR, TURN, 1.0], np.r_[VECTOR, TURN]
SIGNS = {int(places.HEADING): -1.0, int(places.FOOTHOLD): -1.0, int(places.LIFTED): -1.0}


def image_of_numbers(values: np.ndarray, names: tuple[str, ...], table: dict, root: np.ndarray) -> np.ndarray:
    """Of coordinates or speeds (N,) with these names, of which the root's stand first."""
    mirrored = np.r_[root * values[: len(root)], np.zeros(len(values) - len(root))]
    for k, name in enumerate(names[len(root) :], len(root)):
        other, sign = table[name]
        mirrored[k] = sign * values[names.index(other)]
    return mirrored


def image_of_memory(memory: np.ndarray, bodies: tuple[str, ...]) -> np.ndarray:
    """Of the controller's memory (floats,): legs change places, x changes its sign, torques turn as spins do."""
    mirrored = memory.copy()
    for place, sign in SIGNS.items():
        mirrored[place] *= sign
    stance, load = int(places.STANCE), int(places.LOAD)
    if memory[stance] != float(places.STANDS):
        mirrored[stance] = 1.0 - memory[stance]
    mirrored[load : load + 2] = memory[load : load + 2][::-1]
    of_body = memory[places.STATE : places.STATE + places.OF_BODY * len(bodies)].reshape(len(bodies), -1)
    order = [bodies.index(counterpart(name, bodies) or name) for name in bodies]
    of_image = of_body[order] * np.r_[TURN, 1.0, VECTOR, np.ones(3)]  # dampings are the same
    mirrored[places.STATE : places.STATE + of_image.size] = of_image.ravel()
    return mirrored


class Pair:
    """A body that walks and turns, beside what is put in the place of its mirror image."""

    def __init__(self, speed: float) -> None:
        self.rollout = Rollout(load("steer"), 2, "cpu")
        self.rollout.set_commands({"speed": speed, "heading": [0.4, -0.4]})
        self.body = BodySymmetry(self.rollout)
        self.floats = self.rollout._extensions.struct.first.memory  # (instances, 1, floats) of the controller

    @property
    def memory(self) -> np.ndarray:
        return self.floats.numpy()[:, 0]

    def images(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates, speeds and memory of the first one's image."""
        rollout, names = self.rollout, self.rollout.names.bodies
        q, v = rollout.state.coordinates.numpy()[0], rollout.state.speeds.numpy()[0]
        return (
            image_of_numbers(q, rollout.coordinate_names, self.body.coordinates, ROOT),
            image_of_numbers(v, rollout.speed_names, self.body.speeds, ROOT_SPEED),
            image_of_memory(self.memory[0], names),
        )

    def mirror(self) -> None:
        """Let the second one be the image of the first one."""
        state = self.rollout.state
        for array, image in zip((state.coordinates, state.speeds), self.images()[:2], strict=True):
            values = array.numpy()
            values[1] = image
            array.assign(values)
        memory, force = self.floats.numpy(), state.foot_force.numpy()
        memory[1, 0] = self.images()[2]
        force[1] = force[0, ::-1] * VECTOR
        self.floats.assign(memory)
        state.foot_force.assign(force)


@pytest.mark.parametrize(
    ("speed", "time", "stance"), [(0.0, 0.15, "STANDS"), (0.9, 1.31, "RIGHT"), (0.9, 1.55, "LEFT")]
)
def test_torques_of_the_image_are_those_of_the_body_mirrored(speed: float, time: float, stance: str):
    """In the step after; a body that begins to walk is left out, for its right leg always goes first."""
    pair = Pair(speed)
    pair.rollout.run(time)
    pair.mirror()
    assert pair.memory[0][int(places.STANCE)] == {"LEFT": 0.0, "RIGHT": 1.0, "STANDS": 2.0}[stance]
    assert np.abs(pair.memory[1] - pair.memory[0]).max() > 10.0
    pair.rollout.run(pair.rollout.scene.time_step)
    coordinates, speeds, memory = pair.images()
    np.testing.assert_allclose(pair.memory[1], memory, rtol=1e-4, atol=5e-3)
    np.testing.assert_allclose(pair.rollout.state.coordinates.numpy()[1], coordinates, atol=1e-4)
    np.testing.assert_allclose(pair.rollout.state.speeds.numpy()[1], speeds, atol=0.05)  # forces of contact are stiff
