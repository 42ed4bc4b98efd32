"""Walks of half a second, and what is compared of them."""

import dataclasses

import numpy as np

from warpmuscle.formats import load
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene
from warpmuscle.scene.number import Free
from warpmuscle.scene.parameters import start_values, substitute

# Weights of all terms that a walk on torques has; tests that share them share a kernel.
OF_TORQUES = dict.fromkeys(
    (
        "torque", "speed", "heading", "applied_torque", "ground_force", "norms", "norm_force", "norm_moments",
        "step_width", "stride_speed", "rise",
    ),
    1.0,
)  # fmt: skip


def plain_walk(duration: float = 0.5) -> Scene:
    """The start of a walk, without free numbers."""
    scene = load("fwalk")
    scene = substitute(scene, start_values(scene))
    scene.duration = duration
    return scene


def short_walk(duration: float = 0.5) -> Scene:
    """The same with two free gains."""
    scene = plain_walk(duration)
    scene.controller.pd["lHip"].torque_limit = scene.controller.pd["lKnee"].torque_limit = 1e12
    scene.controller.pd["lHip"].kp = Free(300.0, 1.0, 1e10)
    scene.controller.pd["lKnee"].kp = Free(300.0, 1.0, 1e10)
    return scene


CANDIDATE = np.array([320.0, 290.0])


def candidates(count: int, slot: int) -> np.ndarray:
    """Random gains with the candidate in one slot."""
    values = np.random.default_rng(count).uniform(200.0, 400.0, (count, 2))
    values[slot] = CANDIDATE
    return values


def limp(duration: float = 2.0) -> Scene:
    """A character that falls: it has no gains."""
    scene = plain_walk(duration)
    scene.controller.pd, scene.failure.heading = {}, 0.0
    return scene


def assert_same_bits(a: Recording, b: Recording) -> None:
    for field in dataclasses.fields(Recording):
        np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name))
