"""What commands print: results on the standard output, all else on the error stream."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape

if TYPE_CHECKING:
    from warpmuscle.gait import Gait
    from warpmuscle.recording import Recording
    from warpmuscle.scene import Scene

out = Console(soft_wrap=True, highlight=False)
log = Console(stderr=True, soft_wrap=True, highlight=False)

INTERRUPTED = 130  # exit code after Ctrl-C where there is nothing to keep


def print_ignored(ignored: list[Any], heading: str) -> None:
    """On the error stream, what was not used, a line for each file and reason."""
    from warpmuscle.formats.load import summary

    if ignored:
        log.print(f"[yellow]{escape(summary(ignored, heading))}[/]")


def print_gait(scene: Scene, recording: Recording) -> Gait | None:
    """Print speed, step length and cadence of a scene with a controller."""
    from warpmuscle.gait import measure

    if scene.controller is None or recording.frames == 0:
        return None
    gait = measure(recording, *scene.controller.feet)
    text = f"speed {gait.speed_forward:.3f} m/s"
    if gait.step_length is not None and gait.cadence is not None:
        text += f", step length {gait.step_length:.3f} m, cadence {gait.cadence:.1f} steps/min"
    out.print(f"{text} (from {gait.start:.3g} s to {gait.end:.3g} s, {gait.steps} steps)")
    return gait
