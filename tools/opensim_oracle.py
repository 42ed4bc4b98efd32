"""What OpenSim computes of a model in random poses: the numbers that `opensim_agreement.py` puts beside ours.

    python tools/opensim_oracle.py MODEL.osim --poses 1000 --seed 1

OpenSim (`pip install opensim`, 4.6) runs in a process of its own, in float64. Its numbers take minutes, so those of a
model and a seed are kept in `~/.cache/warpmuscle/opensim` (or the folder that WARPMUSCLE_OPENSIM_CACHE names). Poses
lie inside the coordinates' ranges; couplers are satisfied, locked and prescribed coordinates have their values. All
arrays over coordinates are in the order of `Numbers.coordinates`; forces are generalised forces of its independent
ones, where the constraints' own forces do no work.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray
from opensim_posed import Floats, Posed

from warpmuscle.cli.ending import run_script

FORMAT = 3  # of the kept numbers
MISSING = "OpenSim is not installed: pip install opensim"


@dataclass(frozen=True)
class Numbers:
    """OpenSim's numbers of K coordinates, I of them independent, and M muscles in n poses, and along small moves."""

    coordinates: NDArray[np.str_]  # (K,)
    rotational: NDArray[np.bool_]  # (K,)
    independent: NDArray[np.int64]  # (I,) numbers of coordinates that are neither coupled nor locked nor prescribed
    muscles: NDArray[np.str_]  # (M,)
    q: Floats  # (n, K) rad or m
    rate: Floats  # (n, K)
    acceleration: Floats  # (n, K)
    length: Floats  # (n, M) m
    speed: Floats  # (n, M) m/s, of lengthening
    arm: Floats  # (n, M, K) m, -dl/dq as OpenSim gives it
    slope: Floats  # (n, M, K) m, -dl/dq by differences of OpenSim's lengths
    mass: Floats  # (n, I, I)
    inverse_dynamics: Floats  # (n, I) N m or N
    dynamics_by_slope: Floats  # (n, I) the same with bodies' accelerations that are the rates of OpenSim's velocities
    acceleration_off: Floats  # (n,) how far OpenSim's accelerations are from these, over the greatest
    gravity: Floats  # (n, I) the same without rates and accelerations
    activation: Floats  # (n, M)
    force: Floats  # (n, M) N, of the tendon at equilibrium, without rates; NaN where OpenSim finds none
    fibre: Floats  # (n, M) m
    line_q: Floats  # (m, K) poses along lines of LINE small moves
    line_length: Floats  # (m, M)


def numbers(model: Path, poses: int, seed: int, moves: int, beyond: float = 0.0) -> Numbers:
    """OpenSim's numbers of a model, computed in a process of their own, or as kept.

    Args:
        beyond: part of each range, by which poses may be beyond both of its ends.

    Raises:
        SystemExit: OpenSim is not installed, or it does not read the model.
    """
    wider = f"{beyond} " if beyond else ""
    key = hashlib.sha256(f"{FORMAT} {poses} {seed} {moves} {wider}".encode() + model.read_bytes()).hexdigest()[:16]
    file = cache() / f"{model.stem}_{key}.npz"
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        with_process(_write, model, poses, seed, moves, beyond, file)
    with np.load(file) as kept:
        return Numbers(**{field.name: kept[field.name] for field in fields(Numbers)})


def cache() -> Path:
    """The folder of the kept numbers."""
    return Path(os.environ.get("WARPMUSCLE_OPENSIM_CACHE", Path.home() / ".cache" / "warpmuscle" / "opensim"))


def with_process(task: Callable[..., Any], *args: object) -> Any:
    """What a task of OpenSim's returns, computed in a fresh process, so that neither its threads nor a crash stay."""
    if find_spec("opensim") is None:
        raise SystemExit(MISSING)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(task, *args).result()


def _write(model: Path, poses: int, seed: int, moves: int, beyond: float, file: Path) -> None:
    found = asdict(_compute(model, poses, seed, moves, beyond))
    part = file.with_suffix(".part.npz")
    np.savez_compressed(part, **found)
    part.replace(file)


def _compute(file: Path, poses: int, seed: int, moves: int, beyond: float) -> Numbers:
    model, generator = Posed(file), np.random.default_rng(seed)
    free = model.independent
    rows: dict[str, list[Any]] = {name: [] for name in _OF_A_POSE}
    q = model.random_poses(generator, poses, beyond)
    rate, acceleration = np.zeros_like(q), np.zeros_like(q)
    rate[:, free] = generator.normal(size=(poses, len(free)))
    acceleration[:, free] = generator.normal(scale=5.0, size=(poses, len(free)))
    activation = generator.uniform(0.02, 1.0, (poses, len(model.muscles)))
    crossed = model.crossed(q[: min(poses, 40)])
    for k in range(poses):
        rate[k], acceleration[k] = model.consistent(q[k], rate[k], acceleration[k])
        model.pose(q[k], rate[k])
        rows["length"].append(model.lengths())
        rows["speed"].append([muscle.getLengtheningSpeed(model.state) for muscle in model.muscles])
        rows["arm"].append(model.moment_arms(crossed))
        rows["slope"].append(model.slopes(q[k]))
        for name, values in model.equilibrium(q[k], activation[k]).items():
            rows[name].append(values)
        for name, values in model.dynamics(q[k], rate[k], acceleration[k]).items():
            rows[name].append(values)
    line_q = model.lines(generator, moves)
    line_length = np.array([model.lengths_at(pose) for pose in line_q]).reshape(len(line_q), len(model.muscles))
    of_poses = {name: np.array(values) for name, values in rows.items()}
    return Numbers(
        np.array(model.names), model.rotational, free, np.array([muscle.getName() for muscle in model.muscles]),
        q, rate, acceleration, activation=activation, line_q=line_q, line_length=line_length, **of_poses,
    )  # fmt: skip


_OF_A_POSE = (
    "length",
    "speed",
    "arm",
    "slope",
    "mass",
    "inverse_dynamics",
    "dynamics_by_slope",
    "acceleration_off",
    "gravity",
    "force",
    "fibre",
)


def main(
    model: Annotated[Path, typer.Argument(help="File of the model.")],
    poses: Annotated[int, typer.Option(help="Random poses.")] = 1000,
    seed: Annotated[int, typer.Option(help="Of the poses.")] = 1,
    moves: Annotated[int, typer.Option(help="Small moves.")] = 100_000,
    beyond: Annotated[float, typer.Option(help="Part of each range that poses may be beyond its ends.")] = 0.0,
) -> None:
    """Compute, keep and describe OpenSim's numbers."""
    found = numbers(model, poses, seed, moves, beyond)
    for field in fields(Numbers):
        print(f"{field.name:18} {getattr(found, field.name).shape}")


if __name__ == "__main__":
    run_script(main)
