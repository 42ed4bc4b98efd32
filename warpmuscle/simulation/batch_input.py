"""What a batch is asked for, checked: how many instances, which of them to record, values, noise, and times."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from warpmuscle.core.arguments import as_array, as_integer, as_number, in_words
from warpmuscle.core.array_interop import is_array, mask_of
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import RolloutError
from warpmuscle.core.limits import check_size
from warpmuscle.core.plain_text import number_of
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.parameters import Parameter
from warpmuscle.scene.validation.checks import near

MOST = 2**31 - 1  # that kernels count to
in_silence = np.errstate(over="ignore", divide="ignore", invalid="ignore")  # of numbers that will diverge
CHUNK_TIME = 0.1  # s of simulated time between two looks at which instances still run

INSTEAD = {
    **dict.fromkeys(("to", "cuda", "cpu"), "Rollout(scene, device='cuda:0') is on another device"),
    **dict.fromkeys(
        ("obs", "observations", "observation_space", "action_space"),
        "import warpmuscle.gym, then gymnasium.make('warpmuscle/walk56-v0') has them",
    ),
    **dict.fromkeys(("data", "d"), "state has the arrays, recording(i) the motion of an instance"),
    "to_xarray": "recording(i).to_xarray() is that of one instance",
    "to_dataframe": "recording(i).to_dataframe() is that of one instance",
    "show": "wm.show(rollout) shows what was recorded",
    "view": "wm.show(rollout) shows what was recorded",
    "plot": "wm.plot(rollout, 'hip flexion') draws what was recorded",
    "save": "wm.show(rollout).save('page.html') writes a page; recording(i).to_csv and others the arrays",
    "free": "close() frees its memory",
    "costs": "cost() has them",
    "simulate": "run() simulates",
    "results": "cost(), status_names() and recording(i) are what came of it",
    "recordings": "recording(i) is that of one instance",
    **dict.fromkeys(("body_names", "bodies"), "names.bodies has their names"),
    **dict.fromkeys(("joint_names", "joints"), "names.joints has their names"),
    **dict.fromkeys(
        ("fell", "failed", "done", "dones", "success"),
        "status_names() says how each ended, alive how many have not fallen",
    ),
    **dict.fromkeys(("render", "view_live"), "wm.show(rollout) shows what was recorded"),
    **dict.fromkeys(
        ("randomize", "perturb"),
        "disturb(Perturbations(...)) pushes and changes bodies, reset(velocity_noise=0.1) starts with noise",
    ),
    **dict.fromkeys(
        ("joint_angle", "com", "muscle_activation", "to_numpy"), "recording(i) has the arrays of an instance over time"
    ),
    "set_parameter": "set_parameters({name: value}) sets one",
    "set_excitation": "set_excitations([0.0], values) has constant ones, values being (1 or instances, muscles, 1)",
    "set": "set_parameters({name: values}) changes free parameters",
    "set_params": "set_parameters({name: values}) changes free parameters",
    "params": "parameters are the free ones",
    "activations": "state has what muscles are at, recording(i).muscle_activation has it over time",
    "activation": "state has what muscles are at, recording(i).muscle_activation has it over time",
    "time": "state.time has it",
    **dict.fromkeys(("num_envs", "n", "batch_size", "size"), "instances are as many"),
    **dict.fromkeys(("t", "current_time"), "time is the simulated time so far, s"),
    **dict.fromkeys(("dt", "timestep", "time_step"), "scene.time_step is it, s"),
    **dict.fromkeys(("coordinates", "positions", "qpos", "states"), "state.coordinates.numpy() has all instances' now"),
    **dict.fromkeys(("speeds", "velocities", "qvel"), "state.speeds.numpy() has those of all instances now"),
    "set_state": "reset() puts instances back to their start",
    "fitness": "cost() has them",
    "muscles": "muscle_names has their names, state what they are at",
    "names_of_parameters": "parameter_names has them",
    "push": "set robustness of the scene: wm.load(scene, set={'robustness': {'runs': 5, 'push': 20}})",
}  # by what is often tried


def positive(value: int, what: str) -> int:
    """A positive whole number; RolloutError if it is none."""
    number = as_integer(value, what, error=RolloutError)
    if number > MOST:
        raise RolloutError(f"{what} must be {MOST} at most, not {in_words(value)}")
    return number


def checked_threads(threads: int | None) -> int:
    """CPU threads as asked for, or one a core; RolloutError if there cannot be so many."""
    if threads is None:
        return os.cpu_count() or 1
    count = as_integer(threads, "threads", error=RolloutError)
    check_size("threads", count, RolloutError)
    return count


def chosen(record: Sequence[int], instances: int) -> list[int]:
    """Instances to record, each once; RolloutError if there is no such instance."""
    if isinstance(record, str | bytes | dict) or not isinstance(record, Iterable):
        hint = f"; record=range({instances}) are all" if str(record) in ("True", "all") else ""
        raise RolloutError(f"record must be a list of instances' numbers, not {in_words(record)}{hint}")
    numbers = [as_integer(i, "a number in record", -(2**63), error=RolloutError) for i in record]
    wrong = [i for i in numbers if not 0 <= i < instances]
    if wrong:
        raise RolloutError(f"record: cannot record instance {wrong[0]} of {instances}")
    return list(dict.fromkeys(numbers))


def checked_values(values: ArrayLike, instances: int, count: int) -> Floats:
    """Parameter values as (instances, count) or (count,); RolloutError if they are not, or not finite."""
    array = as_array(values, "values", error=RolloutError).astype(np.float64)
    if array.shape not in ((count,), (instances, count)):
        raise RolloutError(
            f"values of parameters have shape {array.shape}; this rollout takes ({instances}, {count}) or ({count},)"
        )
    if not np.isfinite(array).all():
        raise RolloutError("one of the values of parameters is not a finite number")
    return array


def named_values(
    values: Mapping[str, ArrayLike], parameters: Sequence[Parameter], present: Floats, instances: int
) -> Floats:
    """Values (parameters,) or (instances, parameters) with some of them by name; RolloutError for other names.

    Args:
        present: of all parameters, (parameters,) or (instances, parameters).
    """
    names = [parameter.name for parameter in parameters]
    columns = {}
    for name, value in values.items():
        if name not in names:
            raise RolloutError(f"values: no free parameter is called {name!r}{near(str(name), names)}")
        columns[name] = as_array(value, name, error=RolloutError).astype(np.float64)
        if columns[name].shape not in ((), (1,), (instances,)):
            raise RolloutError(f"{name}: one number, or one for each of {number_of(instances, 'instance')}, is needed")
    several = present.ndim == 2 or any(column.shape == (instances,) for column in columns.values())
    found = np.tile(present, (instances, 1)) if several and present.ndim == 1 else present.copy()
    for name, column in columns.items():
        found[..., names.index(name)] = column if several else column.reshape(())
    return found


def root_noise(scene: Scene, instances: int, deviation: float, seed: int) -> Floats:
    """Noise for the linear speeds of the root, m/s: a row an instance, or one row of zeros if there is none."""
    linear = len(root_type(scene.character).moving)
    deviation = as_number(deviation, "velocity_noise", least=0.0, error=RolloutError)
    seed = as_integer(seed, "seed", 0, error=RolloutError)
    if not deviation:
        return np.zeros((1, linear))
    return np.random.default_rng(seed).normal(0.0, deviation, (instances, linear))


def noise_and_mask(
    scene: Scene, instances: int, velocity_noise: Any, seed: int, mask: Any
) -> tuple[Floats, NDArray[np.bool_] | None]:
    """The noise of all instances that are put back to their start, and which ones are; see `Batch.reset`."""
    if is_array(velocity_noise):
        velocity_noise, mask = 0.0, velocity_noise
    noise = root_noise(scene, instances, velocity_noise, seed)
    return noise, None if mask is None else mask_of(mask, instances)


def chunk_steps(scene: Scene) -> int:
    """Steps between two looks at which instances still run."""
    return max(round(CHUNK_TIME / scene.time_step), 1)


def end_step(batch: Any, duration: float | None) -> int:
    """The step at which a batch that runs on for a duration, s, ends; RolloutError if that is no time."""
    if duration is None:
        return int(batch.steps)
    duration = as_number(duration, "duration", least=0.0, error=RolloutError)
    return int(min(batch.steps_done + round(min(duration / batch.scene.time_step, batch.steps)), batch.steps))
