"""How fast batches of any models step on a device: OpenSim models, scenes, or files, all of it but recording.

    python tools/bench_models.py Rajagopal2016.osim gait2392.osim walk56
    python tools/bench_models.py Rajagopal2016.osim --ball-joints --merge-welds --device cpu --instances 8
    python tools/bench_models.py MoBL_ARMS.osim --instances 5120 --stages

Instances start with different velocities and half-excited muscles, so that they do not all take the same branches; the
fastest of several runs counts, after one that compiles. With `--stages` microseconds of a step of the whole batch
follow, by stage (`stage_times.py`), and on a GPU what the kernel takes of it (`gpu_resources.py`).
"""

from __future__ import annotations

import warnings
from typing import Annotated

import typer
import warp as wp
from fastest_run import fastest_run
from gpu_resources import resources
from stage_times import StageTimes

from warpmuscle.cli.ending import run_script
from warpmuscle.formats import load
from warpmuscle.scene import Excitation, Failure, Scene
from warpmuscle.simulation.rollout import Rollout, find_device

STEPS_BY_STAGE = 200


def prepared(source: str, seconds: float, step: float, ball_joints: bool, merge_welds: bool = False) -> Scene:
    """The scene, with excitations of its own if nothing controls its muscles, and nothing that ends it early."""
    options = {"ball_joints": ball_joints, "merge_welds": merge_welds} if source.endswith(".osim") else {}
    scene = load(source, ignored=[], **options)
    scene.duration, scene.time_step = seconds, step
    scene.failure = Failure(com_height=0.0, heading=0.0)
    if scene.controller is None:
        for muscle in scene.character.muscles.values():
            muscle.excitation = muscle.excitation or Excitation([0.0], [0.5])
    return scene


def show_stages(rollout: Rollout, repeats: int) -> None:
    """Print the microseconds of each stage, and what the plain kernel takes of a GPU."""
    split = StageTimes(rollout, 0.1).split(STEPS_BY_STAGE, repeats)
    print(f"  {', '.join(f'{stage} {time:.4g}' for stage, time in split.items())}", flush=True)
    if not rollout.device.is_cpu:
        kernel = rollout._launcher.kernel().kernel
        wp.load_module(kernel.module, rollout.device, block_dim=rollout.block_dim)
        taken = resources(kernel, rollout.device, rollout.block_dim, rollout.lanes)
        print(f"  {', '.join(f'{name} {number}' for name, number in taken.items())}", flush=True)


def main(
    sources: Annotated[list[str], typer.Argument(help="Scenes by name or file, or .osim.")],
    device: Annotated[str, typer.Option(help="cuda:0, ... or cpu.")] = "cuda:0",
    instances: Annotated[str, typer.Option(help="Batch sizes.")] = "1024,5120,65536",
    lanes: Annotated[str, typer.Option(help="Lanes on a GPU; the usual ones if empty.")] = "",
    seconds: Annotated[float, typer.Option(help="Motion of a run.")] = 0.5,
    step: Annotated[float, typer.Option(help="Time step, s.")] = 0.0005,
    repeats: Annotated[int, typer.Option(help="Runs, of which the fastest counts.")] = 3,
    ball_joints: Annotated[bool, typer.Option("--ball-joints", help="As of `warpmuscle convert`.")] = False,
    merge_welds: Annotated[bool, typer.Option("--merge-welds", help="The same.")] = False,
    stages: Annotated[bool, typer.Option("--stages", help="Time by stage, too.")] = False,
) -> None:
    """Print million steps a second."""
    warnings.simplefilter("ignore")
    place = find_device(device)
    for source in sources:
        scene = prepared(source, seconds, step, ball_joints, merge_welds)
        for count in map(int, instances.split(",")):
            for shared in [int(word) for word in lanes.split(",") if word] or [None]:
                rollout = Rollout(scene, count, place, lanes=shared)
                took = fastest_run(rollout, repeats, 0.1)
                ended = rollout.end_time()
                alive = int((ended >= seconds - 0.5 * step).sum())
                print(
                    f"{scene.name:24s} {len(scene.character.muscles)} muscles x {count:6d}, {rollout.lanes:2d} lanes: "
                    f"{ended.sum() / step / took / 1e6:7.2f} million steps/s, {1e3 * took:.1f} ms, {alive} to the end",
                    flush=True,
                )
                if stages:
                    show_stages(rollout, repeats)


if __name__ == "__main__":
    run_script(main)
