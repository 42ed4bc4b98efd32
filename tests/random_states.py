"""Random states of characters, for tests of what is computed from states.

Joints are in breadth-first order from the root, bodies are the root followed by the joints' children; quaternions xyzw.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from biped import breadth_first, multiply, rotate
from warpmuscle.scene import Character


@dataclass(frozen=True)
class States:
    """N states of a character with J joints."""

    root_position: np.ndarray  # (N, 3) m, world
    root_orientation: np.ndarray  # (N, 4)
    root_velocity: np.ndarray  # (N, 3) m/s, world
    root_angular_velocity: np.ndarray  # (N, 3) rad/s, world
    joint_orientation: np.ndarray  # (N, J, 4) child to parent
    joint_angular_velocity: np.ndarray  # (N, J, 3) rad/s, child relative to parent, in the parent's frame

    def __getitem__(self, index: slice | np.ndarray) -> States:
        return States(*(getattr(self, field.name)[index] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.root_position)


def body_order(character: Character) -> list[str]:
    """Names of the bodies: the root, then the children of the joints."""
    return [character.root, *(character.joints[name].child for name in breadth_first(character))]


def random_states(character: Character, count: int, seed: int = 0, speed: float = 3.0) -> States:
    """States all over the place but with joints moving as they can: speeds are normal with this deviation."""
    rng = np.random.default_rng(seed)
    names = breadth_first(character)
    orientation, velocity = np.empty((count, len(names), 4)), np.empty((count, len(names), 3))
    for place, name in enumerate(names):
        joint = character.joints[name]
        if joint.type == "ball":
            orientation[:, place] = unit(rng.normal([0.0, 0.0, 0.0, 3.0], size=(count, 4)))
            velocity[:, place] = rng.normal(size=(count, 3)) * speed
            continue
        orientation[:, place], velocity[:, place] = [0.0, 0.0, 0.0, 1.0], 0.0
        for raw in joint.axes:  # innermost first
            axis, angle, rate = unit(np.array(raw)), rng.uniform(-1.0, 1.0, count), rng.normal(size=count) * speed
            turned = turn(axis, angle)
            orientation[:, place] = multiply(turned, orientation[:, place])
            velocity[:, place] = rotate(turned, velocity[:, place]) + rate[:, None] * axis
    root = _random_root(character, count, rng, speed)
    return States(*root, orientation, velocity)


def _random_root(character: Character, count: int, rng: np.random.Generator, speed: float) -> tuple[np.ndarray, ...]:
    """Random pose and velocities of the root, as far as its joint allows."""
    if character.root_joint == "free":
        return (
            rng.normal(size=(count, 3)),
            unit(rng.normal(size=(count, 4))),
            rng.normal(size=(count, 3)) * speed,
            rng.normal(size=(count, 3)) * speed,
        )
    x, yz = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 1.0])
    moves = float(character.root_joint == "planar")
    return (
        moves * yz * rng.normal(size=(count, 3)),
        turn(x, moves * rng.uniform(-1.0, 1.0, count)),
        moves * yz * speed * rng.normal(size=(count, 3)),
        moves * x * speed * rng.normal(size=(count, 3)),
    )


def turn(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Quaternions (N, 4) of turns by angles (N,) about a unit axis (3,)."""
    half = 0.5 * np.asarray(angle)[:, None]
    return np.concatenate([np.sin(half) * axis, np.cos(half)], axis=1)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
