"""What episodes start from: rows of states on the device, copied into the state of instances whose episode begins."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import msgspec
import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpmuscle.core.arrays import arrays_of, instance_zeros, named_arrays
from warpmuscle.kernels.learning.episodes import RestoredArray, restore_rows
from warpmuscle.kernels.structs import FootCycle
from warpmuscle.results.recording import Recording
from warpmuscle.scene.joints import root_type
from warpmuscle.simulation.extensions import words, words_a_row
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.simulation.stepper import Stepper, sensing, unrecorded

LANES = 32  # that copy the rows of an instance
SUMS = (  # begin anew with every episode, whatever the state that it starts from
    "torque_integral", "muscle_terms", "body_terms", "instance_terms", "part_memory", "status", "push", "push_steps",
)  # fmt: skip
FELT = ("sensed", "force")  # by muscles, in the step that the state stands before
Rows = NDArray[np.int32]


def state_arrays(stepper: Stepper) -> Iterator[tuple[str, wp.array]]:
    """All arrays that have a row for each instance and that steps change, by name."""
    state, instances = stepper.state, len(stepper.state.step)
    yield from ((name, array) for name, array in named_arrays(state) if array.size and len(array) == instances)
    memories = (array for array in arrays_of(stepper.extensions) if array.ndim == 3)
    for number, memory in enumerate(memories):
        yield f"memory {number}", memory


class RowTable:
    """Arrays with a row for each instance, and rows that can be put there."""

    def __init__(self, targets: list[wp.array], sources: list[wp.array], device: Any) -> None:
        """Keep both; sources have as many words in every row, which are contiguous."""
        self._kept, self._device = (targets, sources), device
        self._rows = len(sources[0]) if sources else 1
        table = np.zeros(max(len(targets), 1), dtype=RestoredArray.numpy_dtype())
        for row, (target, source) in enumerate(zip(targets, sources, strict=True)):
            near = target.ndim > 1 and target.strides[0] < target.strides[-1]
            table[row] = (target.ptr, source.ptr, words_a_row(target), words(target).shape[2], near)
        self._table = wp.array(table[: len(targets)], dtype=RestoredArray, device=device) if targets else None

    def restore(self, mask: wp.array, row: wp.array) -> None:
        """Put rows of these numbers, (instances,), to the instances of a mask."""
        if self._table is not None:
            inputs = [mask, row, self._table, self._rows, LANES]
            wp.launch(restore_rows, (len(mask), LANES), inputs, device=self._device)


def start_table(stepper: Stepper, states: list[dict[str, Rows]]) -> RowTable:
    """The starts of a batch: what `first_states` and `controller_gait` give."""
    arrays, device = dict(state_arrays(stepper)), stepper.state.step.device
    sources = []
    for name, array in arrays.items():
        width = words_a_row(array)
        rows = [state.get(name, np.zeros(width, dtype=np.int32)) for state in states]
        sources.append(wp.array(np.stack(rows), dtype=int, device=device))
    return RowTable(list(arrays.values()), sources, device)


def first_states(rollout: Rollout, stepper: Stepper, count: int = 1) -> list[dict[str, Rows]]:
    """The initial states of the first instances, words of every array, with what muscles feel there."""
    rollout.reset()
    rise = rollout.terrain_starts.rise(rollout.model, rollout.state)
    states = _rows(stepper, count)
    stepper.launch(1)
    felt = _rows(stepper, count)
    rollout.reset()
    for state, height in zip(states, rise, strict=False):
        _lower(state, height, rollout)
    return [
        state | {name: later[name] for name in FELT if name in later} for state, later in zip(states, felt, strict=True)
    ]


class ControllerGait(NamedTuple):
    """The gait that a scene's own controller makes."""

    states: list[dict[str, Rows]]  # words of every array, none after it has failed
    times: list[float]  # s, of the states
    recording: Recording | None  # None where nothing was recorded


def controller_gait(rollout: Rollout, count: int, after: float, every: int, recorded: float = 0.0) -> ControllerGait:
    """Run the scene's own controller once, for states evenly over the scene's time, and for a motion.

    Commands of the scene are at their references: a policy may be asked for what the controller cannot do.

    Args:
        count: how many states at most. after: s, when the first is taken. every: so many steps between two, at least.
        recorded: s, of the motion.
    """
    scene = rollout.scene
    level = {name: msgspec.structs.replace(command, value=None, over=[]) for name, command in scene.commands.items()}
    duration = max(recorded, scene.duration if count else 0.0)
    lasting = msgspec.structs.replace(scene, duration=duration, commands=level)
    donor = Rollout(lasting, 1, str(rollout.device), record=[0] if recorded else ())
    make_room_to_feel(donor)
    stepper = donor.stepper(sensing if recorded else lambda config: sensing(unrecorded(config)), {})
    first = round(after / scene.time_step)
    gap = max((rollout.steps - first) // max(count, 1), every, 1)
    start = _rows(stepper)[0]
    states: list[dict[str, Rows]] = []
    times: list[float] = []
    step = max(first, 1)
    stepper.launch(step)
    while len(states) < count and step <= rollout.steps and not donor.status()[0]:
        state = _rows(stepper)[0]
        _lower(state, donor.terrain_starts.rise(donor.model, donor.state)[0], donor)
        _put_back(state, start, donor)
        states.append({name: values for name, values in state.items() if name not in SUMS})
        times.append(step * scene.time_step)
        stepper.launch(gap)
        step += gap
    if not recorded:
        return ControllerGait(states, times, None)
    if step < donor.steps and not donor.status()[0]:
        stepper.launch(donor.steps - step)
    return ControllerGait(states, times, donor.recording().window(0.0, recorded))


def make_room_to_feel(rollout: Rollout) -> None:
    """Give muscles room to tell what they feel, see `stepper.sensing`."""
    muscles = rollout.state.muscles
    if rollout.excitable and not len(muscles.sensed):
        shape = muscles.activation.shape
        muscles.sensed = instance_zeros(shape, wp.vec3, rollout.device, rollout.side_by_side)


def _put_back(state: dict[str, Rows], start: dict[str, Rows], rollout: Rollout) -> None:
    """Put a state to the place on the ground where another one is, and all places that it remembers with it."""
    root = root_type(rollout.scene.character)
    place, remembered = state["coordinates"].view(np.float32), [state[name] for name in ("passed",) if name in state]
    places = [words.view(np.float32) for words in remembered]
    if "foot_cycle" in state:
        cycles = state["foot_cycle"].view(FootCycle.numpy_dtype())
        places += [cycle[name] for cycle in cycles for name in ("landing", "place", "before")]
    for k in root.on_ground:
        wanted = start["coordinates"].view(np.float32)[k]
        for one in places:
            one[root.moving[k]] += wanted - place[k]
        place[k] = wanted


def _lower(state: dict[str, Rows], rise: float, rollout: Rollout) -> None:
    """Put a state down by what the ground rises below it, as each episode raises it over its own ground."""
    if not rollout.terrain_starts.applies or "root.y" not in rollout.coordinate_names:
        return
    state["coordinates"].view(np.float32)[rollout.coordinate_names.index("root.y")] -= np.float32(rise)


def _rows(stepper: Stepper, count: int = 1) -> list[dict[str, Rows]]:
    """The first instances' words of every array."""
    arrays = {name: words(array)[:count].numpy().reshape(count, -1) for name, array in state_arrays(stepper)}
    return [{name: array[row].copy() for name, array in arrays.items()} for row in range(count)]
