"""Kills a training again and again, by SIGKILL, resumes it, and compares what it comes to with one that nobody killed.

    python tools/kill_trainings.py --kills 20

A quarter of the kills hit a process that starts or reads the files; the rest come at random within the time that it
learns and writes checkpoints. The same policy, curve, motion and state of the training are wanted, to the last bit.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ITERATIONS = 2000
DURATION = 0.4  # s, of an episode
INTERVAL = 0.05  # s of wall time between two checkpoints
LEARNS, LEARNT = "learns", "has learnt"  # what a process says at its first iteration and at its last
EARLY = 0.25  # part of the kills that come before that
LONGEST = 1.0  # s, that a process may learn before it is killed
PART = 0.5  # of the time that it takes to learn, beyond which it is not waited for: the next one may be quicker


def train(path: Path, iterations: int) -> None:
    """Begin the training of a file, or go on with it."""
    import msgspec

    from warpmuscle.formats import load
    from warpmuscle.learning.options import PPOOptions
    from warpmuscle.learning.progress import TrainingProgress
    from warpmuscle.learning.training import learn, resume
    from warpmuscle.results.training_file import training_path
    from warpmuscle.scene.learning import Task, Variation

    told = False

    def tell(progress: TrainingProgress) -> None:
        nonlocal told
        if progress.iterations and not told:
            told = True
            print(LEARNS, flush=True)
        if progress.iterations == iterations:
            print(LEARNT, flush=True)

    if training_path(path).exists():
        resume(path, iterations=iterations, threads=1, interval=INTERVAL, progress=tell)
        return
    scene = msgspec.structs.replace(load("reflex_planar"), duration=DURATION)
    options = PPOOptions(instances=4, steps=6, epochs=2, minibatches=2, hidden=(16, 16))
    task = Task(variation=Variation(velocity_noise=0.05))
    learn(
        scene, path, task=task, options=options, device="cpu", iterations=iterations, threads=1, interval=INTERVAL,
        progress=tell,
    )  # fmt: skip


def process(path: Path, iterations: int) -> subprocess.Popen[str]:
    """A process that trains."""
    command = [sys.executable, __file__, "--train", str(path), "--iterations", str(iterations)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def killed(path: Path, iterations: int, random: np.random.Generator, starting: float, learning: float) -> bool:
    """Train until a kill at a random moment; whether it came before the training ended.

    Args:
        starting, learning: s, that a process takes to start, and then to learn all.
    """
    child = process(path, iterations)
    assert child.stdout is not None
    if random.uniform() < EARLY:
        time.sleep(random.uniform(0.0, starting))
    else:
        child.stdout.readline()
        time.sleep(random.uniform(0.0, min(LONGEST, PART * learning)))
    child.kill()  # SIGKILL
    child.communicate()
    return child.returncode < 0


def ended(path: Path, iterations: int) -> tuple[float, float]:
    """Train to the end; s, until it learnt and that it learnt.

    Raises:
        RuntimeError: it failed; with what the process said.
    """
    begin = time.monotonic()
    child = process(path, iterations)
    assert child.stdout is not None
    child.stdout.readline()
    starting = time.monotonic() - begin
    child.stdout.readline()
    learning = time.monotonic() - begin - starting
    _, said = child.communicate()
    if child.returncode:
        raise RuntimeError(said[-2000:])
    return starting, learning


def differences(one: Path, other: Path) -> list[str]:
    """What two trainings have come to that is not the same, by name; times of the clock may differ."""
    from warpmuscle.results.result import read
    from warpmuscle.results.training_file import read_training, training_path

    (first, state), (second, other_state) = (read_training(training_path(path)) for path in (one, other))
    found = [name for name in state if not np.array_equal(state[name], other_state[name])]
    found += sorted(set(state) ^ set(other_state))
    assert first.learned is not None
    assert second.learned is not None
    for k, (a, b) in enumerate(zip(first.learned.policy.layers, second.learned.policy.layers, strict=True)):
        if not (np.array_equal(a.weight, b.weight) and np.array_equal(a.bias, b.bias)):
            found.append(f"layer {k}")
    curve, again = first.learned.curve, second.learned.curve
    found += [f"curve {n}" for n in curve if n != "wall_time" and not np.array_equal(curve[n], again[n])]
    motions = [read(path).replays[0].coordinate for path in (one, other)]
    return found if np.array_equal(*motions) else [*found, "motion"]


def killed_and_resumed(folder: Path, kills: int, iterations: int, seed: int) -> tuple[int, list[str]]:
    """Kill a training so often; how many kills hit it, and what then differs from one that nobody killed."""
    random, whole, broken = np.random.default_rng(seed), folder / "whole.h5", folder / "broken.h5"
    (starting, learning), hits = ended(whole, iterations), 0
    while hits < kills and killed(broken, iterations, random, starting, learning):
        hits += 1
    ended(broken, iterations)
    return hits, differences(whole, broken)


def main() -> None:
    """Print what became of it; exit with 1 if anything differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--iterations", type=int, default=ITERATIONS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--train", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.train is not None:
        train(given.train, given.iterations)
        return
    with tempfile.TemporaryDirectory() as folder:
        hits, found = killed_and_resumed(Path(folder), given.kills, given.iterations, given.seed)
    print(f"{hits} kills; {'the same bits' if not found else 'other: ' + ', '.join(found)}")
    if found or hits < given.kills:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
