"""The course walked by a policy on muscles, with noise: how many come through, and what it does on the way.

For docs/how-to/walk-on-uneven-ground.md.

python tools/research/policy_course.py course56.h5 walk56_course.toml -o course.png    20 walks; minutes of two cores
python tools/research/policy_course.py course56.h5 walk56_course.toml --tests pieces   stairs, gaps, bumps by themselves
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
import numpy as np
import typer
from course_figure import draw

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.status import Status
from warpmuscle.learning.imitation import Gait
from warpmuscle.learning.player import Player, lasting, learned_in, task_of, undisturbed
from warpmuscle.results.learned import Learned
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Scene, Terrain
from warpmuscle.scene.learning import Task, Variation
from warpmuscle.scene.terrain.tiles import Flat, Gaps, Rough, Stairs

NOISE = 0.1  # m/s, of each component of the root's velocity at the start
Course = list[tuple[float, float]]  # times, s, and values, straight between them


class Walks(NamedTuple):
    """What became of disturbed walks."""

    through: np.ndarray  # (runs,) whether each reached the end
    ended: np.ndarray  # (runs,) s
    recordings: list[Recording]


class Walker(NamedTuple):
    """A policy, its task without anything drawn but the noise of the start, and the gait of its clock."""

    learned: Learned
    task: Task
    gait: Gait | None


def walker(policy: Path, scene: Scene) -> Walker:
    """The policy of a file; the clock's gait is that which the scene's controller makes on level ground."""
    learned = learned_in(policy)
    task = lasting(undisturbed(task_of(learned)))
    noisy = Variation(velocity_noise=NOISE)
    task = msgspec.structs.replace(task, variation=noisy, command_time=0.0)
    level = on(scene, Terrain([Flat()]), 10.0)
    return Walker(learned, task, Player(learned.policy, level, 1, "cpu", task).batch.gait)


def walked(by: Walker, scene: Scene, runs: int, seed: int, speed: Course, heading: Course) -> Walks:
    """Walks of a policy under a speed, m/s, and a heading, rad to the left, that change over time."""
    task = by.task
    player = Player(
        by.learned.policy, scene, runs, "cpu", task, seed, record=range(runs), record_rate=50.0, gait=by.gait
    )
    batch = player.batch
    rate = task.decision_time
    status = np.full(runs, int(Status.RUNNING))
    ended = np.zeros(runs)
    for decision in range(round(scene.duration / rate)):
        time = decision * rate
        now, then = (np.interp([time, time + rate], *zip(*course, strict=True)) for course in (speed, heading))
        told = np.tile(np.array([now[0], (then[1] - then[0]) / rate], dtype=np.float32), (runs, 1))
        batch.episodes.command.assign(told)
        player.decide(restart=False)
        running = status == Status.RUNNING  # a body that has failed may be moved on, but stays a failure
        status[running] = batch.rollout.state.status.numpy()[running]
        ended[running] = time + rate
        if not (status == Status.RUNNING).any():
            break
    return Walks(status == Status.RUNNING, ended, [batch.rollout.recording(run) for run in range(runs)])


def on(scene: Scene, terrain: Terrain, duration: float) -> Scene:
    """The body of a scene over other ground."""
    return msgspec.structs.replace(
        scene,
        ground=msgspec.structs.replace(scene.ground, terrain=terrain),
        duration=duration,
        commands={},
        learning=None,
    )


def ahead(recording: Any, heading: float) -> np.ndarray:
    """Speed of the centre of mass along a heading, m/s, (frames,)."""
    return np.asarray(recording.com_velocity @ np.array([np.sin(heading), 0.0, np.cos(heading)]))


def turned(recording: Any) -> np.ndarray:
    """Heading of the pelvis over time, rad, to the left."""
    return np.unwrap(2.0 * np.arctan2(recording.root_orientation[:, 1], recording.root_orientation[:, 3]))


def course(by: Walker, scene: Scene, runs: int, seed: int, figure: Path | None) -> None:
    """The course of the scene `course`."""
    torques = wm.load("course")
    speed, heading = torques.commands["speed"].over, torques.commands["heading"].over
    terrain = torques.ground.terrain
    assert terrain is not None
    over = on(scene, terrain, torques.duration)
    found = walked(by, over, runs, seed, speed, heading)
    print(
        f"course: {found.through.sum()} of {runs} came through;"
        f" the others ended at {np.round(np.sort(found.ended[~found.through]), 1)} s"
    )
    whole = [one for one, well in zip(found.recordings, found.through, strict=True) if well]
    if whole:
        (begin, first), (end, last) = heading[0], heading[-1]
        rates, errors, after = [], [], []
        for one in whole:
            angle, during = turned(one), (one.time > begin + 0.5) & (one.time < end)
            rates.append(np.polyfit(one.time[during], angle[during], 1)[0])
            after.append(angle[(one.time > end + 1.5) & (one.time < end + 2.5)].mean() - last)
            level = (one.time > 2.0) & (one.time < begin)
            errors.append(ahead(one, first)[level].mean() - speed[1][1])
        print(
            f"turning rate {np.degrees(np.mean(rates)):.1f} degrees/s,"
            f" off afterwards by {np.degrees(np.abs(after)).mean():.1f} degrees"
        )
        print(f"speed error {np.mean(errors):+.3f} m/s on level ground")
    if figure is not None:
        order = np.argsort(~found.through, kind="stable")
        draw(over, [found.recordings[run] for run in order], figure)


def steady(value: float) -> Course:
    """A command that stays."""
    return [(0.0, value), (1.0, value)]


def pieces(by: Walker, scene: Scene, runs: int, seed: int) -> None:
    """Stairs, gaps and bumps by themselves; bumps are other ones in each walk."""
    generator = np.random.default_rng(seed)
    stairs = Terrain([Stairs(rise=0.17, tread=0.3, count=5, start=2.5, landing=1.2)])
    for speed in (0.6, 0.9):
        found = walked(by, on(scene, stairs, 12.0), runs, seed, steady(speed), steady(0.0))
        print(f"five stairs of 17 cm up and down at {speed} m/s: {found.through.sum()} of {runs}")
    for width in (0.2, 0.25):
        gaps = Terrain([Gaps(width=width, depth=0.3, spacing=1.1, count=5, start=2.5)])
        found = walked(by, on(scene, gaps, 16.0), runs, seed, steady(0.7), steady(0.0))
        print(f"five gaps of {100 * width:.0f} cm, one each 1.1 m, at 0.7 m/s: {found.through.sum()} of {runs}")
    for speed in (0.8, 1.2):
        upright = 0
        for run in range(runs):
            bumps = Terrain([Rough(height=0.05, spacing=0.3, seed=1000 + run)], z=float(generator.uniform(0.0, 9.0)))
            one = walked(by, on(scene, bumps, 10.0), 1, seed + run, steady(speed), steady(0.0))
            upright += int(one.through[0])
        print(f"bumps of 5 cm, other ones in each walk, at {speed} m/s: {upright} of {runs}")


def main(
    policy: Annotated[Path, typer.Argument(help="result file with the policy")],
    scene: Annotated[Path, typer.Argument(help="scene that it was learnt in")],
    figure: Annotated[Path | None, typer.Option("--output", "-o", help="picture of the course")] = None,
    runs: Annotated[int, typer.Option(help="walks with noise")] = 20,
    seed: Annotated[int, typer.Option(help="of the noise")] = 1,
    tests: Annotated[str, typer.Option(help="course, pieces, or both")] = "course,pieces",
) -> None:
    """Walk, and say what came of it."""
    body = wm.load(str(scene))
    by = walker(policy, body)
    if "course" in tests:
        course(by, body, runs, seed, figure)
    if "pieces" in tests:
        pieces(by, body, runs, seed)


if __name__ == "__main__":
    run_script(main)
