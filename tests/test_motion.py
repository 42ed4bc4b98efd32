"""Prescribed motion: kinematic coordinates follow their curves, the others move as masses and forces demand."""

import numpy as np

from warpmuscle.rollout import Rollout
from warpmuscle.scene import Actuation, Body, Character, Failure, Joint, Motion, Scene

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
TIME = np.linspace(0.0, 1.0, 21)
MASS, INERTIA, LONG = 1.5, (0.02, 0.005, 0.03), 0.2
KINDS = {"hinge": [X], "universal": [Z, (1.0, 0.2, 0.0)], "ball": [X, Y]}


def chain(*drives: tuple[str, object], root: str = "fixed", **changes) -> Scene:
    """Bodies that hang one on the other, each on a joint of a type with what drives it."""
    bodies = {f"body{i}": Body(MASS, INERTIA) for i in range(len(drives) + 1)}
    joints = {
        f"joint{i}": Joint(kind, f"body{i}", f"body{i + 1}", (0.01, -LONG, 0.02), (0.0, LONG, 0.01), KINDS[kind])
        for i, (kind, _) in enumerate(drives)
    }
    scene = Scene("chain", Character("body0", bodies, joints, root), failure=Failure(0.0, 0.0))
    scene.actuation = {f"joint{i}": Actuation(drive) for i, (_, drive) in enumerate(drives)}
    scene.duration, scene.time_step = 1.0, 1.0 / 2000.0
    for field, value in changes.items():
        setattr(scene, field, value)
    return scene


def wave(count: int, amplitude: float = 0.5, seed: int = 0) -> np.ndarray:
    """Smooth values (count, times) of different frequencies and phases."""
    rng = np.random.default_rng(seed)
    return amplitude * np.sin(rng.uniform(2.0, 6.0, (count, 1)) * TIME + rng.uniform(0.0, 6.0, (count, 1)))


def history(scene: Scene, **inputs) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and speeds of every step."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=2000.0, quantities=["coordinates", "speeds"])
    rollout.run()
    return rollout.recorded("coordinates")[0].astype(float), rollout.recorded("speeds")[0].astype(float)


def test_hinge_follows_its_curve():
    angle = wave(1)[0]
    scene = chain(("hinge", "kinematic"), motion={"joint0": Motion(TIME.tolist(), angle.tolist())})
    q, v = history(scene)
    np.testing.assert_allclose(q[::100, -1], angle[:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(q[:, -1], 1 / 2000)[2:-2], v[2:-2, 0], atol=2e-3)
