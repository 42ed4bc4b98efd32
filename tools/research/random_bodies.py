"""How many of 1000 random bodies walk with the gait of one: unchanged, and with gains, times and speeds by size.

For docs/how-to/bodies.md.

Example: python tools/research/random_bodies.py fwalk --bodies 1000 --json bodies.json
"""

import argparse
import json
import time
from pathlib import Path

import msgspec
import numpy as np

from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.scene.sizes.batch_scene import batch_scene
from warpmuscle.scene.sizes.sized import height_of, sized
from warpmuscle.simulation.rollout import Rollout

HEIGHT, MASS_INDEX, MASS = (1.2, 2.0), (12.5, 32.5), (18.0, 130.0)  # m, kg/m^2, kg
ARMS, TRUNK = (0.9, 1.2), (0.9, 1.3)  # factors on the arms' length, and on the trunk's mass
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
    made = [
        sized(
            scene, one["height"], one["mass"], lengths={PATTERNS["arms"]: one["arms"]},
            masses={PATTERNS["trunk"]: one["trunk"]}, gait=gait,
        )
        for one in bodies
    ]  # fmt: skip
    rollout = Rollout(scene, len(made), device)
    rollout.change(batch_scene(made))
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
    parser.add_argument("--device")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    given = parser.parse_args()
    scene, bodies = load(given.scene), drawn(given.bodies, given.seed)
    print(f"{given.scene}: its own body is {height_of(scene):.2f} m high")
    found = {}
    for name, gait in (("unchanged", False), ("gains by size", True)):
        found[name] = walked(scene, bodies, gait, given.seconds, given.device)
        share, speed = np.mean(found[name]["upright"]), np.array(found[name]["speed"])[found[name]["upright"]]
        shown = f"{speed.min():.2f} to {speed.max():.2f} m/s" if len(speed) else "none"
        print(
            f"{name}: {100.0 * share:.1f} % walk {given.seconds:g} s, {shown}; {found[name]['seconds']:.1f} s of wall"
        )
    if given.json is not None:
        given.json.write_text(json.dumps({"bodies": bodies, "found": found}, indent=1) + "\n")
    if given.figure is not None:
        figure(bodies, found, given.figure)


if __name__ == "__main__":
    main()
