"""Normalised curves of all muscle models in one figure.

For docs/explanation/muscles.md.

python tools/research/muscle_curves.py [FILE]       draws FILE, muscle_curves.png if not given
"""

from pathlib import Path
from typing import Annotated

import matplotlib.pyplot as plt
import numpy as np
import typer
import warp as wp

from warpmuscle.cli.ending import run_script
from warpmuscle.kernels.curve import curves

MODELS = {"Lee 2014": curves.LEE, "Thelen 2003": curves.THELEN, "Millard 2013": curves.MILLARD}
MODELS |= {"De Groote 2016": curves.DE_GROOTE, "Thelen, explicit": curves.THELEN_EXPLICIT}
MODELS["Sarshari 2018"] = curves.SARSHARI
STYLES = ("-", "--", "-", "-.", ":", "--")
PANELS = (  # function, further arguments, range of the axis, its label, title
    (curves.active_force_length, (), (0.2, 2.0), "fibre length / l_opt", "Active"),
    (curves.passive_force_length, (), (0.2, 1.7), "fibre length / l_opt", "Passive"),
    (curves.force_velocity, (1.0,), (-1.0, 1.0), "lengthening speed / v_max", "Force-velocity, full activation"),
    (curves.tendon_force_strain, (), (-0.01, 0.06), "tendon strain", "Tendon (Lee 2014 as Thelen 2003)"),
)


def main(file: Annotated[Path, typer.Argument(help="Picture to draw.")] = Path("muscle_curves.png")) -> None:
    """Draw the figure."""
    wp.config.log_level = wp.LOG_WARNING
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
    for panel, (function, further, limits, label, title) in zip(axes.flat, PANELS, strict=True):
        x = np.linspace(*limits, 1000)
        for (name, model), style in zip(MODELS.items(), STYLES, strict=True):
            force = wp.map(function, model, wp.array(x, dtype=float), *further).numpy()
            panel.plot(x, force, style, label=name)
        panel.set(xlabel=label, ylabel="force / f_max", title=title, xlim=limits)
        panel.locator_params(axis="x", nbins=7)
        panel.grid(alpha=0.3)
    axes[0, 0].legend(frameon=False)
    figure.savefig(file, dpi=150)


if __name__ == "__main__":
    run_script(main)
