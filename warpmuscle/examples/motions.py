"""Motions that are made rather than recorded: throws and a lift of an arm, and walks of our own simulation."""

from __future__ import annotations

import io
import tempfile
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from warpmuscle.core.array_types import Floats

TIME = np.arange(0.0, 1.5001, 0.01)  # s
COLUMNS = (
    "time_s", "shoulder_deg", "elbow_deg", "wrist_deg", "trunk_pitch_deg", "shoulder_forward_m", "shoulder_up_m",
)  # fmt: skip


def glide(begin: float, end: float) -> Floats:
    """From 0 before a time, s, to 1 after another one, with the least jerk between (Flash and Hogan 1985)."""
    x = np.clip((TIME - begin) / (end - begin), 0.0, 1.0)
    return np.asarray(x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


def throw(late: float, far: float) -> Floats:
    """An overhead throw, a row a sample of `COLUMNS`, some time later, s, and of some larger amplitude."""
    shoulder = 20.0 + (45.0 + 10.0 * far) * glide(0.0, 0.85 + late) + 75.0 * glide(0.35 + late, 1.25 + late)
    elbow = 85.0 + 20.0 * glide(0.1, 0.75 + late) - (85.0 + 5.0 * far) * glide(0.62 + late, 1.25 + late)
    wrist = 10.0 - 35.0 * glide(0.25, 0.85 + late) + (60.0 + 5.0 * far) * glide(0.8 + late, 1.3 + late)
    trunk = 12.0 - 16.0 * glide(0.4 + late, 1.2 + late)
    return np.column_stack([TIME, shoulder, elbow, wrist, trunk, 0.06 * glide(0.3, 1.2), 1.42 + 0.2 * glide(0.5, 1.1)])


THROWS = tuple(throw(late, far) for late, far in ((0.0, 0.0), (0.05, 0.5), (-0.05, 1.0), (0.02, -0.5)))
LIFT = np.column_stack(
    [
        TIME,
        15.0 + 60.0 * glide(0.1, 1.3),
        30.0 + 70.0 * glide(0.1, 1.1),
        5.0 - 10.0 * glide(0.3, 1.2),
        3.0 - 3.0 * glide(0.1, 1.2),
        0.02 * glide(0.1, 1.2),
        1.45 + 0.01 * glide(0.1, 1.2),
    ]
)


def table(rows: Floats, names: Sequence[str] = COLUMNS) -> str:
    """Comma-separated values."""
    text = io.StringIO()
    np.savetxt(text, rows, delimiter=",", fmt="%.5f", comments="", header=",".join(names))
    return text.getvalue()


def tracked_gait() -> bytes:
    """Joints of the legs of the shipped walk over the gait cycle, as an `.npz` file that a scene can track."""
    from warpmuscle.formats import load
    from warpmuscle.gait.cycles import over_strides, steady_strides
    from warpmuscle.simulation.rollout import Rollout

    scene = load("walk56_human")
    rollout = Rollout(scene, 1, "cpu", record=[0])
    rollout.run()
    recording = rollout.recording()
    cycles = steady_strides(recording, scene)["left"]
    arrays = {"cycle": np.linspace(0.0, 1.0, 101)}
    for joint in ("lHip", "lKnee", "lAnkle", "rHip", "rKnee", "rAnkle"):
        turns = recording.joint_orientation[:, recording.joint_names.index(joint)]
        mean = over_strides(recording.time, turns, cycles).mean(axis=0)  # of turns that differ little
        arrays[joint] = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    file = io.BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]  # its stubs know no names from a table
    return file.getvalue()


def opensim_model() -> Iterable[tuple[str, bytes]]:
    """An arm of our own as `convert` writes it for OpenSim."""
    from importlib import resources

    source = resources.files("warpmuscle.examples") / "files" / "arm_scene.toml"
    with resources.as_file(source) as scene:
        return converted(str(scene), "arm.osim")


def simbicon_files() -> Iterable[tuple[str, bytes]]:
    """The shipped torque-driven walk as `convert` writes it for the original program."""
    return converted("fwalk", "walk.rbs")


def converted(scene: str, name: str) -> list[tuple[str, bytes]]:
    """The files that a scene is written into for another program."""
    from warpmuscle.formats import save

    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what these files cannot hold is none of the example
        save(scene, Path(folder) / name)
        return [(path.name, path.read_bytes()) for path in sorted(Path(folder).iterdir())]
