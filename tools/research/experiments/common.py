"""What the experiments share: running a scene, storing recordings, angles, and the style of the figures.

For docs/explanation/muscles.md.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any

try:
    import matplotlib
except ModuleNotFoundError:
    raise SystemExit("experiments draw figures by matplotlib: pip install 'warpmuscle[plot]'") from None
import msgspec
import numpy as np
import typer
import warp as wp

import warpmuscle as wm
from warpmuscle.core.pose import rotate, twist_angle
from warpmuscle.formats import toml
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.results.result import write
from warpmuscle.scene import Actuation, Scene
from warpmuscle.scene.parameters import free_parameters

matplotlib.use("agg")
import matplotlib.pyplot as plt

from warpmuscle.cli.ending import run_script

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#404040")  # Okabe and Ito
STYLE: dict[str, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


def run(scene: Scene, duration: float, rate: float = 200.0) -> Recording:
    """The motion of a scene over so many seconds, with so many frames a second."""
    rollout = wm.Rollout(msgspec.structs.replace(scene, duration=duration), 1, "cpu", record=[0], record_rate=rate)
    rollout.run()
    return rollout.recording()


def on_torques(scene: Scene) -> Scene:
    """The same scene with torques in place of all muscles."""
    joints = {name: Actuation("torque") for name in scene.character.joints}
    return msgspec.structs.replace(scene, actuation=joints)


def angle(motion: Recording, joint: str, axis: Sequence[float]) -> Any:
    """Turn of a joint's child about an axis, (F,), rad."""
    return np.unwrap(twist_angle(motion.joint_orientation[:, motion.joint_names.index(joint)], axis))


def target(motion: Recording, joint: str, axis: Sequence[float]) -> Any:
    """The same of the controller's target."""
    return np.unwrap(twist_angle(motion.joint_target[:, motion.joint_names.index(joint)], axis))


def axis_in_world(motion: Recording, body: str, axis: Sequence[float]) -> Any:
    """An axis of a body in the world, over the frames, (F, 3)."""
    return rotate(motion.body_orientation[:, motion.body_names.index(body)], np.array(axis))


def store(path: Path, scene: Scene, *motions: Recording) -> None:
    """Write motions of a scene, or of variants of it, into one HDF5 file."""
    table = parameter_table(free_parameters(scene))
    write(path, Result(toml.dumps(scene), "cpu", " ".join(["python", *sys.argv]), 0, table, replays=motions))
    print(f"wrote {path}")


def panels(rows: int, columns: int, width: float, height: float, **further: Any) -> Any:
    """A figure and its axes."""
    return plt.subplots(rows, columns, figsize=(width, height), layout="constrained", **further)


def draw(path: Path, figure: Any, title: str) -> None:
    """Write a figure."""
    figure.suptitle(title, fontweight="bold", fontsize=11)
    figure.savefig(path, dpi=110)
    plt.close(figure)
    print(f"wrote {path}")


def main(experiment: Callable[[Path], None]) -> None:
    """Run an experiment, a function of the folder that its files go to, as a command."""

    def command(folder: Annotated[Path, typer.Option(help="Where the HDF5 file and the figure go.")] = Path()) -> None:
        wp.config.log_level = wp.LOG_WARNING
        folder.mkdir(parents=True, exist_ok=True)
        with plt.rc_context(STYLE):
            experiment(folder)

    command.__doc__ = experiment.__doc__
    run_script(command)
