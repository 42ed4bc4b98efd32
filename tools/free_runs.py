"""What comparisons of free runs with other programs share: drawn excitations, our scene with them, and their table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from warpmuscle.scene import Excitation, Failure, Scene

Floats = NDArray[np.float64]
START, MOST = 0.05, 0.5  # excitation at first, and the most that is drawn
KNOTS, FRAMES = 3, 50
EARLY = 0.1  # s, in which runs have hardly come apart


def drawn(muscles: Sequence[str], seconds: float, seed: int) -> tuple[Floats, dict[str, Floats]]:
    """Times (KNOTS,) and excitations of each muscle at them."""
    values = np.random.default_rng(seed).uniform(0.0, MOST, (len(muscles), KNOTS))
    values[:, 0] = START
    return np.linspace(0.0, seconds, KNOTS), dict(zip(muscles, values, strict=True))


def excited(scene: Scene, times: Floats, values: dict[str, Floats], seconds: float, step: float) -> Scene:
    """The scene with these excitations, which nothing ends early."""
    muscles = {
        name: msgspec.structs.replace(muscle, excitation=Excitation(times.tolist(), values[name].tolist()))
        if name in values else muscle
        for name, muscle in scene.character.muscles.items()
    }  # fmt: skip
    return msgspec.structs.replace(
        scene,
        character=msgspec.structs.replace(scene.character, muscles=muscles),
        muscle_model=msgspec.structs.replace(scene.muscle_model, initial_activation=START),
        failure=Failure(com_height=0.0, heading=0.0), duration=seconds, time_step=step,
    )  # fmt: skip


def differences(off: Floats, theirs: Floats, names: Sequence[str], moments: Floats) -> list[str]:
    """Cells of how far coordinates (n, F) are off, of what they move by, which one is, and when; and how far early."""
    at, column = divmod(int(off.argmax()), len(names))
    moved = np.abs(theirs - theirs[0]).max()
    farthest = f"{off.max():.2g} of {moved:.2g}, {names[column]} at {moments[at]:.2f} s"
    return [farthest, f"{off[moments <= EARLY + 1e-9].max():.1g}"]


def show_table(columns: Sequence[str], rows: Iterator[str], output: Path | None) -> None:
    """Print rows of a table as they come, and write what there is of it to a file."""
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for line in rows:
        lines.append(line)
        print(line, flush=True)
        if output is not None:
            output.write_text("\n".join(lines) + "\n")
