"""Figures of gaits for `gait_table.py`: each by itself, and all beside the norms.

For docs/explanation/gait-tables.md.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warpmuscle.formats import toml
from warpmuscle.gait.cycles import PERCENT, leg_angles, over_strides, steady_strides
from warpmuscle.gait.ground_force import vertical_forces
from warpmuscle.gait.quality import runs, support_of
from warpmuscle.plots import KINDS, Absent, Choices, Subject, draw
from warpmuscle.plots.angles import angle_bands, legend_below, norm_band
from warpmuscle.plots.style import GRAY, cycle_axis, mean_and_spread, page, save, style
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result, parameter_table
from warpmuscle.scene import Scene
from warpmuscle.scene.norms import FORCE, LEG_ANGLES
from warpmuscle.scene.parameters import free_parameters

_FIGURES = ("sticks", "angles", "ground_force", "feet", "activation")
_ROW = 1.75  # inches


def draw_gait(folder: Path, name: str, recording: Recording, scene: Scene) -> None:
    """Draw all that shows a gait, as far as it has that: NAME_KIND.png in a folder, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    table = parameter_table(free_parameters(scene))
    result = Result(toml.dumps(scene), "cpu", "", 0, table, replays=(recording,))
    stem = re.sub(r"[^\w.=+-]", "_", Path(name).stem if name.endswith(".toml") else name)
    for kind in _FIGURES:
        assert kind in KINDS
        try:
            save(draw(Subject(result, Choices()), kind), folder / f"{stem}_{kind}.png")
        except Absent:
            continue


def compare(path: Path, motions: Mapping[str, tuple[Recording, Scene]]) -> None:
    """Draw the angles of the legs and the vertical ground force of several gaits, a row each, beside the norms.

    Args:
        motions: recordings with whole gait cycles, and their scenes without free parameters, by name.
    """
    with style():
        figure = page(_ROW * len(motions) + 0.6)
        rows = figure.subplots(len(motions), 4, sharex=True, sharey="col", squeeze=False)
        for axes, (name, (recording, scene)) in zip(rows, motions.items(), strict=True):
            _row(axes, recording, scene)
            axes[0].set_ylabel(f"{name}\nangle (deg)")
            axes[3].set_ylabel("force (body weights)")
        for axes, title in zip(rows[0], (*LEG_ANGLES, FORCE), strict=True):
            axes.set_title(title)
        for axes in rows[-1]:
            axes.set_xlabel("gait cycle (%)")
        rows[0, 3].set_ylim(0.0, 2.0)
        legend_below(figure, rows[0, 0])
    save(figure, path)


def _row(panels: Any, recording: Recording, scene: Scene) -> None:
    cycles = steady_strides(recording, scene)
    curves = {**leg_angles(recording, scene), FORCE: vertical_forces(recording, scene)}
    running = runs(scene, support_of(recording, scene, cycles))
    for axes, (name, sides) in zip(panels, curves.items(), strict=True):
        if name != FORCE:
            angle_bands(axes, name, running)
        elif not running:
            norm_band(axes, name)
        for side, values in sides.items():
            mean_and_spread(axes, PERCENT, over_strides(recording.time, values, cycles[side]), side)
        axes.axhline(0.0, color=GRAY, lw=0.6, zorder=0)
        cycle_axis(axes)
