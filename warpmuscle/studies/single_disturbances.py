"""What fells a gait: each disturbance of a judgement by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpmuscle.scene import Robustness
from warpmuscle.simulation.perturbations import Perturbations, drawn, none
from warpmuscle.studies.verdicts import RUNS
from warpmuscle.studies.walkers import Walker

NOISE, MASS, SEED = 0.1, 0.1, 3  # m/s at the start, part of each body's mass
ASIDE, HILL = 40.0, 2.0  # N s, deg


def felled_by(walker: Walker, duration: float) -> dict[str, int]:
    """How many of 20 runs of a duration, s, each disturbance fells by itself, by its description."""
    scene = walker.scene()
    bodies = len(scene.character.bodies)
    noise = drawn(Robustness(runs=RUNS + 1, velocity_noise=NOISE, seed=SEED), duration, bodies).part(slice(1, None))
    light = drawn(Robustness(runs=RUNS + 1, mass=MASS, seed=SEED), duration, bodies).part(slice(1, None))
    still = none(RUNS)
    start = np.linspace(0.2, 0.5, RUNS) * duration
    aside = np.where(np.arange(RUNS) % 2 == 0, ASIDE, -ASIDE)[:, None] * [1.0, 0.0, 0.0]
    ahead = np.where(np.arange(RUNS) % 2 == 0, ASIDE, -ASIDE)[:, None] * [0.0, 0.0, 1.0]
    tried = {
        f"noise of {NOISE:g} m/s": noise,
        f"masses +-{100.0 * MASS:g} %": light,
        f"{ASIDE:g} N s from the side": replace(still, push=aside, push_start=start),
        f"{ASIDE:g} N s from behind or in front": replace(still, push=ahead, push_start=start),
        f"{HILL:g} degrees up": replace(noise, slope=np.full(RUNS, np.radians(HILL)), velocity=0.2 * noise.velocity),
        f"{HILL:g} degrees down": replace(noise, slope=np.full(RUNS, -np.radians(HILL)), velocity=0.2 * noise.velocity),
    }
    factors = [np.ones((RUNS, bodies)) if one.mass is None else one.mass for one in tried.values()]
    velocity, push, push_start, slope = (
        np.concatenate([getattr(one, name) for one in tried.values()])
        for name in ("velocity", "push", "push_start", "slope")
    )
    every = Perturbations(velocity, push, push_start, slope, mass=np.concatenate(factors))
    upright = walker.walk(duration, every).upright.reshape(len(tried), RUNS)
    return {name: int(RUNS - stood.sum()) for name, stood in zip(tried, upright, strict=True)}
