"""Scenes of objects among themselves, and their motions."""

from typing import Any

from warpmuscle.results.recording import Recording
from warpmuscle.scene import Body, Character, Failure, Ground, InitialState, Scene, Sphere
from warpmuscle.scene.objects.motion import ObjectMotion, is_recorded, object_motion
from warpmuscle.simulation.rollout import Rollout

STEP = 0.0005  # s
NOTHING, PLAIN = Ground(stiffness=0.0), Ground(stiffness=1e5, damping=1e3)


def together(objects: dict[str, Any], ground: Ground = NOTHING, duration: float = 0.4, gravity: float = 0.0) -> Scene:
    """Objects, and a body far from them."""
    body = Body(5.0, (0.05, 0.05, 0.05), [Sphere((0.0, 0.0, 0.0), 0.1)])
    return Scene(
        "together", Character("block", {"block": body}), initial_state=InitialState((9.0, 0.0999, 0.0)), ground=ground,
        objects=objects, failure=Failure(com_height=0.0, heading=0.0), duration=duration, gravity=gravity,
        time_step=STEP,
    )  # fmt: skip


def played(scene: Scene, rate: float = 500.0) -> tuple[Recording, dict[str, ObjectMotion]]:
    """The recording of a scene, and how its objects move."""
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=rate)
    rollout.run()
    recording = rollout.recording(0)
    return recording, {name: object_motion(recording, name) for name in scene.objects if is_recorded(recording, name)}
