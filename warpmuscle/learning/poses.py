"""Starts with other angles: joints shaken, or drawn from ranges, and states that a file holds.

All are made once, on the host: muscles start in the balance of fibre and tendon that the pose has.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warpmuscle.core.archive import DamagedArchive, arrays_of
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.plain_text import number_of
from warpmuscle.learning.starts import Rows, first_states
from warpmuscle.results.partial_motion import demanding
from warpmuscle.results.result import read
from warpmuscle.scene.joints import joint_type
from warpmuscle.scene.learning import Variation
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import Stepper

SEED = 2  # of what is drawn: the same starts for every batch and training
MOST = 65536  # states of a file, which lie in the memory of the device
QUATERNION_ERROR = 1e-3
OF_THE_GAIT = ("phase", "stance", "machine_state")  # of the scene's controller, which stay as the start has them
NAMES = ("coordinates", "speeds", "activation")

State = dict[str, Rows]


class States(NamedTuple):
    """States to start from."""

    coordinates: Floats  # (N, C)
    speeds: Floats  # (N, S)
    activation: Floats | None  # (N, muscles of the scene); None: as the scene says


def elsewhere(
    rollout: Rollout, stepper: Stepper, variation: Variation, states: list[State], times: list[float]
) -> tuple[list[State], list[float]]:
    """The starts of a batch with what a task varies of them; the same ones if it varies no joints.

    Args:
        rollout, stepper: of the batch; the rollout is at its own start again afterwards.
        states, times: starts as they are, and when they are in the gait, s.

    Raises:
        RolloutError: the file of states cannot be read, or is of another scene.
    """
    if not (variation.joint_noise or variation.pose or variation.start_file):
        return states, times
    generator = np.random.default_rng(SEED)
    if variation.start_file:
        given = states_in(variation.start_file, rollout)
        chosen = np.arange(len(given.coordinates))
        bases, times = [states[0]] * len(chosen), [0.0] * len(chosen)
    else:
        given = _decoded(states, rollout)
        chosen, bases = np.arange(len(states)), states
    if variation.joint_noise or variation.pose:
        chosen = generator.integers(len(chosen), size=variation.poses)
    coordinates = given.coordinates[chosen]
    _draw_ranges(coordinates, variation.pose, rollout, generator)
    _shake(coordinates, variation.joint_noise, rollout, generator)
    activation = None if given.activation is None else given.activation[chosen]
    found = started(rollout, stepper, States(coordinates, given.speeds[chosen], activation))
    kept = [{name: bases[k][name] for name in OF_THE_GAIT if name in bases[k]} for k in chosen]
    return [state | of_gait for state, of_gait in zip(found, kept, strict=True)], [times[k] for k in chosen]


def states_in(path: str, rollout: Rollout) -> States:
    """The states of a file: an archive (`.npz`) of arrays, or all frames of the motions of a result file.

    An archive has `coordinates` (N, C), in the order of `Rollout.coordinate_names`, and may have `speeds` (N, S) and
    `activation` (N, muscles); what it has not is as the scene starts, speeds 0.

    Raises:
        RolloutError: it cannot be read, or is of another scene.
    """
    arrays = _archived(path) if Path(path).suffix.lower() == ".npz" else _recorded(path, rollout)
    sizes = dict(
        zip(NAMES, map(len, (rollout.coordinate_names, rollout.speed_names, rollout.muscle_names)), strict=True)
    )
    if "coordinates" not in arrays:
        raise RolloutError(f"{path}: holds no array `coordinates`")
    count = len(arrays["coordinates"]) if arrays["coordinates"].ndim else 0
    if not 1 <= count <= MOST:
        raise RolloutError(f"{path}: holds {number_of(count, 'state')}, and should hold 1 to {MOST}")
    for name, array in arrays.items():
        wanted = (count, sizes[name])
        if array.dtype.kind not in "fiu" or array.shape != wanted:
            raise RolloutError(f"{path}: {name} have shape {array.shape}; {rollout.scene.name} takes {wanted}")
        if not np.isfinite(array).all():
            raise RolloutError(f"{path}: a number of the {name} is not finite")
    coordinates = arrays["coordinates"].astype(np.float64)
    for place in _quaternions(rollout, root=True):
        size = np.linalg.norm(coordinates[:, place], axis=1)
        if (np.abs(size - 1.0) > QUATERNION_ERROR).any():
            name = rollout.coordinate_names[place.start]
            raise RolloutError(f"{path}: {name} and what follows it is not a quaternion of length 1")
        coordinates[:, place] /= size[:, None]
    speeds = arrays.get("speeds", np.zeros((count, sizes["speeds"])))
    activation = arrays.get("activation")
    if activation is not None and (not rollout.excitable or not activation.size):
        activation = None
    return States(coordinates, speeds.astype(np.float64), activation)


def _archived(path: str) -> dict[str, Any]:
    """Arrays of an archive."""
    try:
        return arrays_of(path, NAMES)
    except DamagedArchive as error:
        raise RolloutError(f"{path}: {error}") from None


def _recorded(path: str, rollout: Rollout) -> dict[str, Any]:
    """The frames of all motions of a result file, as arrays of an archive."""
    motions = [demanding(motion, str(path)) for motion in read(path).replays if len(motion.time)]
    if not motions:
        raise RolloutError(f"{path}: holds no motion, whose frames would be starts")
    for motion in motions:
        if tuple(motion.coordinate_names) != tuple(rollout.coordinate_names):
            raise RolloutError(f"{path}: holds the motion of another character than that of {rollout.scene.name}")
    arrays = {"coordinates": [m.coordinate for m in motions], "speeds": [m.speed for m in motions]}
    if all(tuple(motion.muscle_names) == tuple(rollout.muscle_names) for motion in motions):
        arrays["activation"] = [m.muscle_activation for m in motions]
    return {name: np.concatenate(parts) for name, parts in arrays.items()}


def _decoded(states: list[State], rollout: Rollout) -> States:
    """What rows of words say."""

    def numbers(name: str) -> Floats:
        return np.stack([np.ascontiguousarray(state[name]).view(np.float32) for state in states]).astype(np.float64)

    activation = None
    if rollout.excitable:
        activation = np.zeros((len(states), len(rollout.muscle_names)))
        simulated = [rollout.muscle_names.index(name) for name in rollout.structure.actuation.muscles]
        activation[:, simulated] = numbers("activation")[:, : len(simulated)]
    return States(numbers("coordinates"), numbers("speeds"), activation)


def _draw_ranges(
    coordinates: Floats, ranges: Mapping[str, tuple[float, float]], rollout: Rollout, generator: np.random.Generator
) -> None:
    """Draw coordinates (N, C) of these names evenly from their ranges."""
    for name, (low, high) in ranges.items():
        coordinates[:, rollout.coordinate_names.index(name)] = generator.uniform(low, high, len(coordinates))


def _shake(coordinates: Floats, deviation: float, rollout: Rollout, generator: np.random.Generator) -> None:
    """Add noise to all coordinates (N, C) of joints; ball joints turn about a random axis."""
    if not deviation:
        return
    first, count = rollout.names.coordinate_start[1], len(coordinates)
    turned = np.zeros(coordinates.shape[1], dtype=bool)
    for place in _quaternions(rollout):
        turned[place] = True
        from scipy.spatial.transform import Rotation  # takes a quarter of a second

        by = Rotation.from_rotvec(generator.normal(0.0, deviation, (count, 3)))
        coordinates[:, place] = (Rotation.from_quat(coordinates[:, place]) * by).as_quat()
    plain = np.flatnonzero(~turned[first:]) + first
    coordinates[:, plain] += generator.normal(0.0, deviation, (count, len(plain)))


def _quaternions(rollout: Rollout, root: bool = False) -> list[slice]:
    """Where the quaternions of ball joints are among the coordinates, and that of the root."""
    names, joints = rollout.names, rollout.scene.character.joints
    found = [slice(3, 7)] if root and names.coordinate_start[1] == 7 else []
    for body in range(1, len(names.bodies)):
        if joint_type(joints[names.joints[body - 1]]).quaternion:
            found.append(names.joint_coordinates(body))
    return found


def started(rollout: Rollout, stepper: Stepper, wanted: States) -> list[State]:
    """Words of all arrays where instances start so, as many at once as the batch has."""
    n, found = rollout.instances, []
    here = _decoded(first_states(rollout, stepper), rollout)
    for begin in range(0, len(wanted.coordinates), n):
        rows = [None if part is None else part[begin : begin + n] for part in wanted]
        count = len(wanted.coordinates[begin : begin + n])
        rollout.set_initial(*(None if part is None else np.resize(part, (n, part.shape[1])) for part in rows))
        found += first_states(rollout, stepper, count)
    rollout.set_initial(*here)
    return found
