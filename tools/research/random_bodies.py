"""How many of 1000 random bodies walk with the gait of one: unchanged, with gains by size, and after a search.

For docs/how-to/bodies.md.

Example: python tools/research/random_bodies.py fwalk --bodies 1000 --search 500 --json bodies.json
"""

import argparse
import json
import time
from functools import partial
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.optimization.options import MakeBatches
from warpmuscle.optimization.progress import Tracker
from warpmuscle.optimization.run import make_search_loop
from warpmuscle.results.records import SearchOptions, best_of
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import with_values
from warpmuscle.scene.sizes.batch_scene import batch_scene
from warpmuscle.scene.sizes.sized import height_of, sized
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.sweep.shared_batches import run_in_one_batch
from warpmuscle.sweep.union import searched_scenes, weighed_scenes

HEIGHT, MASS_INDEX, MASS = (1.2, 2.0), (12.5, 32.5), (18.0, 130.0)  # m, kg/m^2, kg
ARMS, TRUNK = (0.9, 1.2), (0.9, 1.3)  # factors on the arms' length, and on the trunk's mass
AT_ONCE, POPULATION = 250, 20  # searches side by side, and candidates of a generation of each
PATTERNS = {"arms": "*arm", "trunk": "torso"}


def drawn(count: int, seed: int) -> list[dict[str, float]]:
    """Heights, masses and proportions."""
    generator = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        height, index = generator.uniform(*HEIGHT), generator.uniform(*MASS_INDEX)
        mass = index * height**2
        if MASS[0] <= mass <= MASS[1]:
            found.append(
                {"height": height, "mass": mass, "arms": generator.uniform(*ARMS), "trunk": generator.uniform(*TRUNK)}
            )
    return found


def walked(scene: Scene, bodies: list[dict[str, float]], gait: bool, seconds: float, device: str | None) -> dict:
    """Which of the bodies last, and how fast they walk."""
    scene = msgspec.structs.replace(scene, duration=seconds)
    return tried(scene, [made(scene, one, gait) for one in bodies], device)


def made(scene: Scene, one: dict[str, float], gait: bool = True) -> Scene:
    """The scene with a body of this size."""
    arms, trunk = {PATTERNS["arms"]: one["arms"]}, {PATTERNS["trunk"]: one["trunk"]}
    return sized(scene, one["height"], one["mass"], lengths=arms, masses=trunk, gait=gait)


def tried(scene: Scene, sized_scenes: list[Scene], device: str | None) -> dict:
    """Which of these scenes last, all in one batch."""
    rollout = Rollout(scene, len(sized_scenes), device)
    rollout.change(batch_scene(sized_scenes))
    rollout.reset()
    begun, start = time.perf_counter(), rollout.state.coordinates.numpy()[:, [0, 2]].astype(float)
    rollout.run()
    way = rollout.state.coordinates.numpy()[:, [0, 2]].astype(float) - start
    status, end = rollout.status(), rollout.end_time()
    return {
        "upright": (status == Status.COMPLETED).tolist(),
        "speed": (np.linalg.norm(way, axis=1) / np.maximum(end, 1e-9)).tolist(),
        "seconds": time.perf_counter() - begun,
    }


def searched(
    scene: Scene, bodies: list[dict[str, float]], before: dict, candidates: int, seconds: float, device: str | None
) -> dict:
    """The same after a search of so many candidates for each body that falls with gains by size; the others stay."""
    scene, begun = msgspec.structs.replace(scene, duration=seconds), time.perf_counter()
    falling = np.flatnonzero(~np.array(before["upright"]))
    found = {name: list(before[name]) for name in ("upright", "speed")}
    scenes: list[Scene] = []
    for first in range(0, len(falling), AT_ONCE):
        part = falling[first : first + AT_ONCE]
        sized_scenes = [made(scene, bodies[number]) for number in part]
        scenes += side_by_side(sized_scenes, [1 + int(number) for number in part], candidates, device)
        print(f"searched for {len(scenes)} of {len(falling)} bodies", flush=True)
    if scenes:
        again = tried(scene, scenes, device)
        for name in found:
            for number, value in zip(falling, again[name], strict=True):
                found[name][number] = value
    return {**found, "seconds": time.perf_counter() - begun}


def side_by_side(scenes: list[Scene], seeds: list[int], candidates: int, device: str | None) -> list[Scene]:
    """Each scene with the best values that a search of its own found; all searches are in the same batches."""
    weighed = [one for one in searched_scenes(weighed_scenes(scenes)) if isinstance(one, Scene)]
    assert len(weighed) == len(scenes)
    found = list(scenes)

    def search(number: int, batches: MakeBatches) -> None:
        options = SearchOptions("cma", candidates=candidates, population=POPULATION)
        loop = make_search_loop(weighed[number], seeds[number], options, (), batches, Tracker(candidates, None, None))
        loop.run(lambda generation: None)
        best = best_of(loop.evaluations())
        if best is not None:
            found[number] = with_values(weighed[number], np.asarray(best.params, dtype=float))

    errors = run_in_one_batch(weighed, [partial(search, number) for number in range(len(weighed))], device, None)
    for error in errors:
        if error is not None:
            raise error
    return found


def figure(bodies: list[dict[str, float]], found: dict[str, dict], file: Path) -> None:
    """Which bodies walk, over height and mass."""
    import matplotlib.pyplot as plt

    fig, axes = plt.subplots(1, len(found), figsize=(4.6 * len(found), 4.2), sharey=True, layout="constrained")
    height, mass = (np.array([one[name] for one in bodies]) for name in ("height", "mass"))
    for ax, (name, one) in zip(np.atleast_1d(axes), found.items(), strict=True):
        upright = np.array(one["upright"])
        ax.scatter(height[~upright], mass[~upright], s=9, color="#c8502d", label="falls", linewidths=0)
        ax.scatter(height[upright], mass[upright], s=9, color="#2f69cf", label="walks", linewidths=0)
        ax.set_title(f"{name}: {100.0 * upright.mean():.0f} % walk", fontsize=10)
        ax.set_xlabel("height, m")
    np.atleast_1d(axes)[0].set_ylabel("mass, kg")
    np.atleast_1d(axes)[0].legend(frameon=False, fontsize=8)
    fig.savefig(file, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a gait of the biped: fwalk, walk56, ...")
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--search", type=int, default=0, help="candidates for each body that falls; 0: no search")
    parser.add_argument("--device")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    scene, bodies = load(given.scene), drawn(given.bodies, given.seed)
    print(f"{given.scene}: its own body is {height_of(scene):.2f} m high")
    found: dict[str, dict] = {}
    steps = {
        "unchanged": lambda: walked(scene, bodies, False, given.seconds, given.device),
        "gains by size": lambda: walked(scene, bodies, True, given.seconds, given.device),
        f"{given.search} candidates": lambda: searched(
            scene, bodies, found["gains by size"], given.search, given.seconds, given.device
        ),
    }
    for name, step in list(steps.items())[: 3 if given.search else 2]:
        found[name] = step()
        share, speed = np.mean(found[name]["upright"]), np.array(found[name]["speed"])[found[name]["upright"]]
        shown = f"{speed.min():.2f} to {speed.max():.2f} m/s" if len(speed) else "none"
        print(
            f"{name}: {100.0 * share:.1f} % walk {given.seconds:g} s, {shown}; {found[name]['seconds']:.1f} s of wall",
            flush=True,
        )
    if given.json is not None:
        given.json.write_text(json.dumps({"bodies": bodies, "found": found}, indent=1) + "\n")
    if given.figure is not None:
        figure(bodies, found, given.figure)


if __name__ == "__main__":
    main()
