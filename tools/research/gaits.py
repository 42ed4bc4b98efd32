"""Gaits of the shipped scenes against the recordings of the original program.

For docs/explanation/gaits.md.

python tools/research/gaits.py                   table in Markdown: 60 s at 1/2000 s, and at 1/500 s with implicit PD
python tools/research/gaits.py --pictures FOLDER   also stick figures of every gait
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec
import typer
import warp as wp

import warpmuscle as wm
from warpmuscle.cli.ending import run_script
from warpmuscle.core.status import Status
from warpmuscle.plots.stick_figures import stick_figures

# Speed (m/s), step length (m), cadence (steps/min) of the original program with ODE, from 5 to 20 s.
ORIGINAL = {
    "fwalk": (0.954, 0.544, 105.3),
    "iwalk": (0.012, 0.006, 120.0),
    "bwalk": (-0.605, -0.281, 129.2),
    "fjog": (1.494, 0.591, 149.8),
    "bigbird_walk": (0.942, 0.355, 151.2),
}


def main(
    duration: Annotated[float, typer.Option(help="Simulated time, s.")] = 60.0,
    pictures: Annotated[Path | None, typer.Option(help="Folder for stick figures.")] = None,
) -> None:
    """Simulate every gait and print how it walks."""
    wp.config.log_level = wp.LOG_WARNING
    print("| gait | | speed, m/s | step length, m | cadence, steps/min |\n|---|---|---|---|---|")
    for name, original in ORIGINAL.items():
        print(f"| `{name}` | original | {original[0]:.3f} | {original[1]:.3f} | {original[2]:.1f} |")
        for label, time_step, implicit in (("1/2000 s", 0.0005, False), ("1/500 s, implicit PD", 0.002, True)):
            scene = msgspec.structs.replace(wm.load(name), duration=duration, time_step=time_step, implicit_pd=implicit)
            rollout = wm.Rollout(scene, 1, "cpu", record=[0])
            rollout.run()
            assert scene.controller is not None
            gait = wm.measure(rollout.recording(), *scene.controller.feet, by="stance")
            status = Status(rollout.status()[0])
            note = "" if status == Status.COMPLETED else f" ({status.meaning} at {rollout.end_time()[0]:.1f} s)"
            figures = f"{gait.speed_forward:.3f} | {gait.step_length or 0.0:.3f} | {gait.cadence or 0.0:.1f}"
            print(f"| | {label}{note} | {figures} |", flush=True)
            if pictures is not None and not implicit:
                stick_figures(rollout.recording(), scene, pictures / f"{name}.png", gait)


if __name__ == "__main__":
    run_script(main)
