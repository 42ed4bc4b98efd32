"""Results made by hand, for tests to draw and to report: a walk on muscles, and a search."""

import dataclasses
from functools import cache

import msgspec
import numpy as np

from biped import breadth_first, forward_kinematics, random_recording
from muscle_arm import arm
from warpmuscle.formats import load, toml
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import (
    Evaluations,
    History,
    ParameterTable,
    Result,
    Searched,
    SearchOptions,
    best_of,
    parameter_table,
)
from warpmuscle.scene import Character, Objective, Scene
from warpmuscle.scene.parameters import free_parameters
from warpmuscle.scene.topology import topology

STRIDE = 1.0  # s


def march(character: Character, speed: float, duration: float = 2.0, frames: int = 101, muscles: int = 0) -> Recording:
    """The biped in its reference pose, legs swinging, moved at constant speed, a step every 0.5 s."""
    scene, rng = character, random_recording(frames, joints=14, muscles=muscles)
    joints = breadth_first(scene)
    time = np.linspace(0.0, duration, frames)
    position = np.stack([0.0 * time, 0.0 * time + 1.03, speed * time], axis=1)
    upright = np.tile([0.0, 0.0, 0.0, 1.0], (frames, 1))
    orientation = np.tile(upright[:, None], (1, 14, 1))
    for name, sign in (("lHip", 1.0), ("rHip", -1.0)):
        half = 0.15 * sign * np.sin(2.0 * np.pi * time / STRIDE)
        orientation[:, joints.index(name), 0], orientation[:, joints.index(name), 3] = np.sin(half), np.cos(half)
    poses = forward_kinematics(scene, position, upright, dict(zip(joints, np.moveaxis(orientation, 1, 0), strict=True)))
    arrays = {name: rng[name] for name in QUANTITIES} | {
        "time": time, "stance": (time // 0.5).astype(int) % 2, "root_position": position, "com": position,
        "foot_force_left": footfalls(time, 0.0), "foot_force_right": footfalls(time, 0.5 * STRIDE),
        "root_orientation": upright, "joint_orientation": orientation,
        "body_position": np.stack([pose[0] for pose in poses.values()], axis=1),
        "body_orientation": np.stack([pose[1] for pose in poses.values()], axis=1),
    }  # fmt: skip
    return Recording.of(arrays, tuple(joints), tuple(poses), tuple(getattr(character, "muscles", {}))[:muscles])


def footfalls(time: np.ndarray, first: float, stance: float = 0.6) -> np.ndarray:
    """Forces (F, 3), N, on a foot that is on the ground for this part of every stride, from a time on."""
    loaded = (time - first) % STRIDE < stance * STRIDE - 1e-9
    return np.stack([0.0 * time, 350.0 / stance * loaded, 0.0 * time], axis=1)


@cache
def walk_scene(name: str = "walk56") -> Scene:
    """A shipped scene, with two terms in its objective."""
    return msgspec.structs.replace(load(name), objective=Objective(torque=1.0, speed=5.0))


def walk_result(name: str = "walk56") -> Result:
    """A motion of a shipped scene, four strides of 1 s long."""
    scene = walk_scene(name)
    motion = march(scene.character, 1.1, 4.0, 401, len(scene.character.muscles))
    table = parameter_table(free_parameters(scene))
    return Result(toml.dumps(scene), "cpu", "warpmuscle simulate", 0, table, replays=(motion,))


def with_arrays(motion: Recording, **arrays: np.ndarray) -> Recording:
    """The motion with other arrays."""
    return dataclasses.replace(motion, **arrays)


def arm_motion(frames: int = 20) -> Recording:
    """A motion of `muscle_arm.arm`: its forearm turns; muscles are random numbers."""
    scene = arm()
    names = topology(scene.character)
    whole = random_recording(frames, joints=len(names.joints), muscles=len(scene.character.muscles))
    time = np.linspace(0.0, 1.0, frames)
    turn = np.zeros((frames, len(names.joints), 4))
    turn[..., 0], turn[..., 3] = np.sin(0.5 * time)[:, None], np.cos(0.5 * time)[:, None]
    bodies = np.tile([0.0, 0.0, 0.0, 1.0], (frames, len(names.bodies), 1))
    bodies[:, 1:] = turn
    arrays = {name: whole[name] for name in QUANTITIES} | {
        "time": time, "joint_orientation": turn, "body_orientation": bodies, "com": np.zeros((frames, 3)),
        "body_position": np.zeros((frames, len(names.bodies), 3)),
    }  # fmt: skip
    return Recording.of(arrays, names.joints, names.bodies, tuple(scene.character.muscles))


def search_result(name: str = "walk56", count: int = 60) -> Result:
    """The same with a search of two searches that came down from 100 to 1, some candidates failed."""
    walk, rng = walk_result(name), np.random.default_rng(3)
    table, generation = walk.parameters, np.arange(count) // 10
    cost = 100.0 * np.exp(-5.0 * np.arange(count) / count) * rng.uniform(1.0, 1.5, count)
    cost[::7] = 2.0e6
    params = rng.uniform(table.min, table.max, (count, len(table.name)))
    terms = np.stack([0.5 * cost, 0.1 * cost], axis=1)
    evaluations = Evaluations(
        params, cost, np.where(cost > 1e6, 1, 0), np.full(count, 4.0), np.arange(count) // 5 % 2, generation,
        np.zeros(count, dtype=int), terms, ("torque", "speed"),
    )  # fmt: skip
    numbers = np.repeat(np.arange(6), 2)
    ones = np.ones(12)
    history = History(numbers, np.tile([0, 1], 6), ones, ones, 0.3 / (1.0 + numbers), ones, numbers, 0 * numbers)
    searched = Searched(
        SearchOptions("cma", searches=2, candidates=count), "all candidates have been evaluated", history
    )
    return Result(
        walk.scene, "cpu", "warpmuscle optimize <walk56> & more", 7, table, evaluations, best_of(evaluations),
        walk.replays, searched,
    )  # fmt: skip


def no_parameters() -> ParameterTable:
    """The table of a scene without free parameters."""
    return ParameterTable((), (), *np.zeros((4, 0)), ())
