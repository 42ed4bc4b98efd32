"""How a result becomes the groups and datasets of an HDF5 file; see `warpmuscle.results.result` for the layout."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.errors import ResultError
from warpmuscle.core.hdf5_writing import store
from warpmuscle.core.plain_text import readable
from warpmuscle.core.status import Status
from warpmuscle.results.learned import CURVE, Ancestor, KeptGait, Learned, PolicyTable
from warpmuscle.results.motion_layout import put_motions
from warpmuscle.results.records import Best, Evaluations, ParameterTable, Result, Searched, SearchOptions

FORMAT = "warpmuscle"
FORMAT_VERSION = 3
HISTORY = {
    "generation": "number of the generation",
    "search": "number of the search",
    "best": "least cost of that search in that generation",
    "median": "median cost of that search in that generation",
    "spread": "standard deviation of its candidates in the unit cube, root mean square over parameters",
    "sigma": "step size of the search after the generation, in the unit cube; not a number if it has none",
    "asks_crc32": "CRC-32 of its candidates in the unit cube, float64 by rows, to tell a resumed search by",
    "stage": "number of the stage",
}


def put(file: Any, result: Result, file_format: str = FORMAT) -> None:
    """Fill an empty file.

    Raises:
        ResultError: a value is not finite, or an array has another shape than the layout says.
    """
    file.attrs["format"] = file_format
    file.attrs["format_version"] = FORMAT_VERSION
    for name in sorted(result.versions):
        file.attrs[f"{name}_version"] = result.versions[name]
    for name in sorted(result.machine):
        file.attrs[name] = result.machine[name]
    file.attrs["device"], file.attrs["seed"] = result.device, result.seed
    file.attrs["command"] = readable(result.command)  # which may name files
    store(file, "scene", result.scene, description="the experiment, as TOML")
    _put_parameters(file, result.parameters)
    if result.evaluations is not None:
        _put_evaluations(file, result.evaluations, len(result.parameters.name))
    if result.best is not None:
        _put_best(file, result.best)
        if result.searched is not None and result.searched.stages and result.evaluations is not None:
            stage = np.int64(result.evaluations.stage[result.best.index])
            store(file["best"], "stage", stage, description="stage that the cost is of; others have other costs")
        for term, parts in result.parts.items():
            group = file["best"].create_group(f"parts/{term}", track_order=True)
            store(group, "name", tuple(parts), axes="part", description="joints or muscles that add to the term")
            store(group, "value", np.array(list(parts.values())), axes="part",
                  description="what they add in the motion, in the unit of the term")  # fmt: skip
    if result.searched is not None:
        _put_searched(file, result.searched)
    if result.learned is not None:
        _put_learned(file, result.learned)
    put_motions(file, result.replays, result.replay_names)


def _put_parameters(file: Any, parameters: ParameterTable) -> None:
    count = len(parameters.name)
    group = file.create_group("parameters", track_order=True)
    store(group, "name", parameters.name, axes="parameter", description="path in the scene")
    store(group, "unit", parameters.unit, axes="parameter", description="unit of value, min, max and step")
    for name, description in {
        "min": "lower bound of the search",
        "max": "upper bound of the search",
        "step": "precision of the search, 0 if continuous",
        "value": "value in the scene of this file",
    }.items():
        array = _shaped(f"parameters/{name}", getattr(parameters, name), (count,))
        store(group, name, array, "see /parameters/unit", "parameter", description=description)
    store(group, "scale", parameters.scale, axes="parameter", description="of the unit interval from min to max")


def _put_evaluations(file: Any, evaluations: Evaluations, parameter_count: int) -> None:
    count = len(evaluations.cost)
    group = file.create_group("evaluations", track_order=True)
    params = _shaped("evaluations/params", evaluations.params, (count, parameter_count))
    store(group, "params", params, "see /parameters/unit", "evaluation, parameter", description="candidates")
    store(group, "cost", _shaped("evaluations/cost", evaluations.cost, (count,)), axes="evaluation",
          description="value of the objective")  # fmt: skip
    status = np.asarray(_shaped("evaluations/status", evaluations.status, (count,)), dtype=np.int32)
    store(group, "status", status, axes="evaluation", description="outcome; see the attributes named after outcomes")
    for member in Status:
        group["status"].attrs[member.name] = int(member)
    store(group, "end_time", _shaped("evaluations/end_time", evaluations.end_time, (count,)), units="s",
          axes="evaluation", description="simulated time at which the instance ended")  # fmt: skip
    for name, description in {
        "search": "number of the search that asked for it, -1 for the scene as given",
        "generation": "generation in which it was asked for",
        "stage": "stage in which it was asked for; costs of different stages cannot be compared",
    }.items():
        numbers = np.asarray(_shaped(f"evaluations/{name}", getattr(evaluations, name), (count,)), dtype=np.int32)
        store(group, name, numbers, axes="evaluation", description=description)
    if evaluations.term_names:
        terms = _shaped("evaluations/terms", evaluations.terms, (count, len(evaluations.term_names)))
        store(group, "terms", terms, axes="evaluation, term", finite=False,
              description="terms of the objective, unweighted; not a number where an instance diverged")  # fmt: skip
        store(group, "term_names", evaluations.term_names, axes="term", description="terms of the objective")


def _put_best(file: Any, best: Best) -> None:
    group = file.create_group("best", track_order=True)
    store(group, "params", np.asarray(best.params), "see /parameters/unit", "parameter", description="the candidate")
    store(group, "cost", np.float64(best.cost), description="least value of the objective")
    store(group, "index", np.int64(best.index), description="row of /evaluations")


def _put_searched(file: Any, searched: Searched) -> None:
    count = len(searched.history.generation)
    group = file.create_group("history", track_order=True)
    for name, description in HISTORY.items():
        array = _shaped(f"history/{name}", getattr(searched.history, name), (count,))
        store(group, name, array, axes="generation of a search", description=description, finite=name != "sigma")
    group = file.create_group("searches", track_order=True)
    _put_options(group, searched.options)
    group.attrs["ended"] = searched.ended
    if searched.elsewhere:
        group.attrs["elsewhere"] = searched.elsewhere
    if searched.evaluated:
        group.attrs["evaluated"] = searched.evaluated
    if searched.stages:
        group.attrs["stage"] = searched.stage
    for number, state in enumerate(searched.states):
        inner = group.create_group(str(number), track_order=True)
        for name in sorted(name for name in state if not np.isinf(state[name]).any()):  # infinite: unknown so far
            free = np.size(state.get("mean", ()))
            axes = ", ".join("dimension" if size == free else "entry" for size in np.shape(state[name]))
            store(inner, name, state[name], axes=axes, finite=False,
                  description="state of the search, in the unit cube")  # fmt: skip
    for number, stage in enumerate(searched.stages):
        inner = file.create_group(f"stages/{number}", track_order=True)
        inner.attrs["name"] = stage.name
        _put_options(inner, stage.options)
        inner.attrs["ended"] = stage.ended
        store(inner, "free", stage.free, axes="dimension of a search", description="parameters that the stage changes")
        if stage.best is not None:
            _put_best(inner, stage.best)


def _put_options(group: Any, options: SearchOptions) -> None:
    for field in fields(SearchOptions):
        if (value := getattr(options, field.name)) is not None:
            group.attrs[field.name] = value


def _put_learned(file: Any, learned: Learned) -> None:
    group = file.create_group("policy", track_order=True)
    _put_network(group, learned.policy)
    store(group, "task", learned.task, description="what the policy has learnt to do, as JSON")
    if learned.policy.gait is not None:
        _put_gait(file.create_group("gait", track_order=True), learned.policy.gait)
    if learned.critic is not None:
        _put_network(file.create_group("critic", track_order=True), learned.critic)
    count = len(learned.curve["iteration"])
    group = file.create_group("curve", track_order=True)
    for name, column in CURVE.items():
        array = _shaped(f"curve/{name}", learned.curve[name], (count,))
        store(group, name, array, column.unit, "iteration", description=column.description)
    group = file.create_group("training", track_order=True)
    group.attrs["ended"] = learned.ended
    for name, value in learned.options.items():
        group.attrs[name] = value
    if learned.ancestors:
        _put_ancestors(group.create_group("ancestors", track_order=True), learned.ancestors)


def _put_gait(group: Any, gait: KeptGait) -> None:
    group.attrs["scene"], group.attrs["right"], group.attrs["cycle_time"] = gait.scene, gait.right, gait.cycle_time
    store(group, "coordinate", gait.coordinate, axes="bin of the cycle, coordinate",
          description="of the gait that the scene's own controller makes, mean over its cycles")  # fmt: skip
    store(group, "up", gait.up, axes="bin of the cycle, x y z", description="the vertical in the root")
    store(group, "landings", gait.landings, "s", "cycle", description="when the left foot touched down")


def _put_ancestors(group: Any, ancestors: tuple[Ancestor, ...]) -> None:
    for name, description in {
        "file": "policy that was begun from, nearest first",
        "command": "it was learnt by",
    }.items():
        store(group, name, tuple(getattr(one, name) for one in ancestors), axes="ancestor", description=description)
    for name, description in {"seed": "it was learnt with", "decisions": "it took"}.items():
        numbers = np.array([getattr(one, name) for one in ancestors], dtype=np.int64)
        store(group, name, numbers, axes="ancestor", description=description)


def _put_network(group: Any, policy: PolicyTable) -> None:
    group.attrs["activation"], group.attrs["widest"] = "elu", policy.widest
    store(group, "observation", policy.observation, axes="observation", description="what the network sees, in order")
    store(group, "action", policy.action, axes="action", description="what the network says, in order")
    store(group, "mean", policy.mean, axes="observation", description="taken off an observation")
    store(group, "deviation", policy.deviation, axes="observation", description="by which what is left is divided")
    for number, layer in enumerate(policy.layers):
        inner = group.create_group(f"layers/{number}", track_order=True)
        store(inner, "weight", layer.weight, axes="output, input", description="of a linear layer")
        store(inner, "bias", layer.bias, axes="output", description="of a linear layer")
    if policy.noise is not None:
        group.attrs["action_min"], group.attrs["action_max"] = policy.noise.low, policy.noise.high
        store(
            group, "noise", policy.noise.deviation, axes="action", description="of which clipped actions are the mean"
        )


def _shaped(name: str, array: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The array, if it has this shape; raises ResultError otherwise."""
    if np.shape(array) != shape:
        raise ResultError(f"{name} has shape {np.shape(array)}, not {shape}; nothing was written")
    return array
