"""Speed and effort of walks over the depth of the water that they walk in, all depths in one batch.

For docs/how-to/walk-in-water.md.

python tools/research/water_figure.py -o water.png              walks as they are, 1000 depths; on a GPU
python tools/research/water_figure.py --search 20000            walks found for every 10 cm, and between them
python tools/research/water_figure.py --depths 40 --device cpu  half a minute of one core, when kernels are compiled
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.optimization.optimize import optimize
from warpmuscle.scene import Scene
from warpmuscle.scene.initial_pose import plain_number
from warpmuscle.scene.masses import body_mass
from warpmuscle.scene.parameters import with_values
from warpmuscle.simulation.rollout import Rollout

SCENES = ["fwalk_water", "walk56_water"]
DEEPEST = 1.3  # m, to the chest
SECONDS, SETTLED = 10.0, 3.0  # s, of a walk, and from when on it is measured
SAMPLED = 0.02  # s, between forces that are added up
SEARCHED = 0.1  # m, between depths for which walks are searched
SLOWEST = 0.2  # m/s, of those
POPULATION = 20  # candidates a generation of each search


class Walks(NamedTuple):
    """What became of walks in so deep water."""

    depth: np.ndarray  # (n,) m
    stands: np.ndarray  # (n,) whether it did not fall
    lasted: np.ndarray  # (n,) s
    speed: np.ndarray  # (n,) m/s, of those that stood
    effort: np.ndarray  # (n,) for each metre
    borne: np.ndarray  # (n,) mean vertical force on both feet, body weights


def gaits(scene: Scene, candidates: int, searches: int, device: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Depths (k,), m, and values of free parameters (k, P) of the walks of least effort there.

    Each search begins with what the one before found, from shallow to deep water.
    """
    scene = msgspec.structs.replace(scene, failure=msgspec.structs.replace(scene.failure, no_progress=SLOWEST))
    depths, found = np.arange(0.0, DEEPEST + 1e-6, SEARCHED), []
    for depth in depths:
        scene.commands["depth"].value = float(depth)
        best = optimize(scene, candidates, search="cma", searches=searches, population=POPULATION, device=device).best
        assert best is not None
        found.append(np.asarray(best.params, dtype=float))
        scene = with_values(scene, found[-1])
        print(f"{scene.name}: {depth:.1f} m, cost {best.cost:.6g}", flush=True)
    return depths, np.array(found)


def walks(name: str, depths: int, device: str | None, search: int, searches: int) -> Walks:
    """Walk in water of so many depths, after a search of so many candidates for every 10 cm, if of any."""
    scene = wm.load(name)
    depth = np.linspace(0.0, DEEPEST, depths)
    scene.objective.reported = [*scene.objective.reported, "torque"]
    rollout = Rollout(scene, depths, device)
    if search:
        at, values = gaits(wm.load(name), search, searches, device)
        rollout.set_parameters(np.stack([np.interp(depth, at, column) for column in values.T], axis=1))
    rollout.set_commands({"depth": depth})
    rollout.run(SETTLED)
    before, spent = place(rollout), effort(rollout)
    borne = borne_by_feet(rollout)
    stands = np.isin(rollout.status(), [wm.Status.RUNNING, wm.Status.COMPLETED])
    gone = place(rollout) - before
    return Walks(
        depth, stands, np.asarray(rollout.end_time()), gone / (SECONDS - SETTLED),
        (effort(rollout) - spent) / np.maximum(gone, 1e-3), borne,
    )  # fmt: skip


def place(rollout: Rollout) -> np.ndarray:
    """How far roots are ahead, m."""
    return np.asarray(rollout.state.coordinates.numpy()[:, 2], dtype=float)


def effort(rollout: Rollout) -> np.ndarray:
    """Sum over time and joints of the size of feedback torques, N m s."""
    return np.asarray(rollout.state.torque_integral.numpy().sum(axis=1)) * rollout.scene.time_step


def borne_by_feet(rollout: Rollout) -> np.ndarray:
    """Mean vertical force on both feet until the end, body weights."""
    times = round((SECONDS - SETTLED) / SAMPLED)
    total = np.zeros(rollout.instances)
    for _ in range(times):
        rollout.run(SAMPLED)
        total += rollout.state.foot_force.numpy()[..., 1].sum(axis=1)
    weight = body_mass(rollout.scene.character) * plain_number(rollout.scene.gravity)
    return np.asarray(total / (times * weight))


def drawn(found: dict[str, Walks]) -> Any:
    """Speed, effort and weight on the feet over depth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.0), layout="constrained")
    axes = figure.subplots(1, 3)
    for name, one in found.items():
        label, stands = name.removesuffix("_water"), one.stands
        axes[0].plot(one.depth[stands], one.speed[stands], ".", ms=4, label=label)
        axes[1].plot(one.depth[stands], one.effort[stands], ".", ms=4, label=label)
        axes[2].plot(one.depth[stands], one.borne[stands], ".", ms=4, label=label)
    axes[2].set_ylim(0.0, 1.1)
    for part, label in zip(axes, ("speed, m/s", "feedback torque, N m s/m", "weight on the feet"), strict=True):
        part.set(xlabel="depth, m", ylabel=label, xlim=(0.0, DEEPEST))
        part.spines[["top", "right"]].set_visible(False)
    axes[0].legend(frameon=False)
    return figure


def main(
    scenes: Annotated[list[str] | None, typer.Argument(help="Names or files with a command `depth`.")] = None,
    output: Annotated[Path, typer.Option("--output", "-o")] = Path("water.png"),
    depths: int = 1000,
    device: str | None = None,
    search: Annotated[int, typer.Option(help="Candidates for every 10 cm; 0: walks as they are.")] = 0,
    searches: Annotated[int, typer.Option(help="Searches side by side for every 10 cm.")] = 48,
) -> None:
    """Print a table by depth, and draw the figure."""
    found = {name: walks(name, depths, device, search, searches) for name in scenes or SCENES}
    for name, one in found.items():
        print(f"{name}: {int(one.stands.sum())} of {depths} depths walked for {SECONDS:g} s")
        for depth in np.arange(0.0, DEEPEST + 0.01, 0.1):
            near = np.abs(one.depth - depth) <= 0.05
            well = near & one.stands
            if well.any():
                share, speed = f"{int(well.sum())} of {int(near.sum())}", one.speed[well].mean()
                print(
                    f"  {depth:.1f} m: {share}, {speed:.3f} m/s, {one.effort[well].mean():.0f} N m s/m, "
                    f"{one.borne[well].mean():.2f} of the weight"
                )
            elif near.any():
                print(f"  {depth:.1f} m: none, fell after {one.lasted[near].mean():.1f} s")
    drawn(found).savefig(output, dpi=150)


if __name__ == "__main__":
    run_script(main)
