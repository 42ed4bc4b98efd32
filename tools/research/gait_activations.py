"""Activations of walks beside one person's EMG over the gait cycle (Santuz 2019, doi 10.1016/j.isci.2019.100796).

For docs/explanation/gaits.md.

python tools/research/gait_activations.py walk56_person walk56_commands
                                                      how alike the two curves of each muscle are, in Markdown
python tools/research/gait_activations.py walk56_person --figure activations.png
                                                      also the curves themselves
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import typer

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.gait.cycles import PERCENT, over_strides, steady_strides
from warpmuscle.gait.foot_contact import SIDES
from warpmuscle.results.recording import Recording
from warpmuscle.scene.parameters import at_start

DATA = Path(os.environ.get("WARPMUSCLE_REFERENCE_DATA", "../shared/data"))
TRIAL = Path("santuz_walking_synergies/filt_emg_ID0012_TW_01.csv")
CYCLES = Path("santuz_walking_synergies/cycles_ID0012_TW_01.csv")
STANCE_POINTS = 100  # of a cycle in that file; as many are of its swing
# Our muscle, and the recorded ones that do the same.
SAME = {
    "GLU": ("MA",), "HipAbd": ("ME", "FL"), "HAM": ("ST", "BF"), "VAS": ("VM", "VL"), "SOL": ("SO", "GM", "GL"),
    "TA": ("TA",), "OUT": ("PL",),
}  # fmt: skip
DURATION = 15.0  # s


def emg(data: Path = DATA) -> dict[str, Floats]:
    """Envelopes (101,) over the gait cycle by the name of our muscle, each over its maximum."""
    try:
        with (data / TRIAL).open() as lines:
            names = lines.readline().strip().split(",")
        rows = np.loadtxt(data / TRIAL, delimiter=",", skiprows=1)
        steps = np.loadtxt(data / CYCLES, delimiter=",", skiprows=1)
    except OSError as error:
        why = f"{error.strerror or error}: {error.filename or data / TRIAL}"
        raise Error(f"no EMG to compare with: {why}; set WARPMUSCLE_REFERENCE_DATA") from None
    stance = float(np.mean((steps[:-1, 1] - steps[:-1, 0]) / np.diff(steps[:, 0])))
    points = 2 * STANCE_POINTS
    mean = rows[:, 1:].reshape(-1, points, len(names) - 1).mean(axis=0)
    part = (np.arange(STANCE_POINTS) + 0.5) / STANCE_POINTS
    at = 100.0 * np.concatenate([stance * part, stance + (1.0 - stance) * part])
    found = {}
    for ours, theirs in SAME.items():
        curve = np.mean([mean[:, names.index(one) - 1] for one in theirs], axis=0)
        found[ours] = _scaled(np.interp(PERCENT, at, curve, period=100.0))
    return found


def activation(name: str) -> dict[str, Floats]:
    """The same of a shipped walk or a TOML file: mean of both sides over its steady gait cycles."""
    scene = msgspec.structs.replace(wm.load(name), duration=DURATION)
    batch = wm.Rollout(scene, 1, "cpu", record=[0], record_rate=200.0)
    batch.run()
    recording: Recording = batch.recording(0)
    numeric = at_start(scene)
    strides = steady_strides(recording, numeric)
    found = {}
    for ours in SAME:
        curves = [
            over_strides(
                recording.time,
                recording.muscle_activation[:, recording.muscle_names.index(side[0] + ours)],
                strides[side],
            ).mean(axis=0)
            for side in SIDES
        ]
        found[ours] = _scaled(np.mean(curves, axis=0))
    return found


def likeness(ours: Floats, theirs: Floats) -> float:
    """Correlation of two curves over the cycle."""
    return float(np.corrcoef(ours[:-1], theirs[:-1])[0, 1])


def _scaled(curve: Floats) -> Floats:
    return curve / max(float(curve.max()), 1e-9)


def main(
    scenes: Annotated[list[str], typer.Argument(help="Shipped walks or TOML files.")],
    figure: Annotated[Path | None, typer.Option(help="File for the curves.")] = None,
    data: Annotated[Path, typer.Option(help="Folder with the EMG.")] = DATA,
) -> None:
    """Compare activations with EMG."""
    theirs = emg(data)
    walks = {name: activation(name) for name in scenes}
    print("| muscle | recorded | " + " | ".join(f"`{Path(name).stem}`" for name in scenes) + " |")
    print("|---|---|" + "---|" * len(scenes))
    for muscle, names in SAME.items():
        row = " | ".join(f"{likeness(walk[muscle], theirs[muscle]):.2f}" for walk in walks.values())
        print(f"| {muscle} | {', '.join(names)} | {row} |")
    if figure is not None:
        _draw(figure, theirs, walks)


def _draw(path: Path, theirs: dict[str, Floats], walks: dict[str, dict[str, Floats]]) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    page, panels = plt.subplots(2, 4, figsize=(11, 4.8), sharex=True, sharey=True, layout="constrained")
    shown: Any = panels.flat
    for axes, muscle in zip(shown, SAME, strict=False):
        axes.fill_between(PERCENT, theirs[muscle], color="0.85", label="EMG")
        for name, walk in walks.items():
            axes.plot(PERCENT, walk[muscle], label=Path(name).stem)
        axes.set(title=f"{muscle} ({', '.join(SAME[muscle])})", xlim=(0, 100), ylim=(0, 1.05))
    panels[1, 3].axis("off")
    panels[1, 3].legend(*panels[0, 0].get_legend_handles_labels(), loc="center")
    page.supxlabel("gait cycle (%)")
    page.supylabel("over its maximum")
    page.savefig(path, dpi=110)


if __name__ == "__main__":
    run_script(main)
